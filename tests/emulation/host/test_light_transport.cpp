/// Compares renders with closed forms: these cases have lost light or counted it twice before.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "scenes/mesh.h"
#include "tests/catch.h"
#include "tests/emulation/renders.h"

using namespace scotty::emulation;
using namespace scotty::emulation::test;
using namespace scotty::reference;
using namespace scotty::scenes;

namespace {

/// Looks at `target` through a field of view of a thousandth: every ray is nearly the same.
Camera narrow(const Vec3& from, const Vec3& target) {
    const Vec3 up =
        std::abs(target.y - from.y) > 0.9f * length(target - from) ? Vec3(0, 0, -1) : Vec3(0, 1, 0);
    return look_at(from, target, up, 0.0005f);
}

/// A floor of 20 x 20 metres in y = 0, front up; a camera looks at its middle from the side.
Scene floor_of(const Material& material) {
    Scene scene;
    add_quad(scene, Vec3(-10, 0, 10), Vec3(20, 0, 0), Vec3(0, 0, -20),
             add_material(scene, material));
    scene.camera = narrow(Vec3(3, 2, 0), Vec3(0, 0, 0));
    return scene;
}

Material diffuse(float albedo) {
    Material material;
    material.reflectance = Vec3(albedo);
    return material;
}

Scene finished(Scene scene) {
    finish_normals(scene);
    validate_and_repair(scene);
    return scene;
}

PipelineParameters one_pixel(std::uint32_t spp, std::uint32_t bounces, std::uint32_t lights) {
    PipelineParameters p = tiny(1, 1);
    p.spp = spp;
    p.bounces = bounces;
    p.light_samples = lights;
    return p;
}

float pixel_of(const Scene& scene, const PipelineParameters& p) {
    return render(scene, p).pixels[0].x;
}

/// Scales the room as a whole, light and camera included: the picture must stay the same.
Scene scaled(Scene scene, float scale) {
    for (Vec3& v : scene.vertices) v *= scale;
    for (Light& light : scene.lights) {
        light.position *= scale;
        light.edge_x *= scale;
        light.edge_y *= scale;
        light.area *= scale * scale;
    }
    scene.camera.position *= scale;
    return scene;
}

}  // namespace

TEST_CASE("radiance: an open scene is lit, to albedo / pi times the sun's irradiance",
          "[emulation][light]") {
    Scene scene = floor_of(diffuse(0.5f));
    scene.lights.push_back(directional_light(Vec3(1, -1, 0), Vec3(2, 2, 2)));
    scene = finished(scene);
    const double expected = 0.5 / M_PI * 2.0 * std::sqrt(0.5);
    CHECK(pixel_of(scene, one_pixel(4, 0, 2)) == Approx(expected).epsilon(1e-5));
}

TEST_CASE("radiance: a path that misses keeps the light that it has gathered",
          "[emulation][light]") {
    Scene scene = floor_of(diffuse(0.5f));
    scene.lights.push_back(directional_light(Vec3(1, -1, 0), Vec3(2, 2, 2)));
    scene = finished(scene);
    // All light that leaves a flat floor misses: more bounces add nothing and take nothing.
    const float expected = pixel_of(scene, one_pixel(16, 0, 2));
    REQUIRE(expected > 0.0f);
    for (const std::uint32_t bounces : {1u, 3u, 8u}) {
        CHECK(pixel_of(scene, one_pixel(16, bounces, 2)) == expected);
    }
}

TEST_CASE("radiance: a lamp's pixel is its radiance, and black from behind", "[emulation][light]") {
    Scene scene;
    add_lamp(scene, Vec3(-1, 2, -1), Vec3(2, 0, 0), Vec3(0, 0, 2), Vec3(12, 11, 9));
    scene.camera = narrow(Vec3(0.1f, 0, 0), Vec3(0.1f, 2, 0.1f));
    for (const std::uint32_t light_samples : {0u, 2u}) {
        const Image front = render(finished(scene), one_pixel(4, 2, light_samples));
        CHECK(front.pixels[0] == Vec3(12, 11, 9));
    }
    scene.camera = narrow(Vec3(0.1f, 4, 0), Vec3(0.1f, 2, 0.1f));
    CHECK(render(finished(scene), one_pixel(4, 2, 2)).pixels[0] == Vec3(0, 0, 0));
}

