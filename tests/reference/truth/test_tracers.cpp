
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include <tbb/parallel_for.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "reference/numerics/intersect_triangle.h"
#include "reference/truth/tracers.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

/// The definition of brute force, as plainly as possible.
Hit scan(const Scene& scene, const Ray& ray) {
    Hit best = no_hit();
    const Vec3 inverse = safe_inverse(ray.direction);
    const RayShear shear = ray_shear(ray.direction);
    for (std::uint32_t id = 0; id < scene.triangles.size(); ++id) {
        const auto& index = scene.triangles[id];
        Hit hit = no_hit();
        if (intersect_triangle(ray, inverse, shear, scene.vertices[index[0]],
                               scene.vertices[index[1]], scene.vertices[index[2]], hit) &&
            closer(hit.t, id, best.t, best.primitive)) {
            best = {hit.t, id, hit.u, hit.v};
        }
    }
    return best;
}

std::vector<Hit> brute_force(const Scene& scene, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    brute_force_closest(scene, rays, hits);
    return hits;
}

bool same_bits(const Hit& a, const Hit& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// Rays that are hard in one way or another, beside plain random ones.
std::vector<Ray> mixed_rays(const Scene& scene, std::size_t count, std::uint32_t seed) {
    std::vector<Ray> rays = random_rays(count, 1.5f, seed);
    Random random(seed + 1);
    for (std::size_t i = 0; i < count; ++i) {
        Ray& ray = rays[i];
        const Vec3& target = scene.vertices[random() % scene.vertices.size()];
        const Vec3& other = scene.vertices[random() % scene.vertices.size()];
        switch (i % 6) {
            case 0:
                ray.direction = target - ray.origin;
                break;  // at a vertex
            case 1:
                ray.direction = 0.5f * (target + other) - ray.origin;
                break;
            case 2:
                ray.direction[static_cast<int>(i / 6 % 3)] = 0.0f;
                break;  // in a plane
            case 3:
                ray.origin = target;
                break;  // from a vertex
            case 4:
                ray.t_max = uniform(random, -0.1f, 2.0f);
                break;
            default:
                break;
        }
        if (is_zero(ray.direction)) ray.direction = Vec3(0, 0, 1);
    }
    return rays;
}

/// Verdicts, counted.
std::array<int, 5> check_against_embree(const Scene& scene, const std::vector<Ray>& rays) {
    const std::vector<Hit> ours = brute_force(scene, rays);
    const EmbreeTracer embree(scene);
    std::vector<Hit> theirs(rays.size());
    embree.closest(rays, theirs);
    std::vector<std::uint8_t> occluded(rays.size());
    embree.occluded(rays, occluded);
    std::array<int, 5> verdicts{};
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Adjudication closest = adjudicate_closest(scene, rays[i], ours[i], theirs[i]);
        const Adjudication any =
            adjudicate_occluded(scene, rays[i], is_hit(ours[i]), occluded[i] != 0, theirs[i]);
        ++verdicts[static_cast<std::size_t>(closest.verdict)];
        if (closest.verdict == Disagreement::ours_wrong ||
            any.verdict == Disagreement::ours_wrong) {
            FAIL_CHECK(scene.name << ", ray " << i << ": " << closest.explanation << " "
                                  << any.explanation);
        }
    }
    return verdicts;
}

/// Where triangles are well shaped, disagreements are rare and Embree is not wrong either.
void check_agreement(const Scene& scene, const std::vector<Ray>& rays) {
    const std::array<int, 5> verdicts = check_against_embree(scene, rays);
    INFO("ties " << verdicts[1] << ", grazing " << verdicts[2] << ", Embree wrong " << verdicts[4]);
    CHECK(verdicts[0] > static_cast<int>(rays.size() * 8 / 10));
}

}  // namespace

