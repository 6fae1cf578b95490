#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "reference/numerics/intersect_triangle.h"
#include "reference/truth/ray_triangle_double.h"
#include "reference/truth/tracers.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;
using Catch::Matchers::ContainsSubstring;

namespace {

constexpr auto kNoDisagreement = Disagreement::none;
constexpr auto kTie = Disagreement::tie;
constexpr auto kGrazing = Disagreement::grazing;
constexpr auto kOursWrong = Disagreement::ours_wrong;
constexpr auto kEmbreeWrong = Disagreement::embree_wrong;

const Ray kRay{Vec3(0.25f, 0.25f, 0), 0.0f, Vec3(0, 0, 1), kInfinity};

/// Right triangles with legs of 1 in the planes z = 1, 2, 3: primitives 0, 1, 2.
Scene stack_of_three() {
    Scene scene;
    for (const float z : {1.0f, 2.0f, 3.0f}) add_triangle(scene, {0, 0, z}, {1, 0, z}, {0, 1, z});
    return scene;
}

/// As if `wrong` had been found by one side and `right` by the other, both ways round.
void check_wrong(const Scene& scene, const Ray& ray, const Hit& right, const Hit& wrong,
                 const std::string& reason) {
    const Adjudication ours = adjudicate_closest(scene, ray, wrong, right);
    CHECK(to_string(ours.verdict) == std::string(to_string(kOursWrong)));
    CHECK_THAT(ours.explanation, ContainsSubstring(reason));
    const Adjudication embree = adjudicate_closest(scene, ray, right, wrong);
    CHECK(to_string(embree.verdict) == std::string(to_string(kEmbreeWrong)));
    CHECK_THAT(embree.explanation, ContainsSubstring(reason));
}

void check_both_ways(const Scene& scene, const Ray& ray, const Hit& a, const Hit& b,
                     Disagreement expected) {
    for (const Adjudication& verdict :
         {adjudicate_closest(scene, ray, a, b), adjudicate_closest(scene, ray, b, a)}) {
        INFO(verdict.explanation);
        CHECK(to_string(verdict.verdict) == std::string(to_string(expected)));
        CHECK(verdict.explanation.empty() == (expected == kNoDisagreement));
    }
}

/// Both may be: but where the suite's own triangle test hits, ours must too.
void check_may_be_missed_by_embree(const Scene& scene, const Ray& ray, const Hit& ours,
                                   const Hit& embree) {
    const Adjudication verdict = adjudicate_closest(scene, ray, ours, embree);
    INFO(verdict.explanation);
    CHECK(to_string(verdict.verdict) == std::string(to_string(kGrazing)));
    CHECK_THAT(verdict.explanation, ContainsSubstring("may be missed or hit"));
    CHECK(adjudicate_closest(scene, ray, embree, ours).verdict == kOursWrong);
}

const Hit kFirst{1.0f, 0, 0.25f, 0.25f};
const Hit kSecond{2.0f, 1, 0.25f, 0.25f};

}  // namespace

TEST_CASE("adjudicate: the same hit, or two misses, are no disagreement",
          "[reference][adjudicate]") {
    const Scene scene = stack_of_three();
    check_both_ways(scene, kRay, kFirst, kFirst, kNoDisagreement);
    check_both_ways(scene, kRay, no_hit(), no_hit(), kNoDisagreement);
    Hit rounded = kFirst;
    rounded.t = std::nextafter(rounded.t, 2.0f);
    check_both_ways(scene, kRay, kFirst, rounded, kNoDisagreement);
}

TEST_CASE("adjudicate: a missed hit is wrong", "[reference][adjudicate]") {
    check_wrong(stack_of_three(), kRay, kFirst, no_hit(), "primitive 0 must be hit");
}

TEST_CASE("adjudicate: a hit behind another surface is wrong", "[reference][adjudicate]") {
    check_wrong(stack_of_three(), kRay, kFirst, kSecond, "primitive 0 must be hit");
}

TEST_CASE("adjudicate: a hit that is not there is wrong", "[reference][adjudicate]") {
    Scene scene = stack_of_three();
    add_triangle(scene, {2, 0, 0.5f}, {3, 0, 0.5f}, {2, 1, 0.5f});
    check_wrong(scene, kRay, kFirst, {0.5f, 3, 0.2f, 0.2f}, "primitive 3 must be missed");
}

TEST_CASE("adjudicate: the right distance with the wrong primitive is wrong",
          "[reference][adjudicate]") {
    check_wrong(stack_of_three(), kRay, kFirst, {1.0f, 1, 0.25f, 0.25f}, "primitive 1 must be hit");
}

TEST_CASE("adjudicate: a distance that is off is wrong, also on the same primitive",
          "[reference][adjudicate]") {
    for (const float off : {1.001f, 0.999f, 1.00001f}) {
        check_wrong(stack_of_three(), kRay, kFirst, {off, 0, 0.25f, 0.25f}, "t 1 +-");
    }
}

