/// Diffuse, mirror and glass: directions by the laws of optics, weights by energy.
#include <rapidcheck/catch.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "reference/numerics/bsdf.h"
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
    rc::prop("mirrored about the normal", [](std::uint32_t seed) {
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
    rc::prop("n sin is kept", [](std::uint32_t seed) {
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
    rc::prop("weights", [](std::uint32_t seed) {
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
