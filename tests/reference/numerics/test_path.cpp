/// Path vertices: what is lit, what is counted, and what a path leaves behind when it ends.
#include "tests/properties.h"

#include <cmath>
#include <vector>

#include "reference/numerics/path.h"
#include "reference/truth/tracers.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

/// A square floor of half side `half` at y = 0, front up, of albedo 0.5.
Scene floor_scene(float half) {
    Scene scene;
    scene.materials.emplace_back();
    scene.materials[0].reflectance = Vec3(0.5f);
    add_triangle(scene, Vec3(-half, 0, half), Vec3(half, 0, half), Vec3(half, 0, -half));
    add_triangle(scene, Vec3(-half, 0, half), Vec3(half, 0, -half), Vec3(-half, 0, -half));
    return scene;
}

/// A square lamp of half side `half` around `centre`, shining down, with its emissive triangles.
void add_lamp(Scene& scene, const Vec3& centre, float half, float radiance) {
    Material glow;
    glow.emission = Vec3(radiance);
    glow.emission_is_sampled = 1;
    scene.materials.push_back(glow);
    const Vec3 corner = centre + Vec3(-half, 0, -half);
    const Vec3 x(2 * half, 0, 0);
    const Vec3 z(0, 0, 2 * half);
    add_triangle(scene, corner, corner + x, corner + x + z);
    add_triangle(scene, corner, corner + x + z, corner + z);
    const auto material = static_cast<std::uint32_t>(scene.materials.size() - 1);
    scene.material_of[scene.material_of.size() - 2] = material;
    scene.material_of.back() = material;
    Light light;
    light.kind = LightKind::parallelogram;
    light.position = corner;
    light.edge_x = x;
    light.edge_y = z;
    light.normal = Vec3(0, -1, 0);
    light.area = 4 * half * half;
    light.radiance = Vec3(radiance);
    scene.lights.push_back(light);
}

Hit closest(const Scene& scene, const Ray& ray) {
    Hit hit = no_hit();
    brute_force_closest(scene, {&ray, 1}, {&hit, 1});
    return hit;
}

Ray straight_down(float x, float height, float z) {
    return {Vec3(x, height, z), 0.0f, Vec3(0, -1, 0), kInfinity};
}

PathParameters one_light_sample() {
    PathParameters parameters;
    parameters.light_samples = 1;
    return parameters;
}

Random4 random_of(std::uint32_t i) { return random4(9, i, 0, 0, 16); }

/// Share of shadow rays from the floor's middle that reach an unobstructed lamp.
double lit_share(const Scene& scene, const Ray& view) {
    const Hit hit = closest(scene, view);
    REQUIRE(is_hit(hit));
    REQUIRE(hit.primitive < 2);  // the floor
    int lit = 0;
    constexpr int kSamples = 500;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
        const DirectLight direct = sample_direct_light(view_of(scene), one_light_sample(), view,
                                                       hit, Vec3(1.0f), random_of(i));
        if (!is_dead(direct.shadow) && !is_hit(closest(scene, direct.shadow))) ++lit;
    }
    return lit / static_cast<double>(kSamples);
}

}  // namespace

TEST_CASE("direct light: a lamp never stands in its own light, however large the floor",
          "[reference][path]") {
    // The shadow ray starts off the floor by a share of the floor's size: it must not overshoot.
    for (const float half : {1.0f, 30.0f, 1000.0f}) {
        Scene scene = floor_scene(half);
        add_lamp(scene, Vec3(0, 1, 0), 0.1f, 1.0f);
        INFO("floor of " << 2 * half << " metres");
        CHECK(lit_share(scene, straight_down(0.3f, 0.5f, 0.2f)) == 1.0);
    }
}

TEST_CASE("direct light: a lamp at the world's origin is not lost in rounding",
          "[reference][path]") {
    for (const float depth : {1.0f, 10.0f, 300.0f}) {
        Scene scene = floor_scene(1.0f);
        for (Vec3& v : scene.vertices) v.y -= depth;
        add_lamp(scene, Vec3(0, 0, 0), 0.1f, 1.0f);
        INFO("floor " << depth << " metres below");
        CHECK(lit_share(scene, straight_down(0.3f, 0.5f - depth, 0.2f)) == 1.0);
    }
}