TEST_CASE("adjudicate: wrong barycentrics are wrong", "[reference][adjudicate]") {
    check_wrong(stack_of_three(), kRay, kFirst, {1.0f, 0, 0.251f, 0.25f}, "u, v are");
}

TEST_CASE("adjudicate: a hit outside the ray's interval is wrong", "[reference][adjudicate]") {
    Ray ray = kRay;
    ray.t_min = 1.5f;
    check_wrong(stack_of_three(), ray, kSecond, kFirst, "not within the ray's");
    ray = kRay;
    ray.t_max = 0.5f;
    check_wrong(stack_of_three(), ray, no_hit(), kFirst, "not within the ray's");
}

TEST_CASE("adjudicate: a primitive that does not exist is wrong", "[reference][adjudicate]") {
    check_wrong(stack_of_three(), kRay, kFirst, {1.0f, 3, 0.25f, 0.25f}, "there is no primitive 3");
}

TEST_CASE("adjudicate: where both are wrong, it is ours that is reported",
          "[reference][adjudicate]") {
    const Scene scene = stack_of_three();
    const Hit off{1.5f, 0, 0.25f, 0.25f};
    CHECK(adjudicate_closest(scene, kRay, off, off).verdict == kOursWrong);
    CHECK(adjudicate_closest(scene, kRay, no_hit(), off).verdict == kOursWrong);
    CHECK(adjudicate_closest(scene, kRay, kSecond, off).verdict == kOursWrong);
}

TEST_CASE("adjudicate: coplanar duplicates at one distance are a tie", "[reference][adjudicate]") {
    Scene scene = stack_of_three();
    scene.triangles.push_back(scene.triangles[0]);
    check_both_ways(scene, kRay, kFirst, {1.0f, 3, 0.25f, 0.25f}, kTie);
}

TEST_CASE("adjudicate: neighbours on the edge that they share are a tie",
          "[reference][adjudicate]") {
    Scene scene;
    add_triangle(scene, {0, 0, 1}, {1, 0, 1}, {0, 1, 1});
    add_triangle(scene, {1, 0, 1}, {1, 1, 1}, {0, 1, 1});
    const Ray ray{Vec3(0.5f, 0.5f, 0), 0.0f, Vec3(0, 0, 1), kInfinity};
    check_both_ways(scene, ray, {1.0f, 0, 0.5f, 0.5f}, {1.0f, 1, 0.0f, 0.5f}, kTie);
}

TEST_CASE("adjudicate: an outer edge may be hit or missed, but only within rounding",
          "[reference][adjudicate]") {
    const Scene scene = stack_of_three();
    const auto ray_at = [](float x) {
        return Ray{Vec3(x, 0.5f, 0), 0.0f, Vec3(0, 0, 1), kInfinity};
    };
    const auto hit_at = [](float x) { return Hit{1.0f, 0, x, 0.5f}; };
    check_may_be_missed_by_embree(scene, ray_at(0.0f), hit_at(0.0f), no_hit());
    check_may_be_missed_by_embree(scene, ray_at(1.0e-7f), hit_at(1.0e-7f), no_hit());
    check_both_ways(scene, ray_at(-1.0e-7f), hit_at(-1.0e-7f), no_hit(), kGrazing);
    check_wrong(scene, ray_at(1.0e-4f), hit_at(1.0e-4f), no_hit(), "must be hit");
    check_wrong(scene, ray_at(-1.0e-4f), no_hit(), hit_at(-1.0e-4f), "must be missed");
}

TEST_CASE("adjudicate: margins grow with the distance of the origin", "[reference][adjudicate]") {
    Scene scene;
    add_triangle(scene, {0, 0, 1000}, {1, 0, 1000}, {0, 1, 1000});
    const Ray ray{Vec3(1.0e-4f, 0.5f, 0), 0.0f, Vec3(0, 0, 1), kInfinity};
    check_may_be_missed_by_embree(scene, ray, {1000.0f, 0, 1.0e-4f, 0.5f}, no_hit());
}

TEST_CASE("adjudicate: a vertex may be hit or missed", "[reference][adjudicate]") {
    const Ray ray{Vec3(0, 1, 0), 0.0f, Vec3(0, 0, 1), kInfinity};
    Scene scene;
    add_triangle(scene, {0, 0, 1}, {1, 0, 1}, {0, 1, 1});
    check_may_be_missed_by_embree(scene, ray, {1.0f, 0, 0.0f, 1.0f}, no_hit());
}

TEST_CASE("adjudicate: an edge-on triangle may be hit or missed", "[reference][adjudicate]") {
    const Scene scene = triangle_scene({0, 0, 1}, {0, 1, 2}, {0, -1, 2});
    const Ray ray{Vec3(0.0f), 0.0f, Vec3(0, 0, 1), kInfinity};
    check_both_ways(scene, ray, {1.5f, 0, 0.3f, 0.3f}, no_hit(), kGrazing);
    check_wrong(scene, ray, no_hit(), {2.5f, 0, 0.3f, 0.3f}, "edge-on");  // but not anywhere
}

