/// The back end "simt": the CUDA text on the CPU, against captures of the emulator.
#include "tests/verify/capture_tools.h"
#include "verify/backend.h"
#include "verify/replay.h"

namespace {

using namespace scotty;
using namespace scotty::verify;
using namespace scotty::verify::test;

TEST_CASE("simt: a run and every stage alone give what the emulator gave", "[verify][simt]") {
    reference::PipelineParameters p = small_parameters();
    SECTION("early-out level") {}
    SECTION("early-out immediate") { p.early_out = reference::EarlyOut::immediate; }
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", p);
    const Backend backend = backend_named("simt", 2);
    for (const DiffReport& report :
         {diff_with_run(capture, backend, {}), diff_isolated(capture, backend, {})}) {
        INFO(to_text(report));
        CHECK(report.passed());
        CHECK(report.b_backend == "simt");
        CHECK(report.stages.size() == capture.stages().size());
    }
}

TEST_CASE("simt: what was spoiled in a capture is found", "[verify][simt]") {
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", small_parameters(), [](StageCopies& stages) {
        ++stages.at("bounce0/level1/intersect").output<std::uint32_t>("child_counts")[1];
    });
    const DiffReport report = diff_isolated(capture, backend_named("simt", 1), {});
    CHECK_FALSE(report.passed());
    REQUIRE(report.first() != nullptr);
    CHECK(report.first()->stage == "bounce0/level1/intersect");
}

}  // namespace
