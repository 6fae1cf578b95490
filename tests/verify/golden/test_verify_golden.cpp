/// Golden images and ledgers inside `scotty verify`, and the golden images among themselves.
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/verify/command_tools.h"
#include "tests/verify/golden_tools.h"
#include "verify/golden/golden_judge.h"
#include "verify/golden/verify_golden.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

/// The project's golden files, to be spoiled.
struct Copy {
    TemporaryFolder folder;
    fs::path golden = folder / "golden";

    Copy() { fs::copy(find_golden_folder(), golden, fs::copy_options::recursive); }

    /// Of the quickest scene.
    Report verify(const Backend& backend = backend_named("emulator", 0)) const {
        Report report;
        GoldenSettings settings;
        settings.folder = golden.string();
        settings.scenes = {"furnace"};
        verify_golden(settings, backend, report);
        return report;
    }
};

std::string failures_text(const Report& report) {
    std::string text;
    for (const PlacedFailure& placed : placed_failures(report)) {
        text += to_string(placed.failure) + "\n";
    }
    return text;
}

constexpr const char* kWaivers = R"({"format": "cuda-scotty-waivers", "version": 1, "waivers": [
  {"case": "furnace", "gate": "global", "device": "*", "reason": "a test", "expires": "DAY"},
  {"case": "furnace", "gate": "tile", "device": "*", "reason": "a test", "expires": "DAY"},
  {"case": "furnace", "gate": "pixel", "device": "*", "reason": "a test", "expires": "DAY"},
  {"case": "furnace", "stage": "*", "device": "*", "reason": "a test", "expires": "DAY"}]})";

std::string waivers_until(const std::string& day) {
    std::string text = kWaivers;
    for (std::size_t at = 0; (at = text.find("DAY", at)) != std::string::npos;) {
        text.replace(at, 3, day);
    }
    return text;
}

}  // namespace

TEST_CASE("verify golden: an image and a ledger that hold", "[verify][golden]") {
    const Report report = Copy().verify();
    INFO(failures_text(report));
    CHECK(report.passed());
    REQUIRE(report.images.size() == 1);
    CHECK(report.images[0].z.size() == 64 * 64);
    CHECK(report.false_alarm == 1e-4);
}

TEST_CASE("verify golden: a missing, spoiled or foreign file fails, and is never skipped",
          "[verify][golden]") {
    const Copy copy;
    SECTION("the image is gone") {
        fs::remove(copy.golden / "images/furnace.exr");
        CHECK_THAT(failures_text(copy.verify()), ContainsSubstring("[golden-missing]") &&
                                                     ContainsSubstring("images/furnace.exr"));
    }
    SECTION("the ledger is another") {
        spill(copy.golden / "ledgers/furnace.txt", "nonsense\n");
        CHECK_THAT(failures_text(copy.verify()), ContainsSubstring("[golden-corrupted]"));
    }
    SECTION("the whole folder is gone") {
        fs::remove_all(copy.golden);
        CHECK_THAT(failures_text(copy.verify()), ContainsSubstring("[golden]"));
    }
    SECTION("a waiver has expired") {
        spill(copy.golden / "waivers.json", waivers_until("2020-01-01"));
        CHECK_THAT(failures_text(copy.verify()), ContainsSubstring("[golden-waiver]"));
    }
    CHECK_FALSE(copy.verify().passed());
}

TEST_CASE(
    "verify golden: a picture that is 1 % too dark fails by ledger and global gate, and a "
    "waiver lets it pass by name",
    "[verify][golden]") {
    const Copy copy;
    const Report report = copy.verify(with_light_scaled(0.99f));
    CHECK_FALSE(report.passed());
    CHECK_THAT(failures_text(report), ContainsSubstring("[golden-ledger] reconstruct_image") &&
                                          ContainsSubstring("[image-global] furnace"));
    CHECK_THAT(table(report), ContainsSubstring("furnace") && ContainsSubstring("FAILED"));
    spill(copy.golden / "waivers.json", waivers_until("2999-01-01"));
    const Report waived = copy.verify(with_light_scaled(0.99f));
    INFO(failures_text(waived));
    CHECK(waived.passed());
    CHECK_THAT(table(waived), ContainsSubstring("let pass") && ContainsSubstring("a test"));
    CHECK_THAT(to_json(waived).dump(), ContainsSubstring("global"));
}

TEST_CASE("verify golden: every golden image is rejected as any other", "[verify][golden]") {
    const fs::path golden = find_golden_folder();
    std::vector<std::string> names;
    std::vector<MeasuredImage> images;
    for (const GoldenCase& one : golden_cases()) {
        names.push_back(one.name);
        images.push_back(read_golden(golden, one, scenes::load_scene(one.scene)).image);
    }
    REQUIRE(images.size() >= 7);
    for (std::size_t i = 0; i < images.size(); ++i) {
        for (std::size_t k = 0; k < images.size(); ++k) {
            INFO(names[i] << " as " << names[k]);
            CHECK(judge_image(images[i], images[k], {}).passed() == (i == k));
        }
    }
}

TEST_CASE("verify golden: the command judges golden images alone, and says so where it cannot",
          "[verify][golden][command]") {
    const Copy copy;
    const std::string only = "verify furnace --only-golden --golden '" + copy.golden.string() + "'";
    const Result passed = run_scotty(only + " --json -");
    CHECK(passed.exit_code == kExitPassed);
    CHECK(nlohmann::json::parse(passed.out).at("images").size() == 1);
    fs::remove(copy.golden / "ledgers/furnace.txt");
    const Result failed = run_scotty(only);
    CHECK(failed.exit_code == kExitFailed);
    CHECK_THAT(failed.out,
               ContainsSubstring("golden-missing") && ContainsSubstring("scotty golden"));
}

}  // namespace scotty::verify::test
