/// Diffuse, mirror and glass: directions by the laws of optics, weights by energy.
#include "tests/properties.h"

#include <array>
#include <cmath>
#include <vector>

#include "reference/numerics/bsdf.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

Material material_of(MaterialKind kind) {
    Material material;
    material.kind = kind;
    material.reflectance = Vec3(0.5f, 0.25f, 0.125f);
    material.transmittance = Vec3(0.9f, 0.8f, 0.7f);
    material.ior = 1.5f;
    return material;
}

/// A unit direction that arrives at the plane z = 0 from above under an angle.
Vec3 arriving(double degrees) {
    const double angle = degrees * M_PI / 180.0;
    return {static_cast<float>(std::sin(angle)), 0.0f, static_cast<float>(-std::cos(angle))};
}

/// Fresnel's equations in double, from angles: the textbook's form, not the code's.
double fresnel_by_angles(double degrees_in, double n_in, double n_out) {
    const double in = degrees_in * M_PI / 180.0;
    const double sine = n_in / n_out * std::sin(in);
    if (sine >= 1.0) return 1.0;
    const double out = std::asin(sine);
    if (in < 1e-9) return std::pow((n_in - n_out) / (n_in + n_out), 2);
    const double s = std::sin(in - out) / std::sin(in + out);
    const double p = std::tan(in - out) / std::tan(in + out);
    return 0.5 * (s * s + p * p);
}

const Vec3 kUp(0.0f, 0.0f, 1.0f);

}  // namespace

TEST_CASE("reflect: the angle of exit is the angle of incidence", "[reference][bsdf]") {
    scotty::tests::check_property("mirrored about the normal", [](std::uint32_t seed) {
        Random random(seed);
        const Vec3 d = unit_vector(random);
        const Vec3 n = unit_vector(random);
        const Vec3 r = reflect(d, n);
        RC_ASSERT(std::abs(dot(r, n) + dot(d, n)) < 1e-6f);
        RC_ASSERT(std::abs(length(r) - 1.0f) < 1e-6f);
        RC_ASSERT(std::abs(dot(cross(d, n), r)) < 1e-6f);  // in the plane of incidence
    });
}

TEST_CASE("refract: Snell's law, in the plane of incidence", "[reference][bsdf]") {
    scotty::tests::check_property("n sin is kept", [](std::uint32_t seed) {
        Random random(seed);
        const Vec3 n = unit_vector(random);
        Vec3 d = unit_vector(random);
        if (dot(d, n) > 0.0f) d = d * -1.0f;
        const float eta = uniform(random, 0.4f, 2.5f);
        Vec3 t(0.0f);
        const double sine_in = length(cross(d, n));
        const bool passes = refract(d, n, eta, t);
        if (std::abs(eta * sine_in - 1.0) < 1e-5) return;  // at the critical angle either is right
        RC_ASSERT(passes == (eta * sine_in < 1.0));
        if (!passes) return;
        RC_ASSERT(dot(t, n) <= 0.0f);  // goes on to the other side
        RC_ASSERT(std::abs(length(t) - 1.0f) < 2e-6f);
        RC_ASSERT(std::abs(length(cross(t, n)) - eta * sine_in) < 2e-6);
        RC_ASSERT(std::abs(dot(cross(d, n), t)) < 2e-6f);
    });
}

TEST_CASE("refract: straight through at normal incidence and at equal indices",
          "[reference][bsdf]") {
    Vec3 t(0.0f);
    REQUIRE(refract(Vec3(0, 0, -1), kUp, 1.0f / 1.5f, t));
    CHECK(length(t - Vec3(0, 0, -1)) < 1e-6f);
    REQUIRE(refract(arriving(50.0), kUp, 1.0f, t));
    CHECK(length(t - arriving(50.0)) < 1e-6f);
}

TEST_CASE("Fresnel: 4 % at normal incidence on glass of index 1.5, from both sides",
          "[reference][bsdf]") {
    CHECK(fresnel_dielectric(1.0f, 1.0f / 1.5f) == Approx(0.04).margin(1e-6));
    CHECK(fresnel_dielectric(1.0f, 1.5f) == Approx(0.04).margin(1e-6));
    // Tabulated for n = 1.5 in air: 45 degrees 0.0502, 60 degrees 0.0892, 80 degrees 0.3877.
    CHECK(fresnel_dielectric(std::cos(0.25f * kPi), 1.0f / 1.5f) == Approx(0.0502).margin(1e-4));
    CHECK(fresnel_dielectric(0.5f, 1.0f / 1.5f) == Approx(0.0892).margin(1e-4));
    CHECK(fresnel_dielectric(std::cos(80.0f * kPi / 180.0f), 1.0f / 1.5f) ==
          Approx(0.3877).margin(2e-4));
    CHECK(fresnel_dielectric(0.0f, 1.0f / 1.5f) == 1.0f);
    CHECK(fresnel_dielectric(1.0f, 1.0f) == 0.0f);
}

