/// Reports with images in them, right and spoiled on purpose, for the tests of the report's forms.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "verify/report/report.h"

namespace scotty::verify::test {

/// A ball on a checkered floor under a sky, as a mean of 64 samples with the noise that goes with
/// it: every seed draws the same picture with other noise.
inline MeasuredImage picture(std::uint32_t seed, std::uint32_t size = 64) {
    MeasuredImage image;
    image.width = image.height = size;
    image.samples = 64;
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    for (std::uint32_t y = 0; y < size; ++y) {
        for (std::uint32_t x = 0; x < size; ++x) {
            const double u = (2.0 * x + 1.0) / size - 1.0;
            const double v = 1.0 - (2.0 * y + 1.0) / size;
            Color color{0.30 + 0.2 * v, 0.42 + 0.2 * v, 0.60 + 0.2 * v};
            const double r2 = (u * u + v * v) / 0.36;
            if (r2 < 1.0) {
                const double light =
                    std::max(0.0, (-0.5 * u + 0.7 * v) / 0.6 * 0.9 + 0.55 * std::sqrt(1.0 - r2));
                color = {0.06 + 0.80 * light, 0.05 + 0.42 * light, 0.05 + 0.22 * light};
            } else if (v < -0.25) {
                const double depth = 0.9 / (-0.1 - v);
                const bool dark = (static_cast<int>(std::floor(2.0 * u * depth)) +
                                   static_cast<int>(std::floor(2.0 * depth))) %
                                      2 !=
                                  0;
                color = dark ? Color{0.12, 0.12, 0.13} : Color{0.45, 0.43, 0.40};
            }
            Color variance{};
            for (std::size_t c = 0; c < 3; ++c) {
                variance[c] = std::pow(0.03 * color[c] + 0.001, 2);
                color[c] = std::max(0.0, color[c] + std::sqrt(variance[c]) * normal(random));
            }
            image.mean.push_back(color);
            image.variance.push_back(variance);
        }
    }
    return image;
}

/// Differences in standard deviations of the difference.
inline std::vector<Color> z_of(const MeasuredImage& a, const MeasuredImage& b) {
    std::vector<Color> z(a.mean.size());
    for (std::size_t i = 0; i < z.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            z[i][c] =
                (a.mean[i][c] - b.mean[i][c]) / std::sqrt(a.variance[i][c] + b.variance[i][c]);
        }
    }
    return z;
}

/// What follows from the images: z, and the pixels that stand out most, a NaN most of all.
inline void find_worst(ImageCase& image) {
    image.z = z_of(image.image, image.golden);
    std::vector<WorstPixel>& worst = image.verdict.worst;
    worst.clear();
    for (std::size_t i = 0; i < image.z.size(); ++i) {
        WorstPixel pixel;
        pixel.x = static_cast<std::uint32_t>(i % image.image.width);
        pixel.y = static_cast<std::uint32_t>(i / image.image.width);
        pixel.image = image.image.mean[i];
        pixel.golden = image.golden.mean[i];
        for (const double z : image.z[i]) {
            pixel.z = std::isnan(z) ? std::numeric_limits<double>::infinity()
                                    : std::max(pixel.z, std::abs(z));
        }
        worst.push_back(pixel);
    }
    std::stable_sort(worst.begin(), worst.end(),
                     [](const WorstPixel& p, const WorstPixel& q) { return p.z > q.z; });
    worst.resize(10);
}

inline GateResult gate(Gate which, double statistic, double p, double threshold) {
    GateResult result;
    result.gate = which;
    result.statistic = statistic;
    result.p_value = p;
    result.threshold = threshold;
    result.passed = !(p < threshold);
    result.width = result.height = 64;
    return result;
}

/// The verdict is made up: what the gates find is not this page's affair.
inline ImageCase passing_case(const std::string& name, std::uint32_t seed) {
    ImageCase image;
    image.name = name;
    image.image = picture(seed);
    image.golden = picture(seed + 1000);
    image.verdict.gates = {gate(Gate::layout, 0, 1, 0), gate(Gate::finite, 0, 1, 0),
                           gate(Gate::global, 1.31, 0.19, 3.3e-5),
                           gate(Gate::tile, 3.02, 2.5e-3, 1.7e-7),
                           gate(Gate::pixel, 4.11, 4.0e-5, 2.7e-9)};
    image.verdict.metrics = {0.0113, 1.6e-3, 38.2, 8.1e6};
    find_worst(image);
    image.replay = "scotty verify '" + name + "' --golden-only";
    image.approve = "scotty golden approve " + name + " --reason \"...\"";
    return image;
}

