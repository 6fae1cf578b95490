/// Lights against closed forms: form factors, Lambert's polygon formula, inverse squares.
#include "tests/properties.h"

#include <cmath>
#include <vector>

#include "reference/numerics/light_sampling.h"
#include "tests/catch.h"
#include "tests/reference/lights.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

void check_estimate(const Estimate& got, double exact) {
    INFO("estimated " << got.mean << " +- " << got.error << ", exact " << exact);
    // Samples stand off the light by kSurfaceOffset, which brings it nearer by as much.
    CHECK(std::abs(got.mean - exact) < 4.5 * got.error + 4.0 * kSurfaceOffset * exact);
    CHECK(got.error < 0.05 * exact);  // else the check above says nothing
}

const Vec3 kUpward(0.0f, 1.0f, 0.0f);
const Vec3 kDown(0.0f, -1.0f, 0.0f);

/// A square lamp of side 2 at a height, shining down.
Light square_above(float height) {
    return area_light(LightKind::parallelogram, Vec3(-1, height, -1), Vec3(2, 0, 0), Vec3(0, 0, 2),
                      3.0f);
}

}  // namespace

TEST_CASE("direct light: the fall-off follows the form factor at two distances",
          "[reference][light]") {
    const Light near = square_above(1.0f);
    REQUIRE(near.normal == kDown);
    // Differential element under the centre of a square of half side a at height h:
    // F = 4 / pi * a / sqrt(a^2 + h^2) * atan(a / sqrt(a^2 + h^2)), irradiance = pi F L.
    for (const double h : {0.25, 1.0, 2.0, 10.0, 100.0}) {
        const double r = std::sqrt(1.0 + h * h);
        const double exact = 3.0 * 4.0 / r * std::atan(1.0 / r);
        INFO("height " << h);
        check_estimate(irradiance(square_above(static_cast<float>(h)),
                                  surface_of(Vec3(0.0f), kUpward), 1u << 15),
                       exact);
    }
}

TEST_CASE("direct light: parallelograms and triangles agree with Lambert's polygon formula",
          "[reference][light]") {
    const std::vector<Vec3> normals{kUpward, normalize_or(Vec3(0.3f, 1, -0.2f), kUpward)};
    const Vec3 corner(-0.5f, 1.5f, 0.25f);
    const Vec3 x(1.0f, 0.3f, -0.2f);
    const Vec3 y(0.2f, 0.5f, 1.0f);
    for (const Vec3& normal : normals) {
        const Surface surface = surface_of(Vec3(0.25f, -0.1f, 0.1f), normal);
        const Light parallelogram = area_light(LightKind::parallelogram, corner, x, y, 1.0f);
        check_estimate(
            irradiance(parallelogram, surface, 1u << 15),
            lambert({corner, corner + x, corner + x + y, corner + y}, surface.position, normal));
        const Light triangle = area_light(LightKind::triangle, corner, x, y, 1.0f);
        check_estimate(irradiance(triangle, surface, 1u << 15),
                       lambert({corner, corner + x, corner + y}, surface.position, normal));
    }
}

TEST_CASE("direct light: two triangles light as the parallelogram that they make",
          "[reference][light]") {
    const Surface surface = surface_of(Vec3(0.5f, 0, 0), kUpward);
    const Light whole = square_above(1.0f);
    const Vec3 x(2, 0, 0);
    const Vec3 y(0, 0, 2);
    const Light half = area_light(LightKind::triangle, Vec3(-1, 1, -1), x, y, 3.0f);
    const Light other = area_light(LightKind::triangle, Vec3(1, 1, 1), x * -1.0f, y * -1.0f, 3.0f);
    REQUIRE(other.normal == kDown);
    const Estimate a = irradiance(half, surface, 1u << 15);
    const Estimate b = irradiance(other, surface, 1u << 15);
    const Estimate both = irradiance(whole, surface, 1u << 15);
    CHECK(std::abs(a.mean + b.mean - both.mean) < 4.5 * (a.error + b.error + both.error));
}