TEST_CASE("Fresnel: at Brewster's angle one polarisation is not reflected", "[reference][bsdf]") {
    const double brewster = std::atan(1.5);
    const double sine2 = std::pow(std::sin(2.0 * brewster - 0.5 * M_PI), 2);
    // What is left is half of the perpendicular part, sin^2(in - out) with in + out = 90 degrees.
    CHECK(fresnel_dielectric(static_cast<float>(std::cos(brewster)), 1.0f / 1.5f) ==
          Approx(0.5 * sine2).margin(1e-6));
}

TEST_CASE("Fresnel: equals the textbook over all angles, total reflection included",
          "[reference][bsdf]") {
    for (const double ior : {1.1, 1.33, 1.5, 2.4}) {
        for (int degrees = 0; degrees < 90; ++degrees) {
            const auto cosine = static_cast<float>(std::cos(degrees * M_PI / 180.0));
            const auto into = static_cast<float>(1.0 / ior);
            INFO("index " << ior << ", " << degrees << " degrees");
            CHECK(fresnel_dielectric(cosine, into) ==
                  Approx(fresnel_by_angles(degrees, 1.0, ior)).margin(2e-5));
            const double critical = std::asin(1.0 / ior) * 180.0 / M_PI;
            if (std::abs(degrees - critical) < 0.5) continue;  // infinitely steep there
            CHECK(fresnel_dielectric(cosine, static_cast<float>(ior)) ==
                  Approx(fresnel_by_angles(degrees, ior, 1.0)).margin(2e-4));
        }
    }
}

TEST_CASE("material table: diffuse scatters to the normal's side and weighs its albedo",
          "[reference][bsdf]") {
    const Material diffuse = material_of(MaterialKind::diffuse);
    for (const bool front : {true, false}) {
        const BsdfSample s =
            sample_bsdf(diffuse, arriving(30.0), kUp, front, {0.3f, 0.7f, 0.0f, 0.0f});
        CHECK(dot(s.direction, kUp) > 0.0f);
        CHECK(s.weight == diffuse.reflectance);
        CHECK_FALSE(s.specular);
        CHECK_FALSE(s.transmitted);
    }
}

TEST_CASE("material table: a mirror reflects, weighs its own tint and ignores chance",
          "[reference][bsdf]") {
    const Material mirror = material_of(MaterialKind::mirror);
    for (const float chance : {0.0f, 0.5f, 0.99f}) {
        const BsdfSample s =
            sample_bsdf(mirror, arriving(30.0), kUp, true, {chance, chance, chance, chance});
        CHECK(length(s.direction - reflect(arriving(30.0), kUp)) < 1e-6f);
        CHECK(s.weight == mirror.reflectance);
        CHECK(s.specular);
        CHECK_FALSE(s.transmitted);
    }
}

TEST_CASE("material table: glass reflects with its Fresnel share, else refracts",
          "[reference][bsdf]") {
    const Material glass = material_of(MaterialKind::glass);
    const double share = fresnel_by_angles(30.0, 1.0, 1.5);
    for (const double chance : {0.0, 0.99 * share, 1.01 * share, 0.999}) {
        const auto c = static_cast<float>(chance);
        const BsdfSample s = sample_bsdf(glass, arriving(30.0), kUp, true, {0.0f, 0.0f, c, 0.0f});
        CHECK(s.specular);
        CHECK(s.transmitted == (chance > share));
        if (s.transmitted) {
            CHECK(s.direction.x == Approx(0.5 / 1.5).margin(1e-6));  // Snell: sin 30 / 1.5
            CHECK(length(s.weight - glass.transmittance / (1.5f * 1.5f)) < 1e-6f);
        } else {
            CHECK(length(s.direction - reflect(arriving(30.0), kUp)) < 1e-6f);
            CHECK(s.weight == glass.reflectance);
        }
    }
}

