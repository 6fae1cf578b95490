/// A pipeline held against golden files: seen to pass, and to fail where it is wrong.
#include <filesystem>
#include <functional>
#include <string>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "tests/verify/golden_tools.h"
#include "verify/golden/golden_judge.h"
#include "verify/golden/golden_proposal.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

constexpr double kFalseAlarm = 1e-4;

GoldenCase small_case() {
    GoldenCase golden{"box", "cornell", {}, {}, small_parameters()};
    golden.image.image_width = 8;
    golden.image.image_height = 8;
    golden.image.spp = 256;
    golden.pipeline = golden.image;
    golden.pipeline.spp = 64;
    golden.pipeline.seed = 1;
    return golden;
}

/// A golden folder with that one case.
struct Store {
    TemporaryFolder folder;
    fs::path golden = folder / "golden";

    Store() {
        fs::create_directories(golden);
        write_manifest(golden, {});
        ProposalSettings settings;
        settings.golden = golden;
        settings.output = folder / "proposals";
        propose_golden(small_case(), settings);
        approve_golden(small_case(), golden, settings.output, "for a test");
    }
    GoldenVerdict judge(const Backend& backend, WaiverBook& waivers) const {
        return judge_golden(golden, small_case(), backend, waivers, kFalseAlarm);
    }
    GoldenVerdict judge(const Backend& backend) const {
        WaiverBook none({}, "2020-01-01");
        return judge(backend, none);
    }
};

}  // namespace

TEST_CASE("golden judge: the emulator passes, by its ledger and its image", "[verify][golden]") {
    const Store store;
    const GoldenVerdict verdict = store.judge(backend_named("emulator", 0));
    for (const std::string& fault : verdict.faults) FAIL_CHECK(fault);
    CHECK(verdict.ledger.compared > 50);
    CHECK(verdict.image.gates.size() == 5);
    CHECK(verdict.found.samples == 64);
    CHECK(verdict.golden.samples == 256);
}

TEST_CASE("golden judge: a wrong picture fails by stage, buffer and gate", "[verify][golden]") {
    const Store store;
    const GoldenVerdict verdict = store.judge(with_light_scaled(1.5f));
    CHECK_FALSE(verdict.passed());
    CHECK(verdict.ledger.stage == "reconstruct_image");
    CHECK(verdict.ledger.buffer == "image");
    REQUIRE(verdict.faults.size() >= 2);
    CHECK_THAT(verdict.faults[0], ContainsSubstring("ledger: reconstruct_image: buffer 'image'"));
    CHECK_THAT(verdict.faults[1], ContainsSubstring("image, global gate"));
}

TEST_CASE("golden judge: a waiver lets pass what it names, and only that", "[verify][golden]") {
    const Store store;
    const Waiver ledger{"box", "", "reconstruct_image", "*", "known", "2020-12-31"};
    const Waiver other{"box", "finite", "", "emulator", "known", "2020-12-31"};
    std::vector<Waiver> waivers{ledger, other};
    for (const char* gate : {"global", "tile", "pixel"}) {
        waivers.push_back({"box", gate, "", "emulator", "known", "2020-12-31"});
    }
    WaiverBook book(waivers, "2020-01-01");
    const GoldenVerdict verdict = store.judge(with_light_scaled(1.5f), book);
    CHECK(verdict.passed());
    CHECK(verdict.waived.size() >= 2);
    CHECK_THAT(verdict.waived[0], ContainsSubstring("known"));
    CHECK(book.unused({"box"}, "emulator").front().gate == "finite");

    WaiverBook expired({ledger}, "2021-01-01");
    CHECK_FALSE(store.judge(with_light_scaled(1.5f), expired).passed());
}

TEST_CASE("golden judge: missing, stale and corrupted golden files are no pass",
          "[verify][golden]") {
    const Store store;
    WaiverBook none({}, "2020-01-01");
    const auto error = [&](const GoldenCase& golden_case) {
        return error_of([&] {
            judge_golden(store.golden, golden_case, backend_named("emulator", 0), none,
                         kFalseAlarm);
        });
    };
    GoldenCase other = small_case();
    other.name = "new";
    CHECK_THAT(error(other), ContainsSubstring("'new'") && ContainsSubstring("missing"));
    other = small_case();
    other.image.bounces = 1;
    CHECK_THAT(error(other), ContainsSubstring("stale"));
    spill(store.golden / "images" / "box.exr", "something else");
    CHECK_THAT(error(small_case()), ContainsSubstring("images/box.exr is corrupted"));
}

}  // namespace scotty::verify::test
