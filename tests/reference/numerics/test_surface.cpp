/// From hit to surface point, and rays that leave without hitting what they left.
#include "tests/properties.h"

#include <cmath>
#include <optional>

#include "reference/numerics/intersect_triangle.h"
#include "reference/numerics/sampling.h"
#include "reference/numerics/surface.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

std::optional<Hit> hit_of(const Scene& scene, const Ray& ray) {
    Hit hit = no_hit();
    if (!intersect_triangle(ray, safe_inverse(ray.direction), ray_shear(ray.direction),
                            scene.vertices[0], scene.vertices[1], scene.vertices[2], hit)) {
        return std::nullopt;
    }
    hit.primitive = 0;
    return hit;
}

/// The plane z = 0, front (counter-clockwise) towards +z.
Scene facing_up() { return triangle_scene(Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0)); }

Surface surface_seen(const Scene& scene, const Ray& ray) {
    const std::optional<Hit> hit = hit_of(scene, ray);
    REQUIRE(hit.has_value());
    return surface_at(view_of(scene), ray, *hit);
}

}  // namespace

TEST_CASE("surface: front is the side of counter-clockwise winding", "[reference][surface]") {
    const Scene scene = facing_up();
    const Surface above = surface_seen(scene, {Vec3(0, 0, 2), 0.0f, Vec3(0, 0, -1), kInfinity});
    CHECK(above.front);
    CHECK(above.geometric_normal == Vec3(0, 0, 1));
    CHECK(above.position == Vec3(0, 0, 0));
    const Surface below = surface_seen(scene, {Vec3(0, 0, -2), 0.0f, Vec3(0, 0, 1), kInfinity});
    CHECK_FALSE(below.front);
    CHECK(below.geometric_normal == Vec3(0, 0, -1));  // faces the viewer either way
    CHECK(below.shading_normal == Vec3(0, 0, -1));
}

TEST_CASE("surface: the position is on the ray and on the triangle", "[reference][surface]") {
    scotty::tests::check_property("position", [](std::uint32_t seed) {
        Random random(seed);
        const Scene scene = soup(1, 1.0f, seed);
        const Ray ray{uniform3(random, -3, 3), 0.0f,
                      normalize_or(scene.vertices[0] * 0.4f + scene.vertices[1] * 0.35f +
                                       scene.vertices[2] * 0.25f - Vec3(0.0f),
                                   Vec3(0, 0, 1)),
                      kInfinity};
        const std::optional<Hit> hit = hit_of(scene, ray);
        if (!hit) return;
        const Surface surface = surface_at(view_of(scene), ray, *hit);
        const Vec3 edge =
            cross(scene.vertices[1] - scene.vertices[0], scene.vertices[2] - scene.vertices[0]);
        if (length(edge) < 1e-2f || std::abs(dot(surface.geometric_normal, ray.direction)) < 0.1f) {
            return;  // slivers and edge-on views: no accurate point exists
        }
        RC_ASSERT(length(surface.position - (ray.origin + ray.direction * hit->t)) < 1e-4f);
        RC_ASSERT(std::abs(dot(surface.geometric_normal, surface.position - scene.vertices[0])) <
                  1e-5f);
        RC_ASSERT(dot(surface.geometric_normal, ray.direction) < 0.0f);
    });
}

TEST_CASE("surface: smooth normals are interpolated, and zero ones mean flat",
          "[reference][surface]") {
    Scene scene = facing_up();
    const Vec3 lean = normalize_or(Vec3(0.5f, 0.0f, 1.0f), Vec3(0.0f));
    scene.normals = {lean, lean, lean};
    const Ray down{Vec3(0, 0, 2), 0.0f, Vec3(0, 0, -1), kInfinity};
    CHECK(length(surface_seen(scene, down).shading_normal - lean) < 1e-6f);
    CHECK(surface_seen(scene, down).geometric_normal == Vec3(0, 0, 1));
    const Ray up{Vec3(0, 0, -2), 0.0f, Vec3(0, 0, 1), kInfinity};
    CHECK(length(surface_seen(scene, up).shading_normal + lean) < 1e-6f);  // flipped with the side
    scene.normals = {Vec3(0.0f), Vec3(0.0f), Vec3(0.0f)};
    CHECK(surface_seen(scene, down).shading_normal == Vec3(0, 0, 1));
}