TEST_CASE("material table: glass from inside: denser, and total reflection beyond 41.8 degrees",
          "[reference][bsdf]") {
    const Material glass = material_of(MaterialKind::glass);
    const Random4 refracts{0.0f, 0.0f, 0.9999f, 0.0f};
    const BsdfSample out = sample_bsdf(glass, arriving(30.0), kUp, false, refracts);
    CHECK(out.transmitted);
    CHECK(out.direction.x == Approx(0.75).margin(1e-6));  // sin 30 * 1.5
    CHECK(length(out.weight - glass.transmittance * (1.5f * 1.5f)) < 1e-5f);
    const BsdfSample total = sample_bsdf(glass, arriving(42.0), kUp, false, refracts);
    CHECK_FALSE(total.transmitted);
    CHECK(total.weight == glass.reflectance);
}

TEST_CASE("energy: clear glass loses nothing: in and out again a path weighs one",
          "[reference][bsdf]") {
    Material glass = material_of(MaterialKind::glass);
    glass.reflectance = glass.transmittance = Vec3(1.0f);
    const Random4 refracts{0.0f, 0.0f, 0.9999f, 0.0f};
    for (const double degrees : {0.0, 20.0, 45.0, 70.0}) {
        const Vec3 d = arriving(degrees);
        const BsdfSample in = sample_bsdf(glass, d, kUp, true, refracts);
        const BsdfSample out = sample_bsdf(glass, in.direction, kUp, false, refracts);
        REQUIRE((in.transmitted && out.transmitted));
        CHECK(in.weight.x * out.weight.x == Approx(1.0f).margin(1e-6));
        CHECK(length(out.direction - d) < 2e-6f);  // a plane-parallel plate
    }
}

TEST_CASE("energy: no material of albedo at most one gives weights above one, nor NaN",
          "[reference][bsdf]") {
    scotty::tests::check_property("weights", [](std::uint32_t seed) {
        Random random(seed);
        const Vec3 n = unit_vector(random);
        Vec3 d = unit_vector(random);
        if (dot(d, n) > 0.0f) d = d * -1.0f;
        for (const MaterialKind kind :
             {MaterialKind::diffuse, MaterialKind::mirror, MaterialKind::glass}) {
            Material material = material_of(kind);
            material.ior = uniform(random, 1.0f, 3.0f);
            const bool front = random() % 2 == 0;
            const Random4 r{uniform(random, 0, 1), uniform(random, 0, 1), uniform(random, 0, 1),
                            uniform(random, 0, 1)};
            const BsdfSample s = sample_bsdf(material, d, n, front, r);
            RC_ASSERT(std::abs(length(s.direction) - 1.0f) < 2e-6f);
            const float eta2 =
                front ? 1.0f / (material.ior * material.ior) : material.ior * material.ior;
            const float most = s.transmitted ? eta2 : 1.0f;
            RC_ASSERT(max_component(s.weight) <= most);
            RC_ASSERT(s.weight.x >= 0.0f);
            RC_ASSERT(s.transmitted == (dot(s.direction, n) < 0.0f));
        }
    });
}

TEST_CASE("glass: grazing and equal indices give finite directions", "[reference][bsdf]") {
    Material glass = material_of(MaterialKind::glass);
    for (const float ior : {1.0f, 1.5f}) {
        glass.ior = ior;
        for (const Vec3& d : {Vec3(1, 0, 0), Vec3(1, 0, -1e-7f), Vec3(0, 0, -1)}) {
            for (const float c : {0.0f, 0.9999f}) {
                const BsdfSample s = sample_bsdf(glass, d, kUp, true, {0.0f, 0.0f, c, 0.0f});
                CHECK(std::abs(length(s.direction) - 1.0f) < 1e-5f);
            }
        }
    }
}

namespace {

Material metal_of(float roughness, const Vec3& head_on = Vec3(1.0f)) {
    Material material = material_of(MaterialKind::conductor);
    material.reflectance = head_on;
    material.ior = roughness;
    return material;
}

Vec3 leaving(double cosine, double azimuth) {
    const double sine = std::sqrt(1.0 - cosine * cosine);
    return {static_cast<float>(sine * std::cos(azimuth)),
            static_cast<float>(sine * std::sin(azimuth)), static_cast<float>(cosine)};
}

/// The density of directions that the visible facets reflect to, in double, by angles: facets seen
/// by the viewer (Heitz 2014), and the Jacobian of the reflection.
double density_of_reflection(double alpha, const Vec3& viewer, const Vec3& light) {
    const double h[] = {double{viewer.x} + light.x, double{viewer.y} + light.y,
                        double{viewer.z} + light.z};
    const double cosine = h[2] / std::sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]);
    const double tangent2 = (1.0 - cosine * cosine) / (cosine * cosine);
    const double facets = 1.0 / (M_PI * alpha * alpha * std::pow(cosine, 4) *
                                 std::pow(1.0 + tangent2 / (alpha * alpha), 2));
    const double viewer_tangent2 = 1.0 / (double{viewer.z} * viewer.z) - 1.0;
    const double seen = 2.0 / (1.0 + std::sqrt(1.0 + alpha * alpha * viewer_tangent2));
    return seen * facets / (4.0 * viewer.z);
}