TEST_CASE("direct light: a lamp lights wherever the scene stands and however large it is",
          "[reference][path]") {
    scotty::tests::check_property("lit", [](std::uint32_t seed) {
        Random random(seed);
        Scene scene = floor_scene(1.0f);
        add_lamp(scene, Vec3(0, uniform(random, 0.2f, 3.0f), 0), uniform(random, 0.05f, 0.5f),
                 1.0f);
        const float scale = std::pow(10.0f, uniform(random, -3, 3));
        const Vec3 shift = unit_vector(random) * (scale * uniform(random, 0, 20));
        for (Vec3& v : scene.vertices) v = v * scale + shift;
        Light& light = scene.lights[0];
        light.position = light.position * scale + shift;
        light.edge_x *= scale;
        light.edge_y *= scale;
        light.area *= scale * scale;
        Ray view = straight_down(0.1f, 0.1f, -0.4f);
        view.origin = view.origin * scale + shift;
        RC_ASSERT(lit_share(scene, view) == 1.0);
    });
}

TEST_CASE("direct light: what stands between lamp and floor shadows it", "[reference][path]") {
    Scene scene = floor_scene(1.0f);
    add_lamp(scene, Vec3(0, 1, 0), 0.1f, 1.0f);
    // Just off the floor and just under the lamp: 2 permille of the distance.
    for (const float height : {0.002f, 0.5f, 0.998f}) {
        Scene blocked = scene;
        add_triangle(blocked, Vec3(-9, height, 9), Vec3(9, height, 9), Vec3(0, height, -9));
        CHECK(lit_share(blocked, straight_down(0.3f, 0.5f * height, 0.2f)) == 0.0);
    }
}

TEST_CASE("direct light: shadow rays of a point light end at the light", "[reference][path]") {
    Scene scene = floor_scene(100.0f);
    Light light;
    light.position = Vec3(0, 1, 0);
    light.radiance = Vec3(1.0f);
    scene.lights.push_back(light);
    // A lid a hair above the light: behind it, so in nobody's way.
    add_triangle(scene, Vec3(-9, 1.0001f, 9), Vec3(9, 1.0001f, 9), Vec3(0, 1.0001f, -9));
    CHECK(lit_share(scene, straight_down(0.0f, 0.5f, 0.0f)) == 1.0);
}

TEST_CASE("direct light: an open scene is lit: a shadow ray that meets nothing is light",
          "[reference][path]") {
    Scene scene = floor_scene(1.0f);
    for (const LightKind kind :
         {LightKind::directional, LightKind::environment, LightKind::point}) {
        Light light;
        light.kind = kind;
        light.position = Vec3(0, 5, 0);
        light.normal = Vec3(0, -1, 0);
        light.radiance = Vec3(1.0f);
        scene.lights = {light};
        CHECK(lit_share(scene, straight_down(0.3f, 0.5f, 0.2f)) == 1.0);
    }
}

TEST_CASE("direct light: potential is albedo / pi x irradiance x cosine, shared among samples",
          "[reference][path]") {
    Scene scene = floor_scene(1.0f);
    Light sun;
    sun.kind = LightKind::directional;
    sun.normal = normalize_or(Vec3(1, -1, 0), Vec3(0.0f));
    sun.radiance = Vec3(3.0f, 2.0f, 1.0f);
    scene.lights = {sun, sun};
    const Ray view = straight_down(0.3f, 0.5f, 0.2f);
    PathParameters parameters;
    parameters.light_samples = 4;
    const DirectLight direct =
        sample_direct_light(view_of(scene), parameters, view, closest(scene, view),
                            Vec3(1.0f, 0.5f, 0.25f), random_of(0));
    // Two lights, picked with probability 1/2; four samples share the mean.
    const float expected = 0.5f / kPi * std::sqrt(0.5f) * 2.0f / 4.0f;
    CHECK(direct.potential.x == Approx(3.0f * expected).epsilon(1e-6));
    CHECK(direct.potential.y == Approx(1.0f * expected).epsilon(1e-6));
    CHECK(direct.potential.z == Approx(0.25f * expected).epsilon(1e-6));
}

