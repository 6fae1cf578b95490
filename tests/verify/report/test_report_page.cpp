/// The report's forms with images in them: the page as text, JSON, JUnit, the table.
#include <nlohmann/json.hpp>
#include <pugixml.hpp>
#include <sstream>
#include <string>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/verify/report_pages.h"
#include "verify/pages/page.h"
#include "verify/report/failure_groups.h"

namespace {

using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;

const std::string kHostile = "</script><script>alert('1')</script><!-- part runs --><b>&\"x\"";

/// What the page's script reads.
nlohmann::json image_data(const std::string& page) {
    const std::string opening = R"(<script type="application/json" id="image-data">)";
    const std::size_t start = page.find(opening);
    REQUIRE(start != std::string::npos);
    const std::size_t end = page.find("</script>", start);
    return nlohmann::json::parse(page.substr(start + opening.size(), end - start - opening.size()));
}

std::size_t occurrences(const std::string& text, const std::string& word) {
    std::size_t count = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
        ++count;
    }
    return count;
}

TEST_CASE("page: the failures come first, each with its place and its commands", "[verify][page]") {
    const std::string page = to_html(failing_report());
    CHECK_THAT(page, ContainsSubstring("<title>3 failures: scotty verify</title>"));
    const std::size_t failures = page.find("id=\"failures\"");
    REQUIRE(failures != std::string::npos);
    CHECK(failures < page.find("id=\"images\""));
    CHECK(failures < page.find("id=\"scenes\""));
    CHECK(page.find("id=\"scenes\"") < page.find("id=\"runs\""));
    CHECK_THAT(page, ContainsSubstring(
                         "launch 2 bounce0/level0/intersect_root, node 0, block 42, ray 2751"));
    CHECK_THAT(page, ContainsSubstring(
                         "--rays-per-block 64 --stage &#39;bounce0/level0/intersect_root&#39;"));
    CHECK_THAT(page, ContainsSubstring("scotty golden approve spheres --reason &quot;...&quot;"));
    CHECK_THAT(page, ContainsSubstring("the tile at (40, 24) is darker"));
    const std::size_t table = page.find("<tbody>", page.find("id=\"scenes\""));
    CHECK(page.find("spheres", table) < page.find("cornell", table));
    CHECK(image_data(page)[0]["name"] == "spheres");
}

TEST_CASE("page: one that passed says so and has no list of failures", "[verify][page]") {
    const std::string page = to_html(report());
    CHECK_THAT(page, ContainsSubstring("<h1>Passed</h1>") && !ContainsSubstring("id=\"failures\""));
    CHECK_THAT(to_html(Report{}),
               ContainsSubstring("<h1>Passed</h1>") && !ContainsSubstring("image-data\">"));
}

TEST_CASE("page: of 30 failures all are there, most of them folded", "[verify][page]") {
    Report failing = failing_report();
    auto& failures = failing.scenes[1].configurations[1].failures;
    failures.assign(30, failures.front());
    const std::string page = to_html(failing);
    CHECK(occurrences(page, "<span class=\"fault\">required-present</span>") == 30);
    CHECK_THAT(page, ContainsSubstring("<summary>29 more of required-present in "
                                       "bounce*/level*/intersect_root</summary>"));
    CHECK(occurrences(page, "id=\"failure-groups\"") == 1);
}

TEST_CASE("report: failures are grouped by invariant and stage, with counts", "[verify][report]") {
    CHECK(stage_family("batch1/bounce12/light0/level3/intersect") ==
          "bounce*/light*/level*/intersect");
    CHECK(stage_family("BVH of width 8") == "BVH of width 8");
    Report failing = failing_report();
    auto& failures = failing.scenes[1].configurations[1].failures;
    failures.assign(30, failures.front());
    failures[7].stage = "bounce1/level0/intersect_root";
    failing.scenes[0].configurations[0].failures.assign(2, failures[7]);
    failures[3].invariant = invariant::kNothingExtra;
    const auto groups = failure_groups(placed_failures(failing));
    REQUIRE(groups.size() > 2);  // and the image's
    CHECK(groups[0].members.size() == 31);
    CHECK(groups[0].stage == "bounce*/level*/intersect_root");
    CHECK(groups[0].scenes == std::vector<std::string>{"cornell", "spheres"});
    CHECK(groups[0].configurations == 2);
    CHECK(groups[1].invariant == invariant::kNothingExtra);
    const std::string text = table(failing);
    CHECK_THAT(text, ContainsSubstring("     31  required-present") &&
                         ContainsSubstring("2 scenes") &&
                         ContainsSubstring("first failure: scene cornell"));
    const auto json = to_json(failing);
    CHECK(json["failure_groups"].size() == groups.size());
    CHECK(json["failure_groups"][0]["count"] == 31);
    CHECK(json["failure_groups"][1]["first"] == 5);
}