TEST_CASE("radiance: emission is counted once: one bounce of a square lamp in closed form",
          "[emulation][light]") {
    // Half side 1 at height 1, right above: form factor 4/pi * atan(1/sqrt(2)) / sqrt(2).
    Scene scene = floor_of(diffuse(0.8f));
    add_lamp(scene, Vec3(-1, 1, -1), Vec3(2, 0, 0), Vec3(0, 0, 2), Vec3(3, 3, 3));
    scene.camera = narrow(Vec3(4, 0.9f, 0), Vec3(0, 0, 0));
    scene = finished(scene);
    const double expected = 0.8 * 3.0 * 4.0 / M_PI * std::atan(std::sqrt(0.5)) / std::sqrt(2.0);
    // The lamp reflects nothing, so bounces beyond the first add nothing. Standard deviation of
    // one light sample: measured 45 % of the mean; four of them are within 5 / sqrt(samples).
    const auto near = [&](double relative) { return Approx(expected).epsilon(relative); };
    CHECK(pixel_of(scene, one_pixel(8192, 0, 2)) == near(0.016));
    CHECK(pixel_of(scene, one_pixel(8192, 2, 2)) == near(0.016));
    // Without light samples, paths find the lamp themselves, one bounce later: hit or miss, with
    // the form factor (0.554) as probability, hence 0.9 / sqrt(samples) of relative deviation.
    CHECK(pixel_of(scene, one_pixel(16384, 1, 0)) == near(0.03));
    CHECK(pixel_of(scene, one_pixel(16384, 2, 0)) == near(0.03));
}

TEST_CASE("radiance: with and without light samples a room has the same mean",
          "[emulation][light]") {
    // Light samples at the last vertex see one scattering more than emission on a path does.
    PipelineParameters sampled = tiny(8, 8);
    sampled.spp = 256;
    sampled.bounces = 1;
    PipelineParameters found = sampled;
    found.spp = 1024;
    found.bounces = 2;
    found.light_samples = 0;
    const Vec3 a = mean_of(render("cornell", sampled, {2}));
    const Vec3 b = mean_of(render("cornell", found, {2}));
    INFO("sampled " << a.x << ' ' << a.y << ' ' << a.z << ", found " << b.x << ' ' << b.y << ' '
                    << b.z);
    // 65,536 paths of which a twentieth meets the lamp: 2 % of standard deviation at most.
    for (int c = 0; c < 3; ++c) CHECK(a[c] == Approx(b[c]).epsilon(0.06));
    CHECK(a.x > 0.05f);
}

TEST_CASE("radiance: in a furnace every pixel is emission (1 - albedo^(n+1)) / (1 - albedo)",
          "[emulation][light]") {
    for (const std::uint32_t bounces : {0u, 1u, 5u, 20u}) {
        PipelineParameters p = tiny(8, 6);
        p.bounces = bounces;
        const double expected = 0.5 * (1.0 - std::pow(0.5, bounces + 1.0)) / 0.5;
        for (const Vec3& pixel : render("furnace", p).pixels) {
            for (int c = 0; c < 3; ++c) CHECK(pixel[c] == Approx(expected).epsilon(1e-5));
        }
    }
}

TEST_CASE("radiance: an even environment around a white floor is invisible on it",
          "[emulation][light]") {
    Scene scene = floor_of(diffuse(1.0f));
    scene.lights.push_back(environment_light(Vec3(0.75f, 0.75f, 0.75f)));
    scene = finished(scene);
    for (const std::uint32_t light_samples : {0u, 1u, 3u}) {
        CHECK(pixel_of(scene, one_pixel(16, 1, light_samples)) == Approx(0.75).epsilon(1e-5));
    }
    scene.camera = narrow(Vec3(0, 1, 0), Vec3(0, 5, 1));
    CHECK(pixel_of(scene, one_pixel(4, 2, 2)) == 0.75f);  // and is seen directly
}

