/// The pipeline's image with its noise, and the independent path tracer's: the same picture?
#include <algorithm>
#include <cmath>
#include <string>

#include "reference/contract/wide_bvh.h"
#include "reference/truth/path_tracer.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/golden/pipeline_image.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;
using reference::PipelineParameters;

constexpr std::uint32_t kSize = 16;

PipelineParameters picture(std::uint32_t spp, std::uint64_t seed) {
    PipelineParameters p;
    p.image_width = kSize;
    p.image_height = kSize;
    p.spp = spp;
    p.seed = seed;
    return p;
}

PipelineImage measure(const reference::Scene& scene, const PipelineParameters& p,
                      const Backend& backend = backend_named("emulator", 0)) {
    return measure_pipeline(backend, {scene, build_wide_bvh(scene, bvh_parameters(p, 0)), p});
}

/// Largest |difference of means| in standard deviations, over squares of `side` pixels. What
/// float32 rounds off a path is no difference: a lamp seen in a mirror is the same in all of them.
double largest_z(const MeasuredImage& a, const MeasuredImage& b, std::uint32_t side) {
    double worst = 0.0;
    for (std::uint32_t tile = 0; tile < (kSize / side) * (kSize / side); ++tile) {
        for (std::size_t c = 0; c < 3; ++c) {
            double difference = 0.0;
            double variance = 0.0;
            double total = 0.0;
            for (std::uint32_t i = 0; i < side * side; ++i) {
                const std::uint32_t y = tile / (kSize / side) * side + i / side;
                const std::uint32_t x = tile % (kSize / side) * side + i % side;
                const std::size_t pixel = std::size_t{y} * kSize + x;
                difference += a.mean[pixel][c] - b.mean[pixel][c];
                variance += a.variance[pixel][c] + b.variance[pixel][c];
                total += b.mean[pixel][c];
            }
            const double beyond = std::abs(difference) - 1e-6 * total;
            if (beyond > 0.0) worst = std::max(worst, beyond / std::sqrt(variance));
        }
    }
    return worst;
}

}  // namespace

TEST_CASE("pipeline image: the independent path tracer sees the same picture in every scene",
          "[verify][golden]") {
    for (const scenes::BuiltIn& built_in : scenes::built_in_scenes()) {
        INFO(built_in.name);
        const reference::Scene scene = scenes::load_scene(built_in.name);
        const PipelineImage pipeline = measure(scene, picture(128, 1));
        const MeasuredImage truth = measured(trace_paths(scene, picture(384, 2)));
        CHECK(pipeline.reconstruction_fault.empty());
        // 3 and 48 values a scene: 4 and 5 standard deviations are one false alarm in 700 runs.
        CHECK(largest_z(pipeline.image, truth, kSize) < 4.0);
        CHECK(largest_z(pipeline.image, truth, 4) < 5.0);
    }
}

TEST_CASE("pipeline image: a missing bounce is seen beside the path tracer", "[verify][golden]") {
    const reference::Scene scene = scenes::load_scene("cornell");
    PipelineParameters p = picture(256, 1);
    const MeasuredImage truth = measured(trace_paths(scene, p));
    p.bounces = 1;
    CHECK(largest_z(measure(scene, p).image, truth, kSize) > 4.0);
}

TEST_CASE("pipeline image: means and variances are those of the paths, whatever the batches",
          "[verify][golden]") {
    const reference::Scene scene = scenes::load_scene("spheres");
    PipelineParameters p = picture(6, 1);
    const PipelineImage whole = measure(scene, p);
    CHECK(whole.image.samples == 6);
    for (const std::uint32_t batch : {4u, 1000u}) {  // part of a pixel; many pixels
        p.batch_rays = batch;
        const PipelineImage parts = measure(scene, p);
        CHECK(parts.image.mean == whole.image.mean);
        CHECK(parts.image.variance == whole.image.variance);
        CHECK(parts.reconstruction_fault.empty());
    }
}

TEST_CASE("pipeline image: a picture that is not the mean of its paths is named",
          "[verify][golden]") {
    const reference::Scene scene = scenes::load_scene("cornell");
    const Backend backend = render_only(
        "emulator", [](const reference::Scene& of, const reference::WideBvh& bvh,
                       const PipelineParameters& p, reference::StageObserver* observer) {
            reference::Image image =
                backend_named("emulator", 0).make(of, bvh, p, {.observer = observer})->render();
            image.pixels[2 * kSize + 3].y *= 1.00001f;
            return image;
        });
    CHECK_THAT(measure(scene, picture(4, 1), backend).reconstruction_fault,
               ContainsSubstring("reconstruct_image: pixel (3, 2), channel G"));
}

}  // namespace scotty::verify::test
