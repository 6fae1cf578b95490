/// Samplers against their densities and estimators against integrals that are known in closed form.
/// Every check is first seen to fail: on a sampler or estimator with a planted fault.
#include <cmath>
#include <cstdint>
#include <vector>

#include "reference/numerics/bsdf.h"
#include "reference/numerics/light_sampling.h"
#include "reference/numerics/rng.h"
#include "reference/numerics/sampling.h"
#include "tests/catch.h"
#include "tests/reference/chi_square.h"
#include "tests/reference/lights.h"

namespace closed_forms {

using namespace scotty::reference;
using namespace scotty::reference::test;

constexpr std::uint32_t kDraws = 1u << 15;
constexpr std::size_t kCells = 12;

const std::vector<Vec3>& normals() {
    static const std::vector<Vec3> all{Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(0, 1, 0),
                                       normalize_or(Vec3(1, -2, 0.5f), Vec3(0.0f))};
    return all;
}

/// Calls `use` with kDraws quadruples of random numbers.
template <class Use>
void draw(std::uint32_t stream, const Use& use) {
    for (std::uint32_t i = 0; i < kDraws; ++i) use(random4(17, i, stream, 0, 0));
}

double turn_of(double y, double x) { return std::atan2(y, x) / (2.0 * M_PI) + 0.5; }

/// z of directions that should have the density cos(theta) / pi around a normal: cos^2 and the
/// angle around it are then uniform. `sample` maps four random numbers to a direction.
template <class Sample>
double cosine_z(const Vec3& normal, const Sample& sample) {
    const Frame frame = frame_around(normal);
    SquareCells cells(kCells);
    draw(1, [&](const Random4& random) {
        const Vec3 d = sample(random);
        const double cosine = dot(d, normal);
        cells.add(cosine * cosine, turn_of(dot(d, frame.bitangent), dot(d, frame.tangent)));
    });
    return cells.z();
}

/// The planted fault: uniform over the hemisphere, as if the cosine were forgotten.
Vec3 uniform_hemisphere(const Vec3& normal, float u, float v) {
    const float z = u;
    const float r = std::sqrt(1.0f - z * z);
    const float angle = 2.0f * kPi * v;
    return to_world(frame_around(normal), r * std::cos(angle), r * std::sin(angle), z);
}

TEST_CASE("chi square: has the table's quantiles, and sees too good a fit",
          "[reference][closed-form]") {
    // 101 cells of 100, 100 degrees of freedom: 124.342 is the 95 % quantile, z = 1.645.
    std::vector<std::uint32_t> counts(101, 100);
    CHECK(chi_square_z(counts) < -4.5);
    const auto off = static_cast<std::uint32_t>(std::lround(std::sqrt(124.342 * 100.0 / 2.0)));
    counts[3] += off;
    counts[7] -= off;
    CHECK(chi_square_z(counts) == Approx(1.645).margin(0.05));
    CHECK_FALSE(follows(5.0));
    CHECK_FALSE(follows(std::nan("")));
}

TEST_CASE("closed form: points on the disk are uniform", "[reference][closed-form]") {
    const auto z_of = [](const auto& sample) {
        SquareCells cells(kCells);
        draw(0, [&](const Random4& random) {
            const DiskPoint p = sample(random.a, random.b);
            cells.add(double{p.x} * p.x + double{p.y} * p.y, turn_of(p.y, p.x));
        });
        return cells.z();
    };
    CHECK_FALSE(follows(z_of([](float u, float v) {  // the square root of the radius forgotten
        return DiskPoint{u * std::cos(2.0f * kPi * v), u * std::sin(2.0f * kPi * v)};
    })));
    CHECK(follows(z_of(sample_disk)));
}

TEST_CASE("closed form: hemisphere directions have the density cosine over pi",
          "[reference][closed-form]") {
    for (const Vec3& normal : normals()) {
        CHECK_FALSE(follows(cosine_z(
            normal, [&](const Random4& r) { return uniform_hemisphere(normal, r.a, r.b); })));
        CHECK(follows(cosine_z(
            normal, [&](const Random4& r) { return sample_cosine_hemisphere(normal, r.a, r.b); })));
    }
}

TEST_CASE("closed form: diffuse surfaces scatter with the density cosine over pi",
          "[reference][closed-form]") {
    Material diffuse;
    diffuse.kind = MaterialKind::diffuse;
    for (const Vec3& normal : normals()) {
        const Vec3 tilted = normalize_or(normal + Vec3(0.1f, 0.05f, 0.0f), normal);
        const auto sampled = [&](const Vec3& around) {
            return cosine_z(normal, [&](const Random4& r) {
                return sample_bsdf(diffuse, normal * -1.0f, around, true, r).direction;
            });
        };
        CHECK_FALSE(follows(sampled(tilted)));  // around another normal
        CHECK(follows(sampled(normal)));
    }
}

TEST_CASE("closed form: environment and hemisphere lights send directions by the cosine",
          "[reference][closed-form]") {
    for (const LightKind kind : {LightKind::environment, LightKind::hemisphere}) {
        Light light;
        light.kind = kind;
        light.radiance = Vec3(1.0f);
        for (const Vec3& normal : normals()) {
            light.normal = normal;  // all of the surface's sky is in the light's hemisphere
            const Surface surface = surface_of(Vec3(0.0f), normal);
            const auto z_with = [&](std::uint32_t step) {
                return cosine_z(normal, [&](const Random4& r) {
                    return sample_light(light, surface, step == 0 ? r.a : 0.9f * r.a, r.b)
                        .direction;
                });
            };
            CHECK_FALSE(follows(z_with(1)));  // numbers that do not reach 1
            CHECK(follows(z_with(0)));
        }
    }
}

/// Where a sample lies on a light: coordinates in its edges' (skew) basis.
template <class Use>
void points_on(const Light& light, const Surface& surface, bool whole, const Use& use) {
    const Vec3 n = cross(light.edge_x, light.edge_y);
    draw(2, [&](const Random4& random) {
        const LightSample s =
            sample_light(light, surface, whole ? random.a : 0.9f * random.a, random.b);
        const Vec3 p = surface.position + s.direction * s.distance - light.position;
        use(dot(cross(p, light.edge_y), n) / dot(n, n), dot(cross(light.edge_x, p), n) / dot(n, n));
    });
}

TEST_CASE("closed form: points on area lights are uniform by area", "[reference][closed-form]") {
    const Vec3 corner(-0.5f, 1.5f, 0.25f);
    const Vec3 x(1.0f, 0.3f, -0.2f);
    const Vec3 y(0.2f, 0.5f, 1.0f);
    const Surface surface = surface_of(Vec3(0.25f, -3.0f, 0.1f), Vec3(0, 1, 0));
    for (const bool whole : {false, true}) {  // false, the fault: numbers that do not reach 1
        SquareCells parallelogram(kCells);
        points_on(area_light(LightKind::parallelogram, corner, x, y, 1.0f), surface, whole,
                  [&](double u, double v) { parallelogram.add(u, v); });
        CHECK(follows(parallelogram.z()) == whole);
        // Uniform on u + v < 1: (u + v)^2 and u / (u + v) are uniform.
        SquareCells triangle(kCells);
        points_on(area_light(LightKind::triangle, corner, x, y, 1.0f), surface, whole,
                  [&](double u, double v) { triangle.add((u + v) * (u + v), u / (u + v)); });
        CHECK(follows(triangle.z()) == whole);
    }
}

TEST_CASE("closed form: glass reflects with the tabulated Fresnel share of its samples",
          "[reference][closed-form]") {
    Material glass;
    glass.kind = MaterialKind::glass;
    glass.reflectance = glass.transmittance = Vec3(1.0f);
    // Index 1.5 in air, unpolarised (Hecht, Optics: r_s^2 and r_p^2 averaged).
    struct Row {
        double degrees, share;
    };
    for (const Row& row : {Row{0, 0.0400}, Row{30, 0.0415}, Row{45, 0.0502}, Row{60, 0.0892},
                           Row{75, 0.2531}, Row{85, 0.6128}}) {
        const double angle = row.degrees * M_PI / 180.0;
        const Vec3 d(static_cast<float>(std::sin(angle)), 0.0f,
                     static_cast<float>(-std::cos(angle)));
        const auto z_with = [&](float ior) {
            glass.ior = ior;
            double reflected = 0.0;
            draw(3, [&](const Random4& random) {
                if (!sample_bsdf(glass, d, Vec3(0, 0, 1), true, random).transmitted) ++reflected;
            });
            return (reflected - kDraws * row.share) /
                   std::sqrt(kDraws * row.share * (1.0 - row.share));
        };
        INFO(row.degrees << " degrees");
        CHECK_FALSE(follows(z_with(1.7f)));  // another glass
        CHECK(follows(z_with(1.5f)));
    }
}

struct Furnace {
    double mean, error;
};

/// What a surface with that material sends back along -d when everything around it is alike: `sky`
/// gives the radiance that arrives from a direction; inside a denser medium it is eta^2 as large.
template <class Sky, class Sample>
Furnace furnace(const Material& material, double degrees, bool front, const Sky& sky,
                const Sample& sample) {
    const double angle = degrees * M_PI / 180.0;
    const Vec3 d(static_cast<float>(std::sin(angle)), 0.0f, static_cast<float>(-std::cos(angle)));
    const double inside = double{material.ior} * material.ior;
    double sum = 0.0;
    double squares = 0.0;
    draw(4, [&](const Random4& random) {
        const BsdfSample s = sample(material, d, Vec3(0, 0, 1), front, random);
        const bool denser = material.kind == MaterialKind::glass && s.transmitted == front;
        const double value = s.weight.x * sky(s.direction) * (denser ? inside : 1.0);
        sum += value;
        squares += value * value;
    });
    const double mean = sum / kDraws;
    return {mean, std::sqrt(std::max(0.0, squares / kDraws - mean * mean) / kDraws)};
}

bool agrees(const Furnace& got, double exact) {
    return std::abs(got.mean - exact) < 4.5 * got.error + 1e-5 * exact;
}

TEST_CASE("closed form: in a white furnace every material sends back what arrives",
          "[reference][closed-form]") {
    const auto even = [](const Vec3&) { return 1.0; };
    const auto without_compression = [](const Material& m, const Vec3& d, const Vec3& n, bool front,
                                        const Random4& r) {
        BsdfSample s = sample_bsdf(m, d, n, front, r);
        if (s.transmitted) s.weight = m.transmittance;  // radiance not scaled by eta^2
        return s;
    };
    for (const MaterialKind kind :
         {MaterialKind::diffuse, MaterialKind::mirror, MaterialKind::glass}) {
        Material white;
        white.kind = kind;
        white.reflectance = white.transmittance = Vec3(1.0f);
        white.ior = 1.5f;
        Material grey = white;
        grey.reflectance = grey.transmittance = Vec3(0.98f);
        for (const double degrees : {0.0, 30.0, 60.0, 85.0}) {
            for (const bool front : {true, false}) {
                // Seen from inside, what comes back is inside too, and eta^2 as large.
                const double exact = kind == MaterialKind::glass && !front ? 1.5 * 1.5 : 1.0;
                INFO("kind " << static_cast<int>(kind) << ", " << degrees << " degrees, front "
                             << front);
                CHECK_FALSE(agrees(furnace(grey, degrees, front, even, sample_bsdf), exact));
                CHECK(agrees(furnace(white, degrees, front, even, sample_bsdf), exact));
                const bool passes = kind == MaterialKind::glass && (front || degrees < 41.0);
                CHECK(agrees(furnace(white, degrees, front, even, without_compression), exact) !=
                      passes);
            }
        }
    }
}

TEST_CASE("closed form: under a sky that brightens to one side a diffuse surface is known",
          "[reference][closed-form]") {
    // Radiance 1 + t.w: the cosine-weighted mean of w is 2/3 of the normal.
    const Vec3 t(0.4f, 0.0f, 0.5f);
    const auto sky = [&](const Vec3& w) { return 1.0 + dot(t, w); };
    Material diffuse;
    diffuse.kind = MaterialKind::diffuse;
    diffuse.reflectance = Vec3(0.5f);
    const double exact = 0.5 * (1.0 + 2.0 / 3.0 * 0.5);
    const auto without_cosine = [](const Material& m, const Vec3&, const Vec3& n, bool,
                                   const Random4& r) {
        return BsdfSample{uniform_hemisphere(n, r.a, r.b), m.reflectance, false, false};
    };
    CHECK_FALSE(agrees(furnace(diffuse, 30.0, true, sky, without_cosine), exact));
    CHECK(agrees(furnace(diffuse, 30.0, true, sky, sample_bsdf), exact));
}

bool agrees(const Estimate& got, double exact) {
    // Samples stand off the light by kSurfaceOffset, which brings it nearer by as much.
    return std::abs(got.mean - exact) < 4.5 * got.error + 4.0 * kSurfaceOffset * exact;
}

TEST_CASE("closed form: Lambert's formula tells a light with a fault", "[reference][closed-form]") {
    const Vec3 corner(-0.5f, 1.5f, 0.25f);
    const Vec3 x(1.0f, 0.3f, -0.2f);
    const Vec3 y(0.2f, 0.5f, 1.0f);
    const Surface surface = surface_of(Vec3(0.25f, -0.1f, 0.1f), Vec3(0, 1, 0));
    const Light light = area_light(LightKind::parallelogram, corner, x, y, 1.0f);
    const double exact =
        lambert({corner, corner + x, corner + x + y, corner + y}, surface.position, Vec3(0, 1, 0));
    const auto with = [&](const auto& factor) {
        return irradiance(light, surface, kDraws,
                          [&](const Light& l, const Surface& s, float u, float v) {
                              LightSample sample = sample_light(l, s, u, v);
                              sample.irradiance = sample.irradiance * factor(sample);
                              return sample;
                          });
    };
    CHECK(agrees(with([](const LightSample&) { return 1.0f; }), exact));
    CHECK_FALSE(agrees(with([](const LightSample&) { return 1.02f; }), exact));  // density scaled
    CHECK_FALSE(agrees(with([&](const LightSample& s) {  // cosine at the light left out
                           return -1.0f / dot(s.direction, light.normal);
                       }),
                       exact));
    CHECK_FALSE(agrees(with([&](const LightSample& s) { return s.distance; }), exact));  // 1 / d
}

TEST_CASE("closed form: a lamp that is half below the horizon lights with its upper half",
          "[reference][closed-form]") {
    // A wall's point at the height of the middle of a lamp that faces it.
    const Vec3 corner(2.0f, -1.0f, 1.0f);
    const Vec3 x(0, 2, 0);
    const Vec3 y(0, 0, -2);
    const Light light = area_light(LightKind::parallelogram, corner, x, y, 1.0f);
    REQUIRE(light.normal == Vec3(-1, 0, 0));
    const Surface surface = surface_of(Vec3(0.0f), Vec3(0, 1, 0));
    const Vec3 middle(2.0f, 0.0f, 1.0f);
    const Vec3 up(0, 1, 0);
    const double exact =
        lambert({middle, middle + up, middle + up + y, middle + y}, surface.position, up);
    CHECK(exact > 0.05);
    CHECK(agrees(irradiance(light, surface, kDraws), exact));
    CHECK_FALSE(agrees(irradiance(light, surface, kDraws), 1.05 * exact));
}

TEST_CASE("closed form: a hemisphere lights a tilted plane by (1 + cosine) / 2 of its sky",
          "[reference][closed-form]") {
    Light light;
    light.kind = LightKind::hemisphere;
    light.normal = Vec3(0, 1, 0);
    light.radiance = Vec3(0.5f);
    for (const double degrees : {20.0, 60.0, 100.0, 150.0}) {
        const double angle = degrees * M_PI / 180.0;
        const Vec3 normal(static_cast<float>(std::sin(angle)), static_cast<float>(std::cos(angle)),
                          0.0f);
        const Estimate got = irradiance(light, surface_of(Vec3(0.0f), normal), kDraws);
        INFO(degrees << " degrees: " << got.mean << " +- " << got.error);
        CHECK(agrees(got, 0.5 * M_PI * 0.5 * (1.0 + std::cos(angle))));
        // As if the horizon were not there, or the cosine counted whole.
        CHECK_FALSE(agrees(got, 0.5 * M_PI));
        CHECK_FALSE(agrees(got, 0.5 * M_PI * std::abs(std::cos(angle))));
    }
}

}  // namespace closed_forms