TEST_CASE("brute force: gives the bits of the plain double loop", "[reference][brute_force]") {
    const Scene degenerate = [] {
        Scene scene = soup(203, 0.5f, 11);
        for (std::size_t i = 0; i < 60; i += 3) scene.vertices[i] = scene.vertices[i + 1];
        for (std::size_t i = 90; i < 150; ++i) scene.vertices[i].z = 0.25f;  // coplanar
        scene.triangles.push_back(scene.triangles[3]);                       // twice the same
        return scene;
    }();
    for (const Scene& scene : {degenerate, icosphere(2), soup(1, 1.0f, 2), soup(8, 1.0f, 2)}) {
        const std::vector<Ray> rays = mixed_rays(scene, 3000, 12);
        const std::vector<Hit> hits = brute_force(scene, rays);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            if (!same_bits(hits[i], scan(scene, rays[i]))) FAIL_CHECK(scene.name << ", ray " << i);
        }
    }
}

TEST_CASE("brute force: equal distances go to the lower primitive", "[reference][brute_force]") {
    Scene scene = triangle_scene({-1, -1, 2}, {1, -1, 2}, {0, 1, 2});
    for (int i = 0; i < 20; ++i) scene.triangles.push_back(scene.triangles.front());
    CHECK(brute_force(scene, {{Vec3(0.0f), 0.0f, Vec3(0, 0, 1), kInfinity}})[0].primitive == 0);
}

TEST_CASE("brute force: rays that are dead or not numbers hit nothing",
          "[reference][brute_force]") {
    const Scene scene = icosphere(1);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Ray inside{Vec3(0.0f), 0.0f, Vec3(0, 0, 1), kInfinity};
    std::vector<Ray> rays(6, inside);
    rays[0] = dead_ray();
    rays[1].origin.x = nan;
    rays[2].direction = Vec3(nan);
    rays[3].t_max = nan;
    rays[4].direction = Vec3(0.0f);
    const std::vector<Hit> hits = brute_force(scene, rays);
    std::vector<Hit> embree(rays.size());
    const EmbreeTracer tracer(scene);
    tracer.closest(rays, embree);
    for (std::size_t i = 0; i < 5; ++i) {
        INFO("ray " << i);
        CHECK(same_bits(hits[i], no_hit()));
        CHECK(same_bits(embree[i], no_hit()));
        CHECK_FALSE(tracer.occluded(rays[i]));
    }
    CHECK(is_hit(hits[5]));
    CHECK(is_hit(embree[5]));
}

TEST_CASE("tracers: spans of different lengths are a broken contract", "[reference][tracers]") {
    const Scene scene = icosphere(0);
    const std::vector<Ray> rays = random_rays(2, 1.0f, 1);
    std::vector<Hit> hits(3);
    std::vector<std::uint8_t> occluded(1);
    CHECK_THROWS_AS(brute_force_closest(scene, rays, hits), Error);
    const EmbreeTracer tracer(scene);
    CHECK_THROWS_AS(tracer.closest(rays, hits), Error);
    CHECK_THROWS_AS(tracer.occluded(rays, occluded), Error);
}

TEST_CASE("embree: gives distance, primitive and barycentrics", "[reference][embree]") {
    const Scene scene = triangle_scene({0, 0, 3}, {4, 0, 3}, {0, 4, 3});
    const EmbreeTracer tracer(scene);
    const Hit hit = tracer.closest({Vec3(1, 2, 0), 0.0f, Vec3(0, 0, 1), kInfinity});
    CHECK(hit.primitive == 0);
    CHECK(hit.t == Approx(3));
    CHECK(hit.u == Approx(0.25));
    CHECK(hit.v == Approx(0.5));
    CHECK_FALSE(is_hit(tracer.closest({Vec3(3, 3, 0), 0.0f, Vec3(0, 0, 1), kInfinity})));
}

