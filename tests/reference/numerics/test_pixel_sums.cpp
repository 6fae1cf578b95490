/// A pixel's mean and variance: the textbook's numbers, whatever the batches.
#include <cmath>
#include <vector>

#include "reference/numerics/pixel_sums.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

/// Mostly dark, now and then a bright path: what pixels are like.
std::vector<Vec3> paths(std::uint32_t count, std::uint32_t seed) {
    Random random(seed);
    std::vector<Vec3> out;
    for (std::uint32_t i = 0; i < count; ++i) {
        const float bright = random() % 16 == 0 ? 40.0f : 1.0f;
        out.emplace_back(uniform(random, 0.0f, bright), uniform(random, 0.9f, 1.0f), 0.25f);
    }
    return out;
}

PixelSums sums_of(const std::vector<Vec3>& samples) {
    PixelSums sums;
    for (std::uint32_t i = 0; i < samples.size(); ++i) add_sample(sums, i, samples[i]);
    return sums;
}

}  // namespace

TEST_CASE("pixel sums: mean and variance of the mean are those of two passes in double",
          "[reference][pixel-sums]") {
    for (const std::uint32_t count : {2u, 3u, 16u, 255u, 4096u}) {
        const std::vector<Vec3> samples = paths(count, count);
        PixelSums sums = sums_of(samples);
        finish(sums, count);
        for (int c = 0; c < 3; ++c) {
            double mean = 0.0;
            for (const Vec3& sample : samples) mean += double{sample[c]} / count;
            double squares = 0.0;
            for (const Vec3& sample : samples) squares += std::pow(sample[c] - mean, 2);
            const double variance = squares / (static_cast<double>(count) * (count - 1.0));
            INFO(count << " samples, channel " << c);
            CHECK(sums.image[c] == Approx(mean).epsilon(1e-5));
            CHECK(sums.variance[c] == Approx(variance).epsilon(1e-3).margin(1e-12));
        }
        CHECK(sums.variance.z == 0.0f);  // a constant is known exactly
    }
}

TEST_CASE("pixel sums: of one sample no variance is known", "[reference][pixel-sums]") {
    PixelSums sums = sums_of(paths(1, 3));
    const Vec3 sample = sums.image;
    finish(sums, 1);
    CHECK(sums.image == sample);
    CHECK(sums.variance == Vec3(0.0f));
}

TEST_CASE("pixel sums: the variance is that of means of other samples", "[reference][pixel-sums]") {
    constexpr std::uint32_t kRuns = 2000;
    constexpr std::uint32_t kSamples = 32;
    double mean = 0.0;
    double squares = 0.0;
    double stated = 0.0;
    for (std::uint32_t run = 0; run < kRuns; ++run) {
        PixelSums sums = sums_of(paths(kSamples, 100 + run));
        finish(sums, kSamples);
        const double value = sums.image.x;
        mean += value / kRuns;
        squares += value * value / kRuns;
        stated += double{sums.variance.x} / kRuns;
    }
    CHECK(stated == Approx(squares - mean * mean).epsilon(0.1));
}