TEST_CASE("direct light: a light shines on its front side only", "[reference][light]") {
    for (const LightKind kind : {LightKind::parallelogram, LightKind::triangle}) {
        Light light = square_above(1.0f);
        light.kind = kind;
        CHECK(irradiance(light, surface_of(Vec3(0, 0, 0), kUpward), 100).mean > 0.0);
        CHECK(irradiance(light, surface_of(Vec3(0, 2, 0), kDown), 100).mean == 0.0);
        // In its own plane, too, there is nothing to see.
        CHECK(irradiance(light, surface_of(Vec3(3, 1, 0), kUpward), 100).mean == 0.0);
    }
}

TEST_CASE("direct light: a light of no area, or at the surface itself, gives black and no NaN",
          "[reference][light]") {
    const Light flat =
        area_light(LightKind::parallelogram, Vec3(0, 1, 0), Vec3(0.0f), Vec3(1, 0, 0), 1.0f);
    CHECK(irradiance(flat, surface_of(Vec3(0.0f), kUpward), 16).mean == 0.0);
    Light point;
    point.radiance = Vec3(1.0f);
    CHECK(irradiance(point, surface_of(Vec3(0.0f), kUpward), 16).mean == 0.0);
}

TEST_CASE("direct light: samples lie on the light, just off its front", "[reference][light]") {
    scotty::tests::check_property("on the light", [](std::uint32_t seed) {
        Random random(seed);
        const Vec3 x = uniform3(random, -1, 1);
        const Vec3 y = uniform3(random, -1, 1);
        const Vec3 corner = uniform3(random, -5, 5);
        const LightKind kind = random() % 2 == 0 ? LightKind::parallelogram : LightKind::triangle;
        const Light light = area_light(kind, corner, x, y, 1.0f);
        if (light.area < 0.05f) return;
        const Vec3 from = corner + light.normal * 3.0f + uniform3(random, -0.5f, 0.5f);
        const LightSample s = sample_light(light, surface_of(from, light.normal * -1.0f),
                                           uniform(random, 0, 1), uniform(random, 0, 1));
        RC_ASSERT(s.irradiance.x > 0.0f);
        const Vec3 p = from + s.direction * s.distance - corner;
        const float height = dot(p, light.normal);
        RC_ASSERT(height > -1e-5f);
        RC_ASSERT(height < 1e-3f);
        // Coordinates in the edges' (skew) basis.
        const Vec3 n = cross(x, y);
        const float scale = dot(n, n);
        const float u = dot(cross(p, y), n) / scale;
        const float v = dot(cross(x, p), n) / scale;
        const float slack = 2e-3f;
        RC_ASSERT((u > -slack && v > -slack));
        RC_ASSERT(
            (kind == LightKind::triangle ? u + v < 1 + slack : u < 1 + slack && v < 1 + slack));
    });
}

TEST_CASE("direct light: a point light falls off with the square of the distance",
          "[reference][light]") {
    Light light;
    light.kind = LightKind::point;
    light.radiance = Vec3(8.0f, 4.0f, 2.0f);
    for (const float h : {0.5f, 1.0f, 2.0f, 16.0f}) {
        light.position = Vec3(0, h, 0);
        const LightSample s = sample_light(light, surface_of(Vec3(0.0f), kUpward), 0.3f, 0.6f);
        CHECK(s.direction == kUpward);
        CHECK(s.distance == h);
        CHECK(s.irradiance == light.radiance / (h * h));
    }
}

TEST_CASE("direct light: a spot light sends the closed form's flux through a plane",
          "[reference][light]") {
    Light light;
    light.kind = LightKind::spot;
    light.position = Vec3(0, 2, 0);
    light.normal = kDown;
    light.radiance = Vec3(3.0f);
    for (const SpotCone& cone : {SpotCone{0.9f, 0.6f}, SpotCone{1.0f, 0.5f}, SpotCone{0.8f, 0.8f},
                                 SpotCone{0.999f, 0.3f}}) {
        set_spot_cone(light, cone);
        double flux = 0.0;
        const double edge = 2.0 * std::tan(std::acos(double{cone.outer}));
        constexpr int kRings = 20000;
        for (int i = 0; i < kRings; ++i) {
            const double radius = (i + 0.5) / kRings * edge;
            const Vec3 at(static_cast<float>(radius), 0, 0);
            const LightSample s = sample_light(light, surface_of(at, kUpward), 0.3f, 0.6f);
            const double irradiance = s.irradiance.x * std::max(0.0f, dot(s.direction, kUpward));
            flux += irradiance * 2.0 * M_PI * radius * edge / kRings;
        }
        // I times the cone's solid angle, weighted: full in the inner cone, and between the two the
        // mean of a squared ramp, 1/3.
        const double weight = (1.0 - cone.inner) + (double{cone.inner} - double{cone.outer}) / 3.0;
        INFO("cone " << cone.inner << " " << cone.outer);
        CHECK(flux == Approx(3.0 * 2.0 * M_PI * weight).epsilon(1e-3));
    }
}

