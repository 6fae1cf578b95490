/// The report page in a real browser, by the page's test of itself (verify/pages/web/selftest.js).
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "reference/base/write_file.h"
#include "tests/catch.h"
#include "tests/verify/browser_tools.h"
#include "tests/verify/capture_tools.h"
#include "tests/verify/report_pages.h"

namespace {

using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;

TEST_CASE("page: in a browser it passes its own test, which sees every planted fault",
          "[verify][page][browser]") {
    if (!browser_is_here()) {
        if (std::getenv("SCOTTY_REQUIRE_BROWSER") != nullptr) FAIL("chromium is not installed");
        WARN("not run: chromium is not installed (Debian: chromium)");
        return;
    }
    Report odd =
        report();  // what a page must bear: sizes that differ, no variances, a hostile name
    odd.images[0].golden = picture(1, 48);
    odd.images[0].verdict.worst.clear();
    odd.images[1].image.variance.clear();
    odd.images[1].z.clear();
    odd.images[2].name = "</script><b>&\"x\"";
    Report failures = failing_report();  // of two images, so that one comes after the other
    failures.images[2] = failing_case("coil", 3);
    Report one = failing_report();  // to plant faults in, which are seen as well in one image
    one.images = {one.images[1]};
    const std::string failing = to_html(one);
    const std::string value = page_data(one.images[0])["pixels"]["new"];
    std::string spoiled = value;
    spoiled[spoiled.size() / 2] = spoiled[spoiled.size() / 2] == 'A' ? 'B' : 'A';
    const auto with = [&](const char* from, const char* to) { return replaced(failing, from, to); };
    const auto found = self_tests({
        {"passing", to_html(report())},
        {"failing", to_html(failures)},
        {"odd", to_html(odd)},
        {"value", replaced(failing, value, spoiled)},
        {"number", with("\"image\":[\"Infinity\",1.0,1.0]", "\"image\":[\"Infinity\",1.0,1.5]")},
        {"flip", with("event.key === 'f' || event.key === 'F'", "event.key === 'g'")},
        {"magnifier", with("const y = py + first + row;", "const y = py + first + row + 1;")},
        {"slider", with("split: state.split / 100", "split: 0.5")},
        {"overlay", with("!Number.isFinite(value) || value < 0", "Number.isNaN(value)")},
        {"z", with("value(one.z, one.new)", "value(one.new.variance, one.new)")},
        {"heat", with("z + maxZ", "z")},
        {"address", with("exposure: exposure || undefined", "exposure: undefined")},
        {"script", with("class Viewer {", "class Viewer {{")},
    });
    for (const char* good : {"passing", "failing", "odd"}) {
        CHECK_THAT(found.at(good), ContainsSubstring("selftest: passed"));
    }
    const auto fails = [&](const char* page, const char* because) {
        CHECK_THAT(found.at(page),
                   ContainsSubstring("selftest: FAILED") && ContainsSubstring(because));
    };
    fails("value", "spheres: checksum of new: expected");
    fails("number", "spheres: pixel 20, 50 channel 2, new as embedded: expected 1.5, found 1");
    fails("flip", "spheres: F flips to golden: expected golden, found new");
    fails("magnifier", "spheres: the middle of the magnifier");
    fails("slider", "spheres: split at 100, right");
    fails("overlay", "spheres: non-finite pixels are counted: expected 3, found 1");
    fails("z", "spheres: its z: expected");
    fails("heat", "spheres: the colour of the highest z: expected true, found false");
    fails("address", "spheres: and the exposure: expected -1.5, found 0");
    fails("script", "viewer is not defined");
}

/// Not a test: writes pages to look at to the folder that SCOTTY_PAGES names.
TEST_CASE("page: pages to look at", "[.][page-files]") {
    const char* folder = std::getenv("SCOTTY_PAGES");
    REQUIRE(folder != nullptr);
    scotty::reference::write_file(std::string(folder) + "/passing.html", to_html(report()));
    scotty::reference::write_file(std::string(folder) + "/failing.html", to_html(failing_report()));
}

}  // namespace
