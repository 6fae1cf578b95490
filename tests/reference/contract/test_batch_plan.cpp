#include <algorithm>
#include <vector>

#include "reference/contract/batch_plan.h"
#include "tests/catch.h"

namespace scotty::reference {

namespace {

PipelineParameters parameters(std::uint32_t width, std::uint32_t height, std::uint32_t spp,
                              std::uint32_t batch_rays, std::uint32_t samples_per_pass) {
    PipelineParameters p;
    p.image_width = width;
    p.image_height = height;
    p.spp = spp;
    p.batch_rays = batch_rays;
    p.samples_per_pass = samples_per_pass;
    return p;
}

std::vector<BatchView> batches_of(const PipelineParameters& p) {
    const BatchPlan plan(p);
    std::vector<BatchView> batches;
    for (std::uint64_t batch = 0; batch < plan.size(); ++batch) batches.push_back(plan[batch]);
    return batches;
}

/// What the plan says in one formula, as the three nested loops that it stands for.
std::vector<BatchView> nested_loops(const PipelineParameters& p) {
    const std::uint32_t pixels = p.image_width * p.image_height;
    const std::uint32_t pass_samples = samples_of_pass(p);
    const std::uint32_t samples = std::min(pass_samples, p.batch_rays);
    const std::uint32_t at_once = std::max(1u, std::min(pixels, p.batch_rays / samples));
    std::vector<BatchView> batches;
    for (std::uint32_t pass = 0; pass < p.spp; pass += pass_samples) {
        const std::uint32_t end = std::min(p.spp, pass + pass_samples);
        for (std::uint32_t pixel = 0; pixel < pixels; pixel += at_once) {
            for (std::uint32_t sample = pass; sample < end; sample += samples) {
                batches.push_back({pixel, std::min(at_once, pixels - pixel), sample,
                                   std::min(samples, end - sample)});
            }
        }
    }
    return batches;
}

bool same(const BatchView& a, const BatchView& b) {
    return a.first_pixel == b.first_pixel && a.pixels == b.pixels &&
           a.first_sample == b.first_sample && a.samples == b.samples;
}

}  // namespace

TEST_CASE("batches: an image that fits is one batch", "[batches]") {
    const auto batches = batches_of(parameters(7, 5, 3, 1u << 16, 0));
    REQUIRE(batches.size() == 1);
    CHECK(same(batches[0], {0, 35, 0, 3}));
}

TEST_CASE("batches: passes, then bands of pixels, then rounds of samples", "[batches]") {
    // 3 samples a pass, 2 at once: 2 pixels would be 4 paths, so each batch has one pixel.
    const auto batches = batches_of(parameters(2, 1, 4, 2, 3));
    const std::vector<BatchView> expected{{0, 1, 0, 2}, {0, 1, 2, 1}, {1, 1, 0, 2},
                                          {1, 1, 2, 1}, {0, 1, 3, 1}, {1, 1, 3, 1}};
    REQUIRE(batches.size() == expected.size());
    CHECK(std::equal(batches.begin(), batches.end(), expected.begin(), same));
}

TEST_CASE("batches: the plan is the three nested loops, and no batch is too large", "[batches]") {
    for (const std::uint32_t spp : {1u, 2u, 5u, 8u}) {
        for (const std::uint32_t batch_rays : {1u, 2u, 3u, 7u, 16u, 35u, 1000u}) {
            for (const std::uint32_t pass : {0u, 1u, 2u, 3u, 8u, 9u}) {
                const PipelineParameters p = parameters(7, 5, spp, batch_rays, pass);
                const auto batches = batches_of(p);
                const auto expected = nested_loops(p);
                CAPTURE(spp, batch_rays, pass);
                REQUIRE(batches.size() == expected.size());
                CHECK(std::equal(batches.begin(), batches.end(), expected.begin(), same));
                for (const BatchView& batch : batches) {
                    CHECK(batch.pixels * batch.samples <= batch_rays);
                }
            }
        }
    }
}

}  // namespace scotty::reference