TEST_CASE("direct light: a spot light is a point light inside its inner cone and black outside",
          "[reference][light]") {
    Light light;
    light.kind = LightKind::spot;
    light.position = Vec3(0, 1, 0);
    light.normal = kDown;
    light.radiance = Vec3(8.0f);
    set_spot_cone(light, {0.8f, 0.5f});
    Light point = light;
    point.kind = LightKind::point;
    const auto sampled = [](const Light& from, float x) {
        return sample_light(from, surface_of(Vec3(x, 0, 0), kUpward), 0.3f, 0.6f);
    };
    CHECK(sampled(light, 0.0f).irradiance == sampled(point, 0.0f).irradiance);
    CHECK(sampled(light, 0.7f).irradiance == sampled(point, 0.7f).irradiance);
    CHECK(sampled(light, 1.8f).irradiance == Vec3(0.0f));
    CHECK(sampled(light, -1.0f).irradiance.x < sampled(point, -1.0f).irradiance.x);
    CHECK(sampled(light, -1.0f).irradiance.x > 0.0f);
    light.normal = kUpward;
    CHECK(sampled(light, 0.0f).irradiance == Vec3(0.0f));
}

TEST_CASE("direct light: a directional light comes from infinity at full strength",
          "[reference][light]") {
    Light light;
    light.kind = LightKind::directional;
    light.normal = kDown;
    light.radiance = Vec3(2.0f);
    const LightSample s = sample_light(light, surface_of(Vec3(5, 6, 7), kUpward), 0.3f, 0.6f);
    CHECK(s.direction == kUpward);
    CHECK(s.distance == kInfinity);
    CHECK(s.irradiance == light.radiance);
}

TEST_CASE("direct light: an even environment gives an open surface pi times its radiance",
          "[reference][light]") {
    Light light;
    light.kind = LightKind::environment;
    light.radiance = Vec3(0.5f);
    const Vec3 normal = normalize_or(Vec3(1, 2, -3), kUpward);
    // Cosine sampling makes every sample worth the same: no variance.
    const Estimate got = irradiance(light, surface_of(Vec3(0.0f), normal), 1000);
    CHECK(got.mean == Approx(0.5 * M_PI).epsilon(1e-5));
    CHECK(got.error < 1e-3);
}

TEST_CASE("direct light: a hemisphere lights an upright wall half as much as a floor",
          "[reference][light]") {
    Light light;
    light.kind = LightKind::hemisphere;
    light.normal = kUpward;
    light.radiance = Vec3(0.5f);
    const Estimate floor = irradiance(light, surface_of(Vec3(0.0f), kUpward), 1000);
    CHECK(floor.mean == Approx(0.5 * M_PI).epsilon(1e-5));
    const Estimate wall = irradiance(light, surface_of(Vec3(0.0f), Vec3(1, 0, 0)), 20000);
    CHECK(std::abs(wall.mean - 0.25 * M_PI) < 5 * wall.error);
    const Estimate ceiling = irradiance(light, surface_of(Vec3(0.0f), kUpward * -1.0f), 1000);
    CHECK(ceiling.mean == 0.0);
}

TEST_CASE("environment: a hemisphere is seen above the horizon only", "[reference][light]") {
    SceneView scene;
    scene.environment = Vec3(0.25f);
    scene.hemisphere = Vec3(0.5f);
    CHECK(distant_radiance(scene, Vec3(0, 1, 0)) == Vec3(0.75f));
    CHECK(distant_radiance(scene, Vec3(0, -1, 0)) == Vec3(0.25f));
}