TEST_CASE("report: tables fit 80 columns, and a name that does not is cut", "[verify][report]") {
    Report wide = report();
    wide.scenes[0].scene = "a name that is longer than any column has room for";
    wide.images[0].name = wide.scenes[0].scene;
    wide.scenes[1].triangles = 123456789;
    std::istringstream lines(table(wide));
    for (std::string line; std::getline(lines, line);) {
        INFO(line);
        CHECK(line.size() <= 80);
    }
}

TEST_CASE("report: what was stopped has not passed, and says so everywhere", "[verify][report]") {
    Report stopped = report();
    CHECK(stopped.passed());
    stopped.stopped = "Ctrl-C";
    CHECK_FALSE(stopped.passed());
    CHECK_THAT(table(stopped),
               ContainsSubstring(": STOPPED\n") && ContainsSubstring("not all was judged: Ctrl-C"));
    CHECK(to_json(stopped)["stopped"] == "Ctrl-C");
    CHECK(to_json(stopped)["passed"] == false);
    CHECK_THAT(to_html(stopped), ContainsSubstring("Not all was judged"));
    CHECK_THAT(to_junit(stopped),
               ContainsSubstring("name=\"all was judged\"") && ContainsSubstring("Ctrl-C"));
}

TEST_CASE("page: a hostile name stays text wherever it stands", "[verify][page]") {
    Report failing = failing_report();
    const std::size_t scripts = occurrences(to_html(failing), "<script");
    failing.command = failing.backend = kHostile;
    SceneReport& scene = failing.scenes[1];
    scene.scene = kHostile;
    ConfigurationReport& configuration = scene.configurations[1];
    configuration.label = configuration.replay = kHostile;
    Failure& failure = configuration.failures.front();
    failure.invariant = failure.stage = failure.field = kHostile;
    failure.expected = failure.found = failure.sentence = kHostile;
    ImageCase& image = failing.images[1];
    image.name = image.replay = image.approve = image.verdict.gates[3].text = kHostile;
    const std::string page = to_html(failing);
    CHECK(occurrences(page, "<script") == scripts);
    CHECK(occurrences(page, "<b>") == 0);
    CHECK(occurrences(page, "alert('1')") == 3 + 1);  // in the JSON only, as a string
    CHECK(image_data(page)[0]["name"] == kHostile);
    CHECK(image_data(page)[0]["gates"][3]["text"] == kHostile);
    image.name = "not UTF-8: \xff";
    CHECK(image_data(to_html(failing))[0]["name"] == "not UTF-8: \xef\xbf\xbd");
}

TEST_CASE("page: nothing is fetched: all that it needs is in it", "[verify][page]") {
    const std::string page = to_html(failing_report());
    CHECK_THAT(page, ContainsSubstring("default-src 'none'"));
    for (const char* fetches : {"http:", "https:", "src=", "<link", "@import", "url("}) {
        INFO(fetches);
        CHECK(occurrences(page, fetches) == 0);
    }
    for (const auto& [name, text] : page_files()) {
        INFO(name);
        // Other pages have files of their own (test_queues_page.cpp, test_analysis.cpp,
        // tests/verify/view/).
        const bool of_another =
            name.starts_with("queues") || name.starts_with("analysis") || name.starts_with("view");
        if (name == "report.html" || of_another) continue;
        CHECK(page.find(text) != std::string::npos);
        CHECK((name.ends_with(".html") || text.find("</s") == std::string_view::npos));
    }
}

TEST_CASE("page: a part that nobody made is a fault of the program", "[verify][page]") {
    CHECK_THROWS_WITH(filled_page("report.html", {}),
                      ContainsSubstring("nobody made the part policy"));
    CHECK_THROWS_WITH(filled_page("none.html", {}), ContainsSubstring("no file none.html"));
}