TEST_CASE("direct light: every light is picked with equal probability", "[reference][path]") {
    Scene scene = floor_scene(1.0f);
    for (int i = 0; i < 5; ++i) {
        Light light;
        light.position = Vec3(static_cast<float>(i), 1, 0);
        light.radiance = Vec3(1.0f);
        scene.lights.push_back(light);
    }
    const Ray view = straight_down(0.3f, 0.5f, 0.2f);
    const Hit hit = closest(scene, view);
    std::vector<int> picked(5);
    constexpr std::uint32_t kSamples = 10000;
    for (std::uint32_t i = 0; i < kSamples; ++i) {
        const DirectLight direct = sample_direct_light(view_of(scene), one_light_sample(), view,
                                                       hit, Vec3(1.0f), random_of(i));
        const Vec3 end = direct.shadow.origin + direct.shadow.direction * direct.shadow.t_max;
        ++picked.at(static_cast<std::size_t>(std::lround(end.x)));
    }
    for (const int n : picked) CHECK(std::abs(n - 2000) < 200);  // five standard deviations
}

TEST_CASE("direct light: nothing is asked where nothing can be lit", "[reference][path]") {
    Scene scene = floor_scene(1.0f);
    const Ray view = straight_down(0.3f, 0.5f, 0.2f);
    const Hit hit = closest(scene, view);
    const auto ask = [&](const Hit& at) {
        return sample_direct_light(view_of(scene), one_light_sample(), view, at, Vec3(1.0f),
                                   random_of(1));
    };
    CHECK(is_dead(ask(hit).shadow));  // no lights
    add_lamp(scene, Vec3(0, 1, 0), 0.1f, 1.0f);
    CHECK_FALSE(is_dead(ask(hit).shadow));
    CHECK(is_dead(ask(no_hit()).shadow));
    scene.materials[0].kind = MaterialKind::mirror;
    CHECK(is_dead(ask(hit).shadow));
    scene.materials[0].kind = MaterialKind::diffuse;
    scene.materials[0].reflectance = Vec3(0.0f);
    CHECK(is_dead(ask(hit).shadow));
    scene.materials[0].reflectance = Vec3(0.5f);
    scene.lights[0].normal = Vec3(0, 1, 0);  // shines away
    CHECK(is_dead(ask(hit).shadow));
    CHECK(ask(hit).potential == Vec3(0.0f));
}

TEST_CASE("scatter: a miss ends the path and takes nothing away", "[reference][path]") {
    const Scene scene = floor_scene(1.0f);
    const Scattered end = scatter(view_of(scene), {}, 1, straight_down(5, 1, 0), no_hit(),
                                  Vec3(0.5f), kPathAlive, random_of(0));
    CHECK(end.flags == 0);
    CHECK(end.emitted == Vec3(0.0f));  // what is added to the radiance: nothing, and no less
    CHECK(is_dead(end.ray));
}

TEST_CASE("scatter: emission counts where it is seen, and not again where lights stand for it",
          "[reference][path]") {
    Scene scene = floor_scene(1.0f);
    scene.materials[0].emission = Vec3(7.0f);
    scene.materials[0].emission_is_sampled = 1;
    const Ray view = straight_down(0.3f, 0.5f, 0.2f);
    const Hit hit = closest(scene, view);
    const auto seen = [&](std::uint32_t bounce, std::uint32_t flags, std::uint32_t light_samples) {
        PathParameters parameters;
        parameters.light_samples = light_samples;
        return scatter(view_of(scene), parameters, bounce, view, hit, Vec3(0.5f), flags,
                       random_of(0))
            .emitted.x;
    };
    CHECK(seen(0, kPathAlive, 2) == 3.5f);                  // the lamp's own pixel
    CHECK(seen(1, kPathAlive, 2) == 0.0f);                  // light sampling has counted it
    CHECK(seen(1, kPathAlive | kPathSpecular, 2) == 3.5f);  // in a mirror it has not
    CHECK(seen(1, kPathAlive, 0) == 3.5f);                  // nor without light samples
    CHECK(seen(0, 0, 2) == 0.0f);                           // a dead path sees nothing
    scene.materials[0].emission_is_sampled = 0;
    CHECK(seen(1, kPathAlive, 2) == 3.5f);  // no light stands for it
    // From behind a lamp is black.
    const Ray below{Vec3(0.3f, -1, 0.2f), 0.0f, Vec3(0, 1, 0), kInfinity};
    CHECK(scatter(view_of(scene), {}, 0, below, closest(scene, below), Vec3(1.0f), kPathAlive,
                  random_of(0))
              .emitted.x == 0.0f);
}