constexpr double kRoughnesses[] = {0.3, 0.5, 0.8, 1.0};

}  // namespace

TEST_CASE("rough metal: directions follow the density of visible facets",
          "[reference][bsdf][metal]") {
    constexpr int kRings = 24;
    constexpr int kSectors = 16;
    constexpr int kParts = 12;  // of a cell's side, for its integral
    constexpr int kSamples = 200'000;
    for (const double roughness : kRoughnesses) {
        for (const double degrees : {5.0, 45.0, 75.0}) {
            const Vec3 viewer = arriving(degrees) * -1.0f;
            const Material material = metal_of(static_cast<float>(roughness));
            const auto cell_of = [&](double cosine, double azimuth) {
                const int ring = std::min(kRings - 1, static_cast<int>(cosine * kRings));
                const double turn = azimuth / (2.0 * M_PI) + (azimuth < 0.0 ? 1.0 : 0.0);
                return ring * kSectors + std::min(kSectors - 1, static_cast<int>(turn * kSectors));
            };
            std::vector<double> expected(kRings * kSectors);
            double above = 0.0;
            constexpr double kArea = 2.0 * M_PI / (kRings * kSectors * kParts * kParts);
            for (int i = 0; i < kRings * kParts; ++i) {
                for (int j = 0; j < kSectors * kParts; ++j) {
                    const double cosine = (i + 0.5) / (kRings * kParts);
                    const double azimuth = 2.0 * M_PI * (j + 0.5) / (kSectors * kParts);
                    const double density =
                        kArea * density_of_reflection(roughness * roughness, viewer,
                                                      leaving(cosine, azimuth));
                    expected[static_cast<std::size_t>(cell_of(cosine, azimuth))] += density;
                    above += density;
                }
            }
            std::vector<double> counts(expected.size());
            double below = 0.0;
            for (std::uint32_t i = 0; i < kSamples; ++i) {
                const BsdfSample s =
                    sample_bsdf(material, viewer * -1.0f, kUp, true, random4(7, i, 0, 0, 0));
                if (s.direction.z <= 0.0f) {
                    CHECK(s.weight == Vec3(0.0f));
                    ++below;
                    continue;
                }
                ++counts[static_cast<std::size_t>(
                    cell_of(s.direction.z, std::atan2(s.direction.y, s.direction.x)))];
            }
            // Cells of few are taken together.
            double rest = 0.0;
            double expected_rest = 0.0;
            double chi2 = 0.0;
            double freedom = -1.0;
            const auto add = [&](double count, double of) {
                chi2 += (count - of) * (count - of) / of;
                ++freedom;
            };
            for (std::size_t i = 0; i < counts.size(); ++i) {
                if (kSamples * expected[i] < 20.0) {
                    rest += counts[i];
                    expected_rest += kSamples * expected[i];
                } else {
                    add(counts[i], kSamples * expected[i]);
                }
            }
            if (expected_rest > 20.0) add(rest, expected_rest);
            if (kSamples * (1.0 - above) > 20.0) add(below, kSamples * (1.0 - above));
            const double spread = 2.0 / (9.0 * freedom);
            const double z = (std::cbrt(chi2 / freedom) - (1.0 - spread)) / std::sqrt(spread);
            INFO("roughness " << roughness << ", " << degrees << " degrees, " << freedom);
            CHECK(z < 4.5);
        }
    }
}

TEST_CASE("rough metal: a sample's weight is the value times cosine over density",
          "[reference][bsdf][metal]") {
    scotty::tests::check_property("weight", [](std::uint32_t seed) {
        Random random(seed);
        const double roughness = uniform(random, 0.1f, 1.0f);
        const Material material = metal_of(static_cast<float>(roughness), Vec3(0.9f, 0.6f, 0.3f));
        const Vec3 viewer = leaving(uniform(random, 0.1f, 1.0f), uniform(random, 0.0f, 6.0f));
        const BsdfSample s =
            sample_bsdf(material, viewer * -1.0f, kUp, true, random4(seed, 1, 2, 3, 4));
        if (s.direction.z < 0.02f) return;
        const Vec3 value = evaluate_bsdf(material, viewer, s.direction, kUp);
        const double alpha = static_cast<double>(material.ior) * material.ior;
        const double density = density_of_reflection(alpha, viewer, s.direction);
        for (int k = 0; k < 3; ++k) {
            const double expected = value[k] / M_PI * s.direction.z / density;
            RC_ASSERT(std::abs(s.weight[k] - expected) < 2e-3 * expected);
        }
    });
}

