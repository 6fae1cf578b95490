/// `scotty diff GOLDEN IMAGE` and `scotty bench gates`, as a user runs them.
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "tests/catch.h"
#include "tests/verify/browser_tools.h"
#include "tests/verify/command_tools.h"
#include "tests/verify/image_tools.h"
#include "verify/bench/bench_gates.h"
#include "verify/capture/npy.h"
#include "verify/images/image_diff.h"
#include "verify/images/image_read.h"
#include "verify/images/planted_faults.h"

namespace {

using namespace scotty;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
using verify::ImageFault;
using verify::MeasuredImage;

/// A golden image and renders of it as files.
struct Pair {
    TemporaryFolder folder;
    std::string golden = folder.file("golden.exr");
    std::string image = folder.file("image.exr");
    verify::SyntheticSettings settings;

    explicit Pair(ImageFault fault = ImageFault::none, bool variances = true) {
        settings.width = 32;
        settings.height = 24;
        verify::write_measured_image(verify::synthetic_golden(settings), golden);
        MeasuredImage render = verify::synthetic_render(settings, fault);
        if (!variances) {
            render.variance.clear();
            render.samples = 0;
        }
        verify::write_measured_image(render, image);
    }
    Result diff(const std::string& options = "") const {
        return scotty_here("diff " + golden + " " + image + " " + options);
    }
};

reference::Image picture_of(const MeasuredImage& image) {
    reference::Image picture{image.width, image.height, {}};
    for (const verify::Color& c : image.mean) {
        picture.pixels.emplace_back(static_cast<float>(c[0]), static_cast<float>(c[1]),
                                    static_cast<float>(c[2]));
    }
    return picture;
}

TEST_CASE("scotty diff: a render passes against its golden image, with the gates named",
          "[verify][image][cli]") {
    const Pair pair;
    const Result result = pair.diff();
    INFO(result.out << result.err);
    CHECK(result.exit_code == 0);
    for (const char* word : {"layout", "finite", "global", "tile", "pixel", "flip", "PSNR",
                             "256 samples", "4096 samples", "0.0001", "worst pixels"}) {
        CHECK_THAT(result.out, ContainsSubstring(word));
    }
    CHECK_THAT(pair.diff("--heavy-tailed").out, ContainsSubstring("pixel    -"));
    CHECK_THAT(pair.diff("--false-alarm 0.01").out, ContainsSubstring("probability 0.01"));
}

TEST_CASE("scotty diff: a fault exits with 1 and says by which gate and where",
          "[verify][image][cli]") {
    const Pair pair(ImageFault::not_a_number);
    const Result result = pair.diff();
    CHECK(result.exit_code == 1);
    CHECK_THAT(result.out, ContainsSubstring("differs, by the finite gate") &&
                               ContainsSubstring("(0, 12) green"));

    const Pair mirrored(ImageFault::mirrored);
    const Result json = mirrored.diff("--json");
    CHECK(json.exit_code == 1);
    const auto verdict = nlohmann::json::parse(json.out);
    CHECK_FALSE(verdict["passed"].get<bool>());
    CHECK(verdict["basis"] == "noise");
    CHECK(verdict["gates"].size() == 5);
    CHECK(verdict["gates"][3]["gate"] == "tile");
    CHECK_FALSE(verdict["gates"][3]["passed"].get<bool>());
    CHECK(verdict["worst"].size() == 10);
    CHECK(verdict["image"]["samples"] == 256);
}

TEST_CASE("scotty diff: numbers that are not finite leave the JSON clean", "[verify][image][cli]") {
    const Pair pair(ImageFault::not_a_number);
    const auto verdict = nlohmann::json::parse(pair.diff("--json").out);
    CHECK(verdict["not_judged_by"]["flip"] == "NaN");
    CHECK(verdict["not_judged_by"]["max_ulps"] == "Infinity");
    CHECK(verdict["worst"][0]["image"][1] == "NaN");
}

TEST_CASE("scotty diff: an image that does not know its noise is never passed for that",
          "[verify][image][cli]") {
    const Pair pair(ImageFault::none, false);
    const Result unknown = pair.diff();
    CHECK(unknown.exit_code == 2);
    CHECK_THAT(unknown.out,
               ContainsSubstring("not judged: the images differ, and the image does not say") &&
                   ContainsSubstring("--also") && !ContainsSubstring("FAILED"));
    CHECK(nlohmann::json::parse(pair.diff("--json").out)["not_judged"] != "");
    CHECK(pair.diff("--samples 256").exit_code == 2);  // the golden image's noise is not its own
    const Pair known;
    CHECK_THAT(known.diff("--samples 512").err, ContainsSubstring("256 samples a pixel, not 512"));
}

TEST_CASE("scotty diff: the order is golden image, then image, and a hint says so",
          "[verify][image][cli]") {
    const Pair pair;
    std::filesystem::create_directory(pair.folder / "golden");
    const std::string golden = pair.folder.file("golden/a.exr");
    std::filesystem::copy_file(pair.golden, golden);
    CHECK_THAT(scotty_here("diff " + pair.image + " " + golden).err,
               ContainsSubstring("scotty diff GOLDEN IMAGE"));
    CHECK(scotty_here("diff " + golden + " " + pair.image).err.empty());
}

TEST_CASE("scotty diff: an array of scotty-gpu and a capture's folder are images too",
          "[verify][image][cli]") {
    const TemporaryFolder folder;
    const std::string capture = folder.file("c");
    REQUIRE(scotty_here("capture cornell --size 9x7 --spp 2 -o " + capture).exit_code == 0);
    const MeasuredImage image = verify::read_image(capture).image;
    CHECK(image.width == 9);
    CHECK(image.height == 7);
    CHECK(image.samples == 2);
    std::vector<float> values;
    for (const verify::Color& color : image.mean) {
        for (const double value : color) values.push_back(static_cast<float>(value));
    }
    const std::size_t shape[] = {7, 9, 3};
    verify::write_npy(folder.file("a.npy"), reference::ElementType::float32, shape, values.data(),
                      values.size() * sizeof(float));
    REQUIRE(scotty_here("render cornell --size 9x7 --spp 2 -o " + folder.file("a.exr")).exit_code ==
            0);
    const std::string array = "diff " + folder.file("a.exr") + " " + folder.file("a.npy");
    CHECK(scotty_here(array).exit_code == 0);
    CHECK(verify::read_image(folder.file("a.npy")).image.variance.empty());
    std::vector<float> variances;
    for (const verify::Color& color : image.variance) {
        for (const double value : color) variances.push_back(static_cast<float>(value));
    }
    verify::write_npy(folder.file("a.variance.npy"), reference::ElementType::float32, shape,
                      variances.data(), variances.size() * sizeof(float));
    spill(folder.file("a.json"), "{\"samples\": 2}");
    CHECK(scotty_here(array).exit_code == 0);
    CHECK(verify::read_image(folder.file("a.npy")).image.variance == image.variance);
    spill(folder.file("a.json"), "{}");
    CHECK_THAT(scotty_here(array).err, ContainsSubstring("a.json") && ContainsSubstring("samples"));
    CHECK(scotty_here("diff " + folder.file("a.exr") + " " + capture).exit_code == 0);
    CHECK_THAT(scotty_here("diff " + folder.file("a.exr") + " " + capture + " --part 1").err,
               ContainsSubstring("no part '1'"));
}

TEST_CASE("scotty diff: renders with other seeds say how noisy they are", "[verify][image][cli]") {
    for (const ImageFault fault : {ImageFault::none, ImageFault::cosine_forgotten}) {
        const Pair pair(fault, false);
        std::string also = "--samples 256 --also";
        for (std::uint64_t seed = 2; seed <= 6; ++seed) {
            verify::SyntheticSettings settings = pair.settings;
            settings.seed = seed;
            MeasuredImage render = verify::synthetic_render(settings, fault);
            render.variance.clear();
            const std::string file =
                pair.folder.file(("b" + std::to_string(seed) + ".exr").c_str());
            verify::write_measured_image(render, file);
            also += " " + file;
        }
        const Result result = pair.diff(also);
        INFO(result.out << result.err);
        CHECK(result.exit_code == (fault == ImageFault::none ? 0 : 1));
        CHECK_THAT(result.out, ContainsSubstring("6 samples of 256 paths, with variances"));
        CHECK_THAT(pair.diff("--also " + pair.image).err, ContainsSubstring("--samples"));
        verify::write_measured_image(smooth_image(7, 7), pair.folder.file("small.exr"));
        CHECK_THAT(pair.diff("--samples 256 --also " + pair.folder.file("small.exr")).err,
                   ContainsSubstring("small.exr: has another size"));
    }
}

TEST_CASE("scotty diff: without noise on either side only equal bits pass, or a stated tolerance",
          "[verify][image][cli]") {
    const TemporaryFolder folder;
    MeasuredImage image = smooth_image(20, 10);
    verify::write_measured_image(image, folder.file("a.exr"));
    image.mean[45][0] *= 1.001;
    verify::write_measured_image(image, folder.file("b.exr"));
    const std::string both = "diff " + folder.file("b.exr") + " " + folder.file("a.exr");
    CHECK(scotty_here("diff " + folder.file("a.exr") + " " + folder.file("a.exr")).exit_code == 0);
    const Result bits = scotty_here(both);
    CHECK(bits.exit_code == 2);
    CHECK_THAT(bits.out, ContainsSubstring("does not say how noisy it is") &&
                             ContainsSubstring("red of pixel (5, 2)") &&
                             ContainsSubstring("--tolerance"));
    CHECK(scotty_here(both + " --tolerance 0.01").exit_code == 0);
    CHECK(scotty_here(both + " --tolerance 0.0001").exit_code == 1);
    CHECK(scotty_here(both + " --tolerance 0").exit_code == 1);
}

TEST_CASE("scotty diff: a PNG against an EXR goes by a tolerance", "[verify][image][cli]") {
    const TemporaryFolder folder;
    MeasuredImage image = smooth_image(20, 10);
    for (verify::Color& color : image.mean) {
        for (double& value : color) value = std::min(value, 0.99);
    }
    verify::write_image(picture_of(image), folder.file("a.png"));
    verify::write_measured_image(image, folder.file("a.exr"));
    const std::string both = "diff " + folder.file("a.png") + " " + folder.file("a.exr");
    CHECK(scotty_here(both).exit_code == 2);
    CHECK(scotty_here(both + " --tolerance 0.02").exit_code == 0);
}

TEST_CASE("scotty diff: the heat map is hottest where the fault is", "[verify][image][cli]") {
    const Pair pair(ImageFault::black_pixels);
    const std::string map = pair.folder.file("z.exr");
    const Result result = pair.diff("--json --heatmap " + map);
    CHECK(result.exit_code == 1);
    const auto worst = nlohmann::json::parse(result.out)["worst"][0];
    const verify::MeasuredImage heat = verify::read_image(map).image;
    const std::size_t x = worst["x"];
    const std::size_t y = worst["y"];
    CHECK(heat.mean[y * 32 + x] == verify::Color{1.0, 1.0, 1.0});
    CHECK(heat.mean[0] == verify::Color{0.0, 0.0, 0.0});  // background
    CHECK(pair.diff("--heatmap " + pair.folder.file("z.png")).exit_code == 1);
    CHECK(std::filesystem::exists(pair.folder.file("z.png")));
    CHECK(pair.diff("--heatmap " + pair.folder.file("z.gif")).exit_code == 2);
}

TEST_CASE("scotty diff: images that cannot be read or do not go with the options exit with 2",
          "[verify][image][cli]") {
    const Pair pair;
    spill(pair.folder / "cut.exr", slurp(pair.image).substr(0, 900));
    const std::string cut = pair.folder.file("cut.exr");
    const std::vector<std::pair<std::string, std::string>> table{
        {"diff none.exr " + pair.golden, "none.exr: no such file"},
        {"diff " + cut + " " + pair.golden, "cut.exr"},
        {"diff " + pair.image, "scotty diff GOLDEN IMAGE"},
        {"diff " + pair.image + " " + pair.folder.path().string(), "found a folder"},
        {"diff " + pair.image + " " + pair.golden + " --isolated", "for captures"},
        {"diff " + pair.image + " " + pair.golden + " --false-alarm 2", "--false-alarm"},
        {"diff " + pair.image + " " + pair.golden + " --tolerance -1", "--tolerance"},
        {"diff some.capture other.capture --tolerance 0.1", "for images"},
        {"diff some.capture other.capture --heavy-tailed", "for images"},
        {"bench gates --spp 1", "one sample has no variance"}};
    for (const auto& [arguments, expected] : table) {
        const Result result = scotty_here(arguments);
        INFO("scotty " << arguments << "\n" << result.err);
        CHECK(result.exit_code == 2);
        CHECK_THAT(result.err, ContainsSubstring(expected));
        CHECK(result.out.empty());
    }
}

TEST_CASE("scotty diff: --html gives the viewer of verify's page, which passes its own test",
          "[verify][image][cli][browser]") {
    const Pair sound;
    const Pair dark(ImageFault::dark_tile);
    const Pair silent(ImageFault::none, false);
    std::map<std::string, std::string> pages;
    const std::vector<std::tuple<const char*, const Pair*, int>> cases{
        {"sound", &sound, 0}, {"dark", &dark, 1}, {"silent", &silent, 2}};
    for (const auto& [name, pair, code] : cases) {
        const std::string html = pair->folder.file("page.html");
        const Result result = pair->diff("--html " + html);
        INFO(result.err);
        CHECK(result.exit_code == code);
        pages[name] = slurp(html);
        CHECK_THAT(pages[name], ContainsSubstring("id=\"picture\"") &&
                                    ContainsSubstring(": scotty diff</title>"));
    }
    CHECK_THAT(pages["sound"], ContainsSubstring("<h1>Passed</h1>"));
    CHECK_THAT(pages["dark"], ContainsSubstring("image-"));
    CHECK_THAT(pages["silent"], ContainsSubstring("Not all was judged"));
    if (!browser_is_here()) {
        if (std::getenv("SCOTTY_REQUIRE_BROWSER") != nullptr) FAIL("chromium is not installed");
        WARN("not run: chromium is not installed (Debian: chromium)");
        return;
    }
    for (const auto& [name, found] : self_tests(pages)) {
        INFO(name);
        CHECK_THAT(found, ContainsSubstring("selftest: passed"));
    }
}

TEST_CASE("scotty diff: other sizes are a verdict, not an error", "[verify][image][cli]") {
    const Pair pair;
    verify::write_measured_image(smooth_image(24, 32), pair.image);
    const Result result = pair.diff("--heatmap " + pair.folder.file("z.png"));
    CHECK(result.exit_code == 1);
    CHECK_THAT(result.out, ContainsSubstring("by the layout gate") && ContainsSubstring("24x32"));
    CHECK_THAT(result.err, ContainsSubstring("is not written"));
}

TEST_CASE("scotty bench gates: power and false alarms as a table and as clean JSON",
          "[verify][image][cli]") {
    const std::string quick = "bench gates --size 32x32 --spp 32 --trials 2";
    const Result text = scotty_here(quick);
    CHECK(text.exit_code == 0);
    CHECK_THAT(text.out, ContainsSubstring("+1 % radiance") && ContainsSubstring("mirrored") &&
                             ContainsSubstring("should"));
    const Result json = scotty_here(quick + " --json -");
    const auto report = nlohmann::json::parse(json.out);
    CHECK(report["trials"] == 2);
    CHECK(report["samples"] == 32);
    const auto& rows = report["rows"];
    CHECK(rows.size() == 13);
    CHECK(rows[0]["rejected_by_any"] == 0);
    CHECK(rows[4]["fault"] == "a NaN");
    CHECK(rows[4]["rejected"]["finite"] == 2);
    CHECK(rows[7]["rejected"]["tile"] == 2);
}

}  // namespace
