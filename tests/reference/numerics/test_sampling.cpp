/// Directions from uniform numbers: distributions, and frames for every normal.
#include "tests/properties.h"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "reference/numerics/rng.h"
#include "reference/numerics/sampling.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

/// A frame is right-handed and orthonormal within float rounding, and carries the normal it got.
void check_frame(const Vec3& n) {
    const Frame f = frame_around(n);
    INFO("normal " << n.x << ' ' << n.y << ' ' << n.z);
    const float tolerance = 2.0e-6f;
    CHECK(std::abs(dot(f.tangent, f.tangent) - 1.0f) < tolerance);
    CHECK(std::abs(dot(f.bitangent, f.bitangent) - 1.0f) < tolerance);
    CHECK(std::abs(dot(f.tangent, f.bitangent)) < tolerance);
    CHECK(std::abs(dot(f.tangent, f.normal)) < tolerance);
    CHECK(std::abs(dot(f.bitangent, f.normal)) < tolerance);
    CHECK(length(cross(f.tangent, f.bitangent) - f.normal) < 2.0f * tolerance);
    CHECK((f.normal.x == n.x && f.normal.y == n.y && f.normal.z == n.z));
}

double ulps(double error, double exact) {
    const auto f = static_cast<float>(std::abs(exact));
    return std::abs(error) / (std::nextafter(f, 2.0f) - f);
}

}  // namespace

TEST_CASE("sampling: sine and cosine of an octant are within two units in the last place",
          "[reference][sampling]") {
    double worst_sine = 0.0;
    double worst_cosine = 0.0;
    const int steps = 200000;
    for (int i = -steps; i <= steps; ++i) {
        const float x = kPi / 4.0f * (static_cast<float>(i) / static_cast<float>(steps));
        const SinCos got = sin_cos_octant(x);
        const double sine = std::sin(static_cast<double>(x));
        const double cosine = std::cos(static_cast<double>(x));
        if (i != 0) worst_sine = std::max(worst_sine, ulps(got.sine - sine, sine));
        worst_cosine = std::max(worst_cosine, ulps(got.cosine - cosine, cosine));
    }
    INFO("sine " << worst_sine << " ulps, cosine " << worst_cosine << " ulps");
    CHECK(worst_sine < 2.0);
    CHECK(worst_cosine < 2.0);
    CHECK(sin_cos_octant(0.0f).sine == 0.0f);
    CHECK(sin_cos_octant(0.0f).cosine == 1.0f);
}

TEST_CASE("sampling: the frame is orthonormal for all axis normals, both signs",
          "[reference][sampling]") {
    for (const float sign : {1.0f, -1.0f}) {
        check_frame(Vec3(sign, 0.0f, 0.0f));
        check_frame(Vec3(0.0f, sign, 0.0f));
        check_frame(Vec3(0.0f, 0.0f, sign));
    }
    check_frame(Vec3(1.0f, 0.0f, -0.0f));
    check_frame(Vec3(0.0f, -1.0f, -0.0f));
    for (const float z : {1e-7f, -1e-7f, 1e-30f, -1e-30f}) check_frame(Vec3(1.0f, 0.0f, z));
    // Where the construction is least stable: a hair off the south pole.
    for (const float x : {1e-2f, 1e-3f, 1e-4f, 1e-7f, -1e-7f, 1e-20f}) {
        check_frame(normalize_or(Vec3(x, 0.3f * x, -1.0f), Vec3(0.0f)));
    }
}

TEST_CASE("sampling: the frame is orthonormal for random normals", "[reference][sampling]") {
    Random random(1);
    for (int i = 0; i < 2000; ++i) check_frame(unit_vector(random));
}

TEST_CASE("sampling: disk points are uniform and stay inside", "[reference][sampling]") {
    constexpr int kRings = 8, kSectors = 16, kCells = kRings * kSectors, kDraws = 1 << 16;
    std::array<int, kCells> counts{};
    for (std::uint32_t i = 0; i < kDraws; ++i) {
        const Random4 r = random4(3, i, 0, 0, 0);
        const DiskPoint p = sample_disk(r.a, r.b);
        const double radius2 = double{p.x} * p.x + double{p.y} * p.y;
        REQUIRE(radius2 <= 1.0 + 3e-7);
        const double angle = std::atan2(p.y, p.x) / (2.0 * M_PI) + 0.5;
        // Equal areas: rings in r^2.
        const int ring = std::min(kRings - 1, static_cast<int>(radius2 * kRings));
        const int sector = std::min(kSectors - 1, static_cast<int>(angle * kSectors));
        ++counts[static_cast<std::size_t>(ring) * kSectors + static_cast<std::size_t>(sector)];
    }
    const double expected = static_cast<double>(kDraws) / kCells;
    double chi2 = 0.0;
    for (const int n : counts) chi2 += (n - expected) * (n - expected) / expected;
    // 127 degrees of freedom: 127 +- 16; 205 is nearly five standard deviations away.
    CHECK(chi2 < 205.0);
    CHECK(chi2 > 60.0);
}