TEST_CASE("adjudicate: the ends of the ray may hold the hit or not", "[reference][adjudicate]") {
    const Scene scene = triangle_scene({0, 0, 1}, {1, 0, 1}, {0, 1, 1});
    Ray ray = kRay;
    ray.t_min = 1.0f;
    check_may_be_missed_by_embree(scene, ray, kFirst, no_hit());
    ray.t_min = 0.0f;
    ray.t_max = std::nextafter(1.0f, 2.0f);
    check_may_be_missed_by_embree(scene, ray, kFirst, no_hit());
}

TEST_CASE("adjudicate: grazing one surface does not excuse missing the next",
          "[reference][adjudicate]") {
    Scene scene = stack_of_three();
    add_triangle(scene, {0.25f, 0, 0.5f}, {2, 0, 0.5f}, {0.25f, 2, 0.5f});  // its edge on the ray
    const Hit grazed{0.5f, 3, 0.0f, 0.125f};
    check_may_be_missed_by_embree(scene, kRay, grazed, kFirst);
    check_wrong(scene, kRay, grazed, kSecond, "before that, primitive 0 must be hit");
    check_wrong(scene, kRay, grazed, no_hit(), "before that, primitive 0 must be hit");
}

TEST_CASE("adjudicate: what the suite's own test hits, the pipelines must not lose",
          "[reference][adjudicate]") {
    // The ray goes through the shared edge: either triangle alone may be missed, not both.
    Scene scene;
    add_triangle(scene, {0, 0, 1}, {1, 0, 1}, {0, 1, 1});
    add_triangle(scene, {1, 0, 1}, {1, 1, 1}, {0, 1, 1});
    const Ray ray{Vec3(0.5f, 0.5f, 0), 0.0f, Vec3(0, 0, 1), kInfinity};
    const Hit edge{1.0f, 0, 0.5f, 0.5f};
    CHECK(adjudicate_closest(scene, ray, no_hit(), edge).verdict == kOursWrong);
    CHECK(adjudicate_closest(scene, ray, edge, no_hit()).verdict == kGrazing);
    CHECK(adjudicate_occluded(scene, ray, false, true, edge).verdict == kOursWrong);
    CHECK(adjudicate_occluded(scene, ray, true, false, no_hit()).verdict == kGrazing);
}

TEST_CASE("adjudicate: occlusion is judged both ways", "[reference][adjudicate]") {
    const Scene scene = stack_of_three();
    CHECK(adjudicate_occluded(scene, kRay, true, true, kFirst).verdict == kNoDisagreement);
    const Adjudication missed = adjudicate_occluded(scene, kRay, false, true, kFirst);
    CHECK(missed.verdict == kOursWrong);
    CHECK_THAT(missed.explanation, ContainsSubstring("primitive 0 must be hit"));
    CHECK(adjudicate_occluded(scene, kRay, true, false, no_hit()).verdict == kEmbreeWrong);
    Ray ray = kRay;
    ray.t_max = 0.5f;
    const Adjudication invented = adjudicate_occluded(scene, ray, true, false, no_hit());
    CHECK(invented.verdict == kOursWrong);
    CHECK_THAT(invented.explanation, ContainsSubstring("every primitive must be missed"));
    CHECK(adjudicate_occluded(scene, ray, false, true, kFirst).verdict == kEmbreeWrong);
}

TEST_CASE("adjudicate: verdicts have names", "[reference][adjudicate]") {
    CHECK(to_string(kTie) == std::string("tie"));
    CHECK(to_string(kGrazing) == std::string("grazing edge"));
    CHECK(to_string(kOursWrong) == std::string("ours wrong"));
    CHECK(to_string(kEmbreeWrong) == std::string("Embree wrong"));
}

TEST_CASE("adjudicate: planted faults in a mesh are found, with either side at fault",
          "[reference][adjudicate]") {
    const Scene scene = icosphere(3);
    const std::vector<Ray> rays = random_rays(2000, 2.0f, 41);
    std::vector<Hit> hits(rays.size());
    brute_force_closest(scene, rays, hits);
    int planted = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Hit& right = hits[i];
        // Faults on the very edge of a triangle are not faults: keep to the inside.
        if (!is_hit(right) || std::min({right.u, right.v, 1 - right.u - right.v}) < 0.01f) continue;
        std::vector<Hit> faults{no_hit(), right, right, right};
        faults[1].t *= 1.001f;
        faults[2].t *= 0.999f;
        faults[3].primitive =
            (right.primitive + 1) % static_cast<std::uint32_t>(scene.triangles.size());
        for (const Hit& fault : faults) {
            CHECK(adjudicate_closest(scene, rays[i], fault, right).verdict == kOursWrong);
            CHECK(adjudicate_closest(scene, rays[i], right, fault).verdict == kEmbreeWrong);
            ++planted;
        }
    }
    CHECK(planted > 1000);
}