TEST_CASE("surface: a smooth normal that faces away from the viewer is not used",
          "[reference][surface]") {
    Scene scene = facing_up();
    const Vec3 lean = normalize_or(Vec3(1.0f, 0.0f, 0.2f), Vec3(0.0f));
    scene.normals = {lean, lean, lean};
    const Vec3 direction = normalize_or(Vec3(1.0f, 0.0f, -0.5f), Vec3(0.0f));
    const Surface surface =
        surface_seen(scene, {Vec3(0, 0, 0) - direction, 0.0f, direction, kInfinity});
    CHECK(dot(lean, direction) > 0.0f);
    CHECK(surface.shading_normal == surface.geometric_normal);
}

TEST_CASE("leave_surface: starts off the side that it leaves to", "[reference][surface]") {
    const Scene scene = facing_up();
    const Surface surface = surface_seen(scene, {Vec3(0, 0, 2), 0.0f, Vec3(0, 0, -1), kInfinity});
    CHECK(surface.offset == kSurfaceOffset);  // coordinates up to 1
    const Ray reflected = leave_surface(surface, Vec3(0, 0, 1), 7.0f);
    CHECK(reflected.origin.z == surface.offset);
    CHECK(reflected.t_min == 0.0f);
    CHECK(reflected.t_max == 7.0f);
    CHECK(leave_surface(surface, Vec3(0, 0, -1), 7.0f).origin.z == -surface.offset);
}

TEST_CASE("leave_surface: the offset follows the scene's scale, no absolute epsilon",
          "[reference][surface]") {
    const Scene unit = facing_up();
    const Ray ray{Vec3(0, 0, 2), 0.0f, Vec3(0, 0, -1), kInfinity};
    const float at_one = surface_seen(unit, ray).offset;
    for (const float scale : {0.01f, 100.0f}) {
        Scene scaled = unit;
        for (Vec3& v : scaled.vertices) v *= scale;
        Ray far = ray;
        far.origin *= scale;
        CHECK(surface_seen(scaled, far).offset == Approx(at_one * scale).epsilon(1e-6));
    }
}

TEST_CASE("leave_surface: a ray never hits the triangle that it leaves, at any scale and place",
          "[reference][surface]") {
    std::size_t left = 0;
    scotty::tests::check_property("no self-intersection", [&left](std::uint32_t seed) {
        Random random(seed);
        const float scale = std::pow(10.0f, uniform(random, -4.0f, 4.0f));
        const Vec3 centre = unit_vector(random) * (scale * std::pow(10.0f, uniform(random, -1, 2)));
        Scene scene;
        scene.materials.emplace_back();
        const auto corner = [&] { return centre + uniform3(random, -scale, scale); };
        const Vec3 a = corner();
        const Vec3 b = corner();
        add_triangle(scene, a, b, corner());
        for (int i = 0; i < 20; ++i) {
            const float u = uniform(random, 0, 1);
            const float v = uniform(random, 0, 1 - u);
            const Vec3 target =
                scene.vertices[0] * (1 - u - v) + scene.vertices[1] * u + scene.vertices[2] * v;
            const Vec3 from = target + unit_vector(random) * (scale * uniform(random, 0.1f, 10));
            const Ray ray{from, 0.0f, normalize_or(target - from, Vec3(0, 0, 1)), kInfinity};
            const std::optional<Hit> hit = hit_of(scene, ray);
            if (!hit) continue;
            const Surface surface = surface_at(view_of(scene), ray, *hit);
            const Vec3 scattered = sample_cosine_hemisphere(
                surface.geometric_normal, uniform(random, 0, 1), uniform(random, 0, 1));
            const float side = i % 2 == 0 ? 1.0f : -1.0f;  // reflected, refracted
            RC_ASSERT(!hit_of(scene, leave_surface(surface, scattered * side, kInfinity)));
            ++left;
        }
    });
    CHECK(left > 500);
}