TEST_CASE("embree: the interval holds t_min and does not hold t_max", "[reference][embree]") {
    const Scene scene = soup(1, 1.0f, 20);
    const EmbreeTracer tracer(scene);
    const Vec3 centre = (scene.vertices[0] + scene.vertices[1] + scene.vertices[2]) / 3.0f;
    for (Ray ray : random_rays(200, 2.0f, 20)) {
        ray.direction = normalize_or(centre - ray.origin, Vec3(0, 0, 1));
        const float t = tracer.closest(ray).t;  // as Embree rounds it
        REQUIRE(t < kInfinity);
        const float before = std::nextafter(t, 0.0f);
        const float after = std::nextafter(t, kInfinity);
        const auto hits = [&](float t_min, float t_max) {
            ray.t_min = t_min;
            ray.t_max = t_max;
            const Hit hit = tracer.closest(ray);
            return is_hit(hit) && hit.t == t;
        };
        CHECK(hits(0.0f, after));
        CHECK(hits(t, kInfinity));
        CHECK(hits(t, after));
        CHECK_FALSE(hits(0.0f, t));
        CHECK_FALSE(hits(after, kInfinity));
        CHECK_FALSE(hits(before, t));
        CHECK_FALSE(hits(t, t));
        // Occlusion returns no t: to within Embree's own rounding.
        CHECK(tracer.occluded({ray.origin, 0.99999f * t, ray.direction, 1.00001f * t}));
        CHECK_FALSE(tracer.occluded({ray.origin, 0.0f, ray.direction, 0.99999f * t}));
        CHECK_FALSE(tracer.occluded({ray.origin, 1.00001f * t, ray.direction, kInfinity}));
    }
}

TEST_CASE("embree: agrees with brute force, and we are never wrong", "[reference][embree]") {
    for (const Scene& scene : {soup(500, 0.3f, 21), soup(2000, 0.05f, 22), icosphere(3)}) {
        check_agreement(scene, mixed_rays(scene, 20000, 23));
    }
}

TEST_CASE("embree: agrees where scenes are large, small or far away", "[reference][embree]") {
    for (const float scale : {0.01f, 100.0f, 1.0e6f}) {
        Scene scene = icosphere(3);
        for (Vec3& vertex : scene.vertices) vertex *= scale;
        std::vector<Ray> rays = mixed_rays(scene, 5000, 24);
        for (Ray& ray : rays) ray.origin *= scale;
        check_agreement(scene, rays);
    }
    Scene scene = icosphere(3, 1.0f, Vec3(1000, -2000, 3000));
    scene.name = "far icosphere";
    std::vector<Ray> rays = random_rays(5000, 3.0f, 25);
    for (Ray& ray : rays) ray.origin += Vec3(1000, -2000, 3000);
    check_agreement(scene, rays);
}

TEST_CASE("embree: slivers, duplicates and zero areas are ties or grazing, never our fault",
          "[reference][embree]") {
    Random random(31);
    Scene scene;
    scene.name = "slivers";
    for (int i = 0; i < 300; ++i) {
        const Vec3 a = uniform3(random, -1.0f, 1.0f);
        const Vec3 b = uniform3(random, -1.0f, 1.0f);
        add_triangle(scene, a, b, 0.5f * (a + b) + uniform3(random, -1.0e-5f, 1.0e-5f));
        if (i % 3 == 0) scene.triangles.push_back(scene.triangles.back());
        if (i % 5 == 0) add_triangle(scene, a, b, b);
    }
    // Seen edge-on, Embree's t can lie outside the sliver; ours is kept in its box.
    CHECK(check_against_embree(scene, mixed_rays(scene, 20000, 32))[0] > 10000);
}

TEST_CASE("embree: a scene without triangles hits nothing", "[reference][embree]") {
    const EmbreeTracer tracer{Scene{}};
    CHECK_FALSE(is_hit(tracer.closest({Vec3(0.0f), 0.0f, Vec3(0, 0, 1), kInfinity})));
}

TEST_CASE("embree: can be moved", "[reference][embree]") {
    EmbreeTracer tracer(icosphere(0));
    EmbreeTracer other(std::move(tracer));
    tracer = std::move(other);
    CHECK(is_hit(tracer.closest({Vec3(0.0f), 0.0f, Vec3(0, 0, 1), kInfinity})));
    CHECK_FALSE(EmbreeTracer::version().empty());
}

#if defined(__x86_64__)
TEST_CASE("embree: leaves denormal arithmetic on in our threads", "[reference][embree]") {
    constexpr unsigned kFlushToZeroAndDenormalsAreZero = 0x8040;
    const EmbreeTracer tracer(icosphere(4));
    std::atomic<int> flushing{0};
    tbb::parallel_for(0, 10000, [&](int) {
        if ((_mm_getcsr() & kFlushToZeroAndDenormalsAreZero) != 0) ++flushing;
    });
    CHECK(flushing == 0);
}
#endif
