/// The CUDA pipeline on a device. Without one every case says so and is skipped, or fails where
/// SCOTTY_REQUIRE_GPU is set.
#include <cstdlib>
#include <cstring>
#include <iostream>

#include "gpu/host/pipeline.h"
#include "gpu/parity/parity.h"
#include "reference/base/error.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/small_parameters.h"
#include "verify/backends/backend.h"
#include "verify/backends/temporary_capture.h"
#include "verify/diff/replay.h"
#include "verify/sweep/verify.h"

namespace scotty {
namespace {

using reference::EarlyOut;
using reference::HitMode;
using reference::PipelineParameters;

bool no_device() {
    if (gpu::find_device()) return false;
    if (std::getenv("SCOTTY_REQUIRE_GPU") != nullptr) FAIL("no CUDA device, and one is required");
    std::cout << "not run: no CUDA device\n";
    return true;
}

PipelineParameters small() { return scotty::test::small_picture(29, 23, 2); }

verify::PipelineInput input_of(const char* scene, const PipelineParameters& p) {
    verify::PipelineInput input;
    input.scene = scenes::load_scene(scene);
    input.bvh = reference::build_wide_bvh(input.scene, bvh_parameters(p, 0));
    input.parameters = p;
    return input;
}

bool same(const reference::Image& a, const reference::Image& b) {
    return a.pixels.size() == b.pixels.size() &&
           std::memcmp(a.pixels.data(), b.pixels.data(),
                       a.pixels.size() * sizeof(reference::Vec3)) == 0;
}

}  // namespace

TEST_CASE("device: computes the host's bits", "[gpu]") {
    if (no_device()) return;
    for (const gpu::ParityResult& result : gpu::test_parity(1u << 18)) {
        INFO(result.name << ": " << result.first);
        CHECK(result.mismatches == 0);
        CHECK(result.tried >= 1u << 18);
    }
}

TEST_CASE("device: every launch agrees with the emulator", "[gpu]") {
    if (no_device()) return;
    for (const auto& scene : scenes::built_in_scenes()) {
        verify::VerifySettings settings;
        settings.parameters = small();
        settings.backend = "cuda";
        const verify::SceneReport report =
            verify::verify_scene(scenes::load_scene(scene.name), settings);
        for (const verify::ConfigurationReport& c : report.configurations) {
            INFO(scene.name << ": " << c.label << "\n"
                            << (c.failures.empty() ? "" : to_string(c.failures.front())));
            CHECK(c.failures.empty());
            CHECK(c.stages.identical > 0);
        }
        CHECK(report.passed());
    }
}

TEST_CASE("device: every stage alone agrees with the emulator", "[gpu]") {
    if (no_device()) return;
    for (const HitMode mode : {HitMode::buffer, HitMode::packed}) {
        for (const EarlyOut early_out : {EarlyOut::off, EarlyOut::level}) {
            PipelineParameters p = small();
            p.hit_mode = mode;
            p.early_out = early_out;
            p.filter =
                mode == HitMode::buffer ? reference::Filter::gaussian : reference::Filter::median;
            const verify::PipelineInput input = input_of("spheres", p);
            const verify::TemporaryCapture run(verify::backend_named("emulator", 0), input);
            const verify::Capture& capture = run.get();
            const verify::DiffReport report =
                verify::diff_isolated(capture, verify::backend_named("cuda", 0), {});
            INFO(to_text(report));
            CHECK(report.passed());
            CHECK(report.stages.size() > 20);
        }
    }
}

TEST_CASE("device: little memory means smaller batches and the same image", "[gpu]") {
    if (no_device()) return;
    PipelineParameters p = small();
    p.image_width = 128;
    p.image_height = 96;
    const verify::PipelineInput input = input_of("coil", p);
    const auto whole = gpu::make_pipeline(input.scene, input.bvh, p);
    const reference::Image expected = whole->render();
    for (const std::size_t part : {2, 4}) {
        gpu::PipelineOptions options;
        options.memory_limit = whole->device_bytes() / part;
        const auto pipeline = gpu::make_pipeline(input.scene, input.bvh, p, options);
        CHECK(same(pipeline->render(), expected));
        CHECK(pipeline->device_bytes() <= options.memory_limit);
    }
    gpu::PipelineOptions nothing;
    nothing.memory_limit = 1000;
    CHECK_THROWS_AS(gpu::make_pipeline(input.scene, input.bvh, p, nothing), reference::Error);
}

TEST_CASE("device: fast arithmetic stays within its tolerances", "[gpu]") {
    if (no_device()) return;
    PipelineParameters p = small();
    const verify::PipelineInput input = input_of("spheres", p);
    const verify::TemporaryCapture run(verify::backend_named("emulator", 0), input);
    const verify::Capture& capture = run.get();
    verify::DiffOptions options;
    options.b_arithmetic = reference::Arithmetic::fast;
    const verify::DiffReport alone =
        verify::diff_isolated(capture, verify::backend_named("cuda", 0), options);
    INFO(to_text(alone));
    CHECK(alone.passed());
    const verify::DiffReport chained =
        verify::diff_with_run(capture, verify::backend_named("cuda", 0), options);
    INFO(to_text(chained));
    CHECK(chained.passed());
}

}  // namespace scotty