TEST_CASE("scatter: the environment is seen directly and in mirrors, not after diffuse bounces",
          "[reference][path]") {
    Scene scene = floor_scene(1.0f);
    Light sky;
    sky.kind = LightKind::environment;
    sky.radiance = Vec3(2.0f);
    scene.lights = {sky};
    const auto seen = [&](std::uint32_t bounce, std::uint32_t flags) {
        return scatter(view_of(scene), one_light_sample(), bounce, straight_down(5, 1, 0), no_hit(),
                       Vec3(1.0f), flags, random_of(0))
            .emitted.x;
    };
    CHECK(seen(0, kPathAlive) == 2.0f);
    CHECK(seen(1, kPathAlive) == 0.0f);
    CHECK(seen(1, kPathAlive | kPathSpecular) == 2.0f);
}

TEST_CASE("scatter: the last vertex adds emission and sends nothing on", "[reference][path]") {
    Scene scene = floor_scene(1.0f);
    scene.materials[0].emission = Vec3(1.0f);
    const Ray view = straight_down(0.3f, 0.5f, 0.2f);
    PathParameters parameters;
    parameters.bounces = 3;
    const auto at = [&](std::uint32_t bounce) {
        return scatter(view_of(scene), parameters, bounce, view, closest(scene, view), Vec3(1.0f),
                       kPathAlive, random_of(0));
    };
    CHECK((at(2).flags & kPathAlive) != 0);
    CHECK(at(3).flags == 0);
    CHECK(is_dead(at(3).ray));
    CHECK(at(3).emitted.x == 1.0f);
}

TEST_CASE("scatter: throughput is multiplied by the material, and black ends the path",
          "[reference][path]") {
    Scene scene = floor_scene(1.0f);
    const Ray view = straight_down(0.3f, 0.5f, 0.2f);
    const auto next = [&] {
        return scatter(view_of(scene), {}, 0, view, closest(scene, view), Vec3(0.5f), kPathAlive,
                       random_of(0));
    };
    CHECK(next().throughput == Vec3(0.25f));
    CHECK(next().flags == kPathAlive);
    scene.materials[0].kind = MaterialKind::mirror;
    CHECK(next().flags == (kPathAlive | kPathSpecular));
    CHECK(next().ray.direction == Vec3(0, 1, 0));
    scene.materials[0].reflectance = Vec3(0.0f);
    CHECK(next().flags == 0);
}

TEST_CASE("roulette: a path goes on with its throughput's probability, and carries the more",
          "[reference][path]") {
    PathParameters parameters;
    const Vec3 carried(0.125f, 0.25f, 0.0f);
    CHECK(survival(parameters, 64, carried) == 1.0f);  // off
    parameters.roulette = 2;
    CHECK(survival(parameters, 1, carried) == 1.0f);
    CHECK(survival(parameters, 2, carried) == 0.25f);
    CHECK(survival(parameters, 3, Vec3(1.5f)) == 1.0f);

    const Scene scene = floor_scene(1.0f);  // of albedo 0.5
    const Ray view = straight_down(0.3f, 0.5f, 0.2f);
    const Hit hit = closest(scene, view);
    parameters.bounces = 8;
    Vec3 sum(0.0f);
    int alive = 0;
    constexpr int kRounds = 1024;
    for (int i = 0; i < kRounds; ++i) {
        Random4 random = random_of(3);
        random.d = static_cast<float>(i) / kRounds;
        const Scattered next =
            scatter(view_of(scene), parameters, 2, view, hit, carried, kPathAlive, random);
        sum += next.throughput;
        alive += (next.flags & kPathAlive) != 0;
        CHECK(is_dead(next.ray) == ((next.flags & kPathAlive) == 0));
    }
    CHECK(alive == kRounds / 8);  // 0.5 times 0.25
    CHECK(sum * (1.0f / kRounds) == carried * 0.5f);
    // Before its time it changes nothing, and what a path has met is kept where it ends.
    Random4 last = random_of(3);
    last.d = 0.999f;
    CHECK(scatter(view_of(scene), parameters, 0, view, hit, carried, kPathAlive, last).throughput ==
          carried * 0.5f);
    Scene glowing = scene;
    glowing.materials[0].emission = Vec3(3.0f);
    const Scattered end = scatter(view_of(glowing), parameters, 2, view, hit, carried,
                                  kPathAlive | kPathSpecular, last);
    CHECK((end.flags & kPathAlive) == 0);
    CHECK(end.emitted == carried * 3.0f);
}