TEST_CASE("page: seven images of 64 x 64 pixels take less than 3 MB, every one embedded",
          "[verify][page]") {
    Report seven = report();
    for (std::uint32_t seed = 4; seed < 8; ++seed) {
        seven.images.push_back(passing_case("case" + std::to_string(seed), seed));
    }
    const std::string page = to_html(seven);
    CHECK(page.size() < 3'000'000);
    const nlohmann::json data = image_data(page);
    REQUIRE(data.size() == 7);
    for (const auto& one : data) {
        for (const char* plane : {"new", "golden", "new_variance", "golden_variance", "z"}) {
            CHECK(one["pixels"][plane].get<std::string>().size() == 64 * 64 * 12 / 3 * 4);
        }
    }
}

TEST_CASE("page: an image's planes are little-endian float32, empty where not known",
          "[verify][page]") {
    ImageCase image;
    image.image = {1, 1, {Color{1.0, -2.0, 0.1}}, {}, 0};
    const nlohmann::json data = page_data(image);
    CHECK(data["pixels"]["new"] == "AACAPwAAAMDNzMw9");  // 3f800000 c0000000 3dcccccd
    CHECK(data["checksums"]["new"] == 0x3f800000u + 0xc0000000u + 0x3dcccccdu);
    CHECK(data["pixels"]["new_variance"] == "");
    CHECK(data["pixels"]["golden"] == "");
}

TEST_CASE("report: a failed image fails the report, and its gates are in the JSON",
          "[verify][page]") {
    CHECK(report().passed());
    Report failing = report();
    failing.images[2] = failing_case("coil", 3);
    CHECK_FALSE(failing.passed());
    const nlohmann::json json = to_json(failing);
    CHECK(json["passed"] == false);
    REQUIRE(json["failures"].size() == 2);
    CHECK(json["failures"][0]["invariant"] == "image-finite");
    CHECK(json["failures"][1]["approve"] == "scotty golden approve coil --reason \"...\"");
    const nlohmann::json& image = json["images"][2];
    CHECK(image["passed"] == false);
    CHECK(image["gates"][3]["gate"] == "tile");
    CHECK(image["gates"][3]["statistic"] == 14.2);
    CHECK(image["gates"][3]["threshold"] == 1.7e-7);
    CHECK(image["gates"][4]["ran"] == false);
    CHECK(image["not_judged_by"]["flip"] == 0.0268);
    CHECK(image["not_judged_by"]["max_ulps"] == "Infinity");
    CHECK_FALSE(image.contains("pixels"));
    CHECK(json["images"][0]["passed"] == true);
}

TEST_CASE("report: JUnit has a case for every gate of every image", "[verify][page]") {
    Report failing = report();
    failing.images[2] = failing_case("coil", 3);
    pugi::xml_document document;
    REQUIRE(document.load_string(to_junit(failing).c_str()));
    const pugi::xml_node suite =
        document.child("testsuites").find_child_by_attribute("testsuite", "name", "golden images");
    // Five gates and the exact comparisons of each of three images, and the golden files.
    CHECK(suite.attribute("tests").as_int() == 3 * (5 + 1) + 1);
    CHECK(suite.attribute("failures").as_int() == 2);
    CHECK(suite.attribute("skipped").as_int() == 1);
    const auto test = [&](const char* name) {
        return suite.find_child_by_attribute("testcase", "name", name);
    };
    const pugi::xml_node tile = test("coil: tile");
    CHECK_THAT(tile.child("failure").attribute("message").value(), ContainsSubstring("(40, 24)"));
    CHECK(std::string(tile.child("failure").attribute("type").value()) == "image-tile");
    CHECK_THAT(
        tile.child("failure").text().get(),
        ContainsSubstring("scotty golden approve coil") && !ContainsSubstring("image-finite"));
    CHECK_THAT(
        tile.child("system-out").text().get(),
        ContainsSubstring("statistic 14.2") && ContainsSubstring("not judged by: FLIP 0.0268"));
    CHECK_FALSE(test("spheres: tile").child("failure"));
    CHECK(test("coil: pixel").child("skipped"));
}

TEST_CASE("report: the table has a line for every image, and how to approve one that failed",
          "[verify][page]") {
    Report failing = report();
    CHECK_THAT(table(failing), ContainsSubstring("3 golden images") && ContainsSubstring("coil") &&
                                   ContainsSubstring("0.19") && !ContainsSubstring("FAILED"));
    failing.images[2] = failing_case("coil", 3);
    CHECK_THAT(table(failing),
               ContainsSubstring(
                   "first failure: scene coil, golden image\n  [image-finite] coil against") &&
                   ContainsSubstring("show it again: scotty verify 'coil' --golden-only") &&
                   ContainsSubstring("if the new image is right: scotty golden approve coil"));
}

}  // namespace