TEST_CASE("materials: a mirror shows the lamp in its own tint", "[emulation][light]") {
    Material mirror;
    mirror.kind = MaterialKind::mirror;
    mirror.reflectance = Vec3(0.5f, 0.25f, 0.125f);
    Scene scene = floor_of(mirror);
    // By the angle of incidence the lamp is exactly opposite the camera.
    add_lamp(scene, Vec3(-4, 2, -1), Vec3(2, 0, 0), Vec3(0, 0, 2), Vec3(8, 8, 8));
    const Image image = render(finished(scene), one_pixel(8, 1, 2));
    CHECK(image.pixels[0] == Vec3(4, 2, 1));
    // Without a scattering to spend, the mirror is black.
    CHECK(render(finished(scene), one_pixel(8, 0, 2)).pixels[0] == Vec3(0, 0, 0));
}

TEST_CASE("materials: a glass pane passes (1 - R) / (1 + R) of a lamp behind it",
          "[emulation][light]") {
    Scene scene;
    add_lamp(scene, Vec3(-5, 4, -5), Vec3(10, 0, 0), Vec3(0, 0, 10), Vec3(1, 1, 1));
    const std::uint32_t glass = add_glass(scene, Vec3(1, 1, 1), 1.5f);
    add_quad(scene, Vec3(-5, 1, -5), Vec3(10, 0, 0), Vec3(0, 0, 10), glass);  // front down
    add_quad(scene, Vec3(-5, 2, 5), Vec3(10, 0, 0), Vec3(0, 0, -10), glass);  // front up
    scene.camera = narrow(Vec3(0.3f, 0, 0.2f), Vec3(0.3f, 4, 0.2f));
    // R = 0.04; the beams inside reach the lamp or the dark after any number of reflections.
    const double expected = 0.96 / 1.04;
    CHECK(pixel_of(finished(scene), one_pixel(8192, 8, 2)) ==
          Approx(expected).margin(5.0 * std::sqrt(expected * (1 - expected) / 8192)));
}

TEST_CASE("scale: a scene scaled by a power of two gives the same image bit for bit",
          "[emulation][light]") {
    // Every operation is homogeneous in metres: one absolute epsilon would show.
    PipelineParameters p = tiny(24, 18);
    for (const char* name : {"cornell", "spheres", "coil"}) {
        const Scene& scene = scene_named(name);
        const Image expected = render(scene, p);
        for (const float scale : {128.0f, 1.0f / 64.0f, 1048576.0f}) {
            INFO(name << " x " << scale);
            CHECK(differing_pixels(render(scaled(scene, scale), p), expected) == 0);
        }
    }
}

TEST_CASE("scale: a scene scaled by 100 and by 0.01 gives the same image up to rounding",
          "[emulation][light]") {
    PipelineParameters p = tiny(24, 18);
    const Scene& scene = scene_named("cornell");
    const Image expected = render(scene, p);
    for (const float scale : {100.0f, 0.01f}) {
        const Image image = render(scaled(scene, scale), p);
        std::size_t far_off = 0;
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            const float difference = max_abs(image.pixels[i] - expected.pixels[i]);
            far_off += difference > 1e-3f * (1e-2f + max_abs(expected.pixels[i])) ? 1 : 0;
        }
        INFO("scale " << scale);
        CHECK(far_off <= 2);  // of 432: rounding sends these past an edge
    }
}

TEST_CASE("position: a room far from the origin gives nearly the same image",
          "[emulation][light]") {
    PipelineParameters p = tiny(24, 18);
    Scene scene = scene_named("cornell");
    const Vec3 expected = mean_of(render(scene, p));
    const Vec3 shift(300, -200, 500);
    for (Vec3& v : scene.vertices) v += shift;
    for (Light& light : scene.lights) light.position += shift;
    scene.camera.position += shift;
    const Vec3 got = mean_of(render(scene, p));
    for (int c = 0; c < 3; ++c) CHECK(got[c] == Approx(expected[c]).epsilon(0.02));
}