TEST_CASE("sampling: corners, edges and centre of the square map onto the disk",
          "[reference][sampling]") {
    const float last = 1.0f - std::ldexp(1.0f, -24);
    for (const float u : {0.0f, 0.25f, 0.5f, 0.75f, last}) {
        for (const float v : {0.0f, 0.25f, 0.5f, 0.75f, last}) {
            const DiskPoint p = sample_disk(u, v);
            INFO(u << ' ' << v);
            CHECK(std::isfinite(p.x));
            CHECK(p.x * p.x + p.y * p.y <= 1.0f + 3e-7f);
            // Concentric: the larger of the square's coordinates is the radius.
            const float radius = std::max(std::abs(2.0f * u - 1.0f), std::abs(2.0f * v - 1.0f));
            CHECK(std::hypot(p.x, p.y) == Approx(radius).margin(1e-6));
        }
    }
    CHECK(sample_disk(0.5f, 0.5f).x == 0.0f);
}

TEST_CASE("sampling: cosine hemisphere: unit, never below the surface, cosine density",
          "[reference][sampling]") {
    const std::vector<Vec3> normals{Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(0, -1, 0), Vec3(1, 0, 0),
                                    normalize_or(Vec3(1, -2, 0.5f), Vec3(0.0f))};
    for (const Vec3& normal : normals) {
        constexpr std::uint32_t kDraws = 1u << 15;
        constexpr int kBands = 16;
        std::array<int, kBands> bands{};
        double mean_cosine = 0.0;
        std::array<double, 3> mean{};
        for (std::uint32_t i = 0; i < kDraws; ++i) {
            const Random4 r = random4(11, i, 0, 0, 0);
            const Vec3 d = sample_cosine_hemisphere(normal, r.a, r.b);
            const double cosine = dot(d, normal);
            REQUIRE(std::abs(dot(d, d) - 1.0f) < 1e-6f);
            REQUIRE(cosine > -1e-6);
            mean_cosine += cosine / kDraws;
            for (int axis = 0; axis < 3; ++axis) {
                mean[static_cast<std::size_t>(axis)] += d[axis] / static_cast<double>(kDraws);
            }
            // P(cosine <= c) = c^2: equal bands of c^2.
            ++bands[static_cast<std::size_t>(
                std::clamp(static_cast<int>(cosine * cosine * kBands), 0, kBands - 1))];
        }
        double chi2 = 0.0;
        const double expected = static_cast<double>(kDraws) / kBands;
        for (const int n : bands) chi2 += (n - expected) * (n - expected) / expected;
        CHECK(chi2 < 43.0);  // 15 degrees of freedom: five standard deviations
        // E[cosine] = 2/3, standard deviation sqrt(1/18); the mean direction is 2/3 of the normal.
        CHECK(std::abs(mean_cosine - 2.0 / 3.0) < 5.0 * std::sqrt(1.0 / 18.0 / kDraws));
        for (int axis = 0; axis < 3; ++axis) {
            CHECK(std::abs(mean[static_cast<std::size_t>(axis)] - 2.0 / 3.0 * normal[axis]) <
                  0.015);
        }
    }
}

TEST_CASE("sampling: no uniform number gives a direction that is not finite",
          "[reference][sampling]") {
    scotty::tests::check_property("finite and unit", [] {
        const auto number = [] {
            return to_unit_interval(*rc::gen::weightedOneOf<std::uint32_t>(
                {{6, rc::gen::arbitrary<std::uint32_t>()},
                 {1, rc::gen::element(0u, 0x7fffffffu, 0x80000000u, 0xffffffffu)}}));
        };
        Random random(*rc::gen::arbitrary<std::uint32_t>());
        const Vec3 normal = unit_vector(random);
        const Vec3 d = sample_cosine_hemisphere(normal, number(), number());
        RC_ASSERT(std::abs(dot(d, d) - 1.0f) < 1e-6f);
        RC_ASSERT(dot(d, normal) > -1e-6f);
    });
}