TEST_CASE("rough metal: each light is counted once, by light samples or by scattering",
          "[reference][path][metal]") {
    Scene scene = floor_scene(1.0f);
    add_lamp(scene, Vec3(0, 1, 0), 0.25f, 2.0f);
    Light point;
    point.position = Vec3(0.1f, 1.0f, 0.2f);
    point.radiance = Vec3(1.0f);
    scene.materials[0].kind = MaterialKind::conductor;
    PathParameters parameters;
    const Ray view = straight_down(0.1f, 0.5f, 0.1f);
    const Hit hit = closest(scene, view);
    const auto lit = [&] {
        return max_component(sample_direct_light(view_of(scene), parameters, view, hit, Vec3(1.0f),
                                                 random_of(0))
                                 .potential) > 0.0f;
    };
    const auto flags = [&] {
        return scatter(view_of(scene), parameters, 0, view, hit, Vec3(1.0f), kPathAlive,
                       random_of(0))
            .flags;
    };
    scene.materials[0].ior = 0.29f;
    CHECK_FALSE(lit());  // the lamp is found by scattering,
    CHECK(flags() == (kPathAlive | kPathSpecular));
    scene.lights[0] = point;
    CHECK(lit());  // a point never is
    scene.lights[0].kind = LightKind::environment;
    CHECK_FALSE(lit());

    scene.materials[0].ior = 0.3f;
    CHECK(lit());
    CHECK(flags() == kPathAlive);
}

TEST_CASE("scatter: a smooth normal never sends a path to the wrong side", "[reference][path]") {
    scotty::tests::check_property("sides", [](std::uint32_t seed) {
        Random random(seed);
        Scene scene = floor_scene(1.0f);
        scene.materials[0].reflectance = scene.materials[0].transmittance = Vec3(1.0f);
        scene.materials[0].ior = 1.5f;
        scene.normals.clear();
        for (std::size_t i = 0; i < scene.vertices.size(); ++i) {
            scene.normals.push_back(
                normalize_or(unit_vector(random) + Vec3(0, 0.8f, 0), Vec3(0, 1, 0)));
        }
        const float side = random() % 2 == 0 ? 1.0f : -1.0f;
        Vec3 direction = unit_vector(random);
        direction.y = -side * std::abs(direction.y);
        const Ray view{Vec3(0.2f, 0, 0.1f) - direction, 0.0f, direction, kInfinity};
        const Hit hit = closest(scene, view);
        if (!is_hit(hit)) return;
        for (const MaterialKind kind : {MaterialKind::diffuse, MaterialKind::mirror,
                                        MaterialKind::glass, MaterialKind::conductor}) {
            scene.materials[0].kind = kind;
            scene.materials[0].ior = kind == MaterialKind::conductor ? 0.5f : 1.5f;
            const Random4 r{uniform(random, 0, 1), uniform(random, 0, 1), uniform(random, 0, 1), 0};
            const Scattered next =
                scatter(view_of(scene), {}, 0, view, hit, Vec3(1.0f), kPathAlive, r);
            if ((next.flags & kPathAlive) == 0) {
                RC_ASSERT(!is_smooth(scene.materials[0]));  // only the others absorb
                continue;
            }
            // The ray starts on the side to which it goes, and weighs what that side is worth.
            RC_ASSERT(next.ray.origin.y * next.ray.direction.y >= 0.0f);
            const bool crossed = next.ray.direction.y * side < 0.0f;
            if (kind != MaterialKind::glass) RC_ASSERT(!crossed);
            if (kind != MaterialKind::conductor) {
                RC_ASSERT((next.throughput.x == 1.0f) == !crossed);
            }
        }
    });
}