TEST_CASE("rough metal: light and viewer can change places", "[reference][bsdf][metal]") {
    scotty::tests::check_property("reciprocity", [](std::uint32_t seed) {
        Random random(seed);
        const Material material = metal_of(uniform(random, 0.0f, 1.0f), Vec3(0.9f, 0.6f, 0.3f));
        const Vec3 a = leaving(uniform(random, 0.01f, 1.0f), uniform(random, 0.0f, 6.0f));
        const Vec3 b = leaving(uniform(random, 0.01f, 1.0f), uniform(random, 0.0f, 6.0f));
        const Vec3 there = evaluate_bsdf(material, a, b, kUp);
        const Vec3 back = evaluate_bsdf(material, b, a, kUp);
        for (int k = 0; k < 3; ++k) {
            RC_ASSERT(std::abs(there[k] - back[k]) <= 1e-5f * std::abs(there[k]));
        }
    });
    const Vec3 up = leaving(0.5, 1.0);
    CHECK(evaluate_bsdf(metal_of(0.5f), up, Vec3(0, 0, -1), kUp) == Vec3(0.0f));
    CHECK(evaluate_bsdf(metal_of(0.5f), Vec3(0.6f, 0, -0.8f), up, kUp) == Vec3(0.0f));
    CHECK(evaluate_bsdf(material_of(MaterialKind::mirror), up, up, kUp) == Vec3(0.0f));
    CHECK(evaluate_bsdf(material_of(MaterialKind::diffuse), up, up, kUp) ==
          Vec3(0.5f, 0.25f, 0.125f));
}

TEST_CASE(
    "rough metal: in a white furnace it sends on what its integral says, never more than came",
    "[reference][bsdf][metal]") {
    for (const double roughness : {0.3, 0.5, 0.8, 1.0}) {
        for (const double cosine : {0.15, 0.5, 0.95}) {
            const Material material = metal_of(static_cast<float>(roughness));
            const Vec3 viewer = leaving(cosine, 0.7);
            double integral = 0.0;
            constexpr int kSteps = 400;
            for (int i = 0; i < kSteps; ++i) {
                for (int j = 0; j < kSteps; ++j) {
                    const double z = (i + 0.5) / kSteps;
                    const Vec3 light = leaving(z, 2.0 * M_PI * (j + 0.5) / kSteps);
                    integral += 2.0 * z / (kSteps * kSteps) *
                                static_cast<double>(evaluate_bsdf(material, viewer, light, kUp).x);
                }
            }
            double sampled = 0.0;
            constexpr std::uint32_t kSamples = 40'000;
            for (std::uint32_t i = 0; i < kSamples; ++i) {
                const Vec3 weight =
                    sample_bsdf(material, viewer * -1.0f, kUp, true, random4(11, i, 0, 0, 0))
                        .weight;
                CHECK(weight.x <= 1.0001f);
                sampled += static_cast<double>(weight.x) / kSamples;
            }
            INFO("roughness " << roughness << ", cosine " << cosine);
            CHECK(integral <= 1.0005);
            CHECK(sampled == Approx(integral).margin(0.006));
            if (roughness == 1.0) {  // facets of all directions alike: there is a closed form
                CHECK(integral ==
                      Approx(1.0 - cosine * std::log((1.0 + cosine) / cosine)).margin(1e-3));
            }
        }
    }
}

TEST_CASE("rough metal: head on it has its colour, at grazing angles it is white",
          "[reference][bsdf][metal]") {
    const Vec3 gold(1.0f, 0.78f, 0.34f);
    CHECK(fresnel_schlick(gold, 1.0f) == gold);
    CHECK(fresnel_schlick(gold, 0.0f) == Vec3(1.0f));
    // As smooth as floats allow: nearly all goes the mirror's way.
    const Vec3 d = arriving(30.0);
    const BsdfSample s = sample_bsdf(metal_of(0.0f, gold), d, kUp, true, {0.3f, 0.6f, 0.0f, 0.0f});
    CHECK(length(s.direction - reflect(d, kUp)) < 5e-3f);
    CHECK(s.specular);
    CHECK_FALSE(sample_bsdf(metal_of(0.5f, gold), d, kUp, true, {0.3f, 0.6f, 0.0f, 0.0f}).specular);
}