/// One tile 12 % too dark, and one pixel each that is NaN, infinite and negative.
inline ImageCase failing_case(const std::string& name, std::uint32_t seed) {
    ImageCase image = passing_case(name, seed);
    for (std::uint32_t y = 24; y < 32; ++y) {
        for (std::uint32_t x = 40; x < 48; ++x) {
            for (double& channel : image.image.mean[y * 64 + x]) channel *= 0.88;
        }
    }
    image.image.mean[10 * 64 + 12][1] = std::numeric_limits<double>::quiet_NaN();
    image.image.mean[50 * 64 + 20] = {std::numeric_limits<double>::infinity(), 1.0, 1.0};
    image.image.mean[51 * 64 + 21][2] = -0.25;
    find_worst(image);
    GateResult& finite = image.verdict.gates[1];
    finite.passed = false;
    finite.x = 12;
    finite.y = 10;
    finite.width = finite.height = 1;
    finite.text = "3 values are not finite or negative; the first is green of pixel (12, 10): nan";
    GateResult& tile = image.verdict.gates[3];
    tile = gate(Gate::tile, 14.2, 8.9e-46, 1.7e-7);
    tile.x = 40;
    tile.y = 24;
    tile.width = tile.height = 8;
    tile.text = "the tile at (40, 24) is darker than its golden tile: red 0.3512 for 0.3991";
    image.verdict.gates[4].ran = false;
    image.verdict.gates[4].text = "not asked: its samples are heavy-tailed (caustics)";
    image.verdict.metrics = {0.0268, 4.1e-3, 31.5, std::numeric_limits<double>::infinity()};
    return image;
}

inline SceneReport scene(const std::string& name) {
    SceneReport report;
    report.scene = name;
    report.source = name;
    report.triangles = 1984;
    report.oracles_ran = true;
    report.hits.rays = report.hits.brute_force_rays = 16874;
    report.hits.embree_rays = 26182;
    report.image.pixels = report.image.identical = 1665;
    for (const char* label : {"baseline: width 8, 64 rays per block, early-out off",
                              "width 4, 32 rays per block, early-out level"}) {
        ConfigurationReport configuration;
        configuration.label = label;
        configuration.rays = 16990;
        configuration.counts.stages = 214;
        configuration.counts.pushes = 68211;
        configuration.counts.leaf_hits = 20113;
        configuration.seconds = 0.21;
        configuration.replay = "scotty verify '" + name + "' --width 8 --rays-per-block 64";
        report.configurations.push_back(configuration);
    }
    report.seconds = 0.6;
    return report;
}

inline Report report() {
    Report report;
    report.parameters.image_width = report.parameters.image_height = 64;
    report.threads = 2;
    report.command = "scotty verify --report build/report";
    report.scenes = {scene("cornell"), scene("spheres")};
    report.images = {passing_case("cornell", 1), passing_case("spheres", 2),
                     passing_case("coil", 3)};
    report.seconds = 12.3;
    return report;
}

/// The second scene's second configuration loses a ray, and the second image is spoiled.
inline Report failing_report() {
    Report failing = report();
    Failure failure;
    failure.invariant = invariant::kRequiredPresent;
    failure.stage = "bounce0/level0/intersect_root";
    failure.launch = 2;
    failure.level = 0;
    failure.node = 0;
    failure.block = 42;
    failure.ray = 2751;
    failure.field = "queue of child node 1";
    failure.expected = "the ray, which enters at 0x1.02f89p+2 (4.04642)";
    failure.found = "no such ray";
    failure.sentence = "a ray that enters the child's box was not pushed to it";
    failing.scenes[1].configurations[1].failures.push_back(failure);
    failing.images[1] = failing_case("spheres", 2);
    return failing;
}

}  // namespace scotty::verify::test
