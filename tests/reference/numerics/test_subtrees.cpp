/// Trees that are cut below a level, and what one ray hits below the cut.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "reference/contract/wide_bvh.h"
#include "reference/numerics/closest_in_subtree.h"
#include "reference/truth/tracers.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

/// From the root, so that the subtree is all of the scene.
template <int Width>
void check_from_the_root(const Scene& scene, const std::vector<Ray>& rays) {
    const WideBvh bvh = build_wide_bvh(scene, {Width, 2, 1, 1});
    REQUIRE(bvh.level_count() == 1);
    const WideBvhView<Width> view = view_of<Width>(bvh);
    std::vector<Hit> exact(rays.size());
    brute_force_closest(scene, rays, exact);
    std::size_t hits = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const HitCandidate found = closest_in_subtree(view, 0, rays[i], kInfinity, false).best;
        CHECK(found.primitive == exact[i].primitive);
        CHECK(found.t == exact[i].t);
        const HitCandidate any = closest_in_subtree(view, 0, rays[i], kInfinity, true).best;
        CHECK((any.primitive != kNone) == is_hit(exact[i]));
        CHECK(any.t >= found.t);
        if (!is_hit(exact[i])) continue;
        ++hits;
        CHECK(closest_in_subtree(view, 0, rays[i], exact[i].t, false).best.t == exact[i].t);
        const float nearer = std::nextafter(exact[i].t, 0.0f);
        CHECK(closest_in_subtree(view, 0, rays[i], nearer, false).best.primitive == kNone);
    }
    CHECK(hits > 20);
}

}  // namespace

TEST_CASE("subtrees: the closest hit is brute force's, bit for bit, and no farther than the limit",
          "[reference][subtrees]") {
    const Scene scene = soup(400, 0.3f, 3);
    const std::vector<Ray> rays = random_rays(200, 1.5f, 4);
    check_from_the_root<2>(scene, rays);
    check_from_the_root<4>(scene, rays);
    check_from_the_root<8>(scene, rays);
    check_from_the_root<16>(scene, rays);
}

TEST_CASE("subtrees: a ray from so far away that its slabs overflow enters no missing child",
          "[reference][subtrees]") {
    const Scene scene = soup(5, 0.3f, 3);  // three slots of eight are empty
    const WideBvh bvh = build_wide_bvh(scene, {8, 1, 1, 1});
    const WideBvhView<8> view = view_of<8>(bvh);
    REQUIRE(view.inner[0].child[7] == kNone);
    std::vector<Ray> rays;
    for (const float sign : {-1.0f, 1.0f}) {
        rays.push_back({Vec3(sign * 1.0e26f), 0.0f, Vec3(-sign * 1.0e-15f), kInfinity});
        rays.push_back({Vec3(sign * 1.0e26f), 0.0f, Vec3(sign * 1.0e-15f), kInfinity});
    }
    std::vector<Hit> exact(rays.size());
    brute_force_closest(scene, rays, exact);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        CHECK(closest_in_subtree(view, 0, rays[i], kInfinity, false).best.primitive ==
              exact[i].primitive);
    }
}

TEST_CASE("subtrees: children are sorted by where they are entered, missed ones last",
          "[reference][subtrees]") {
    Random random(5);
    for (int round = 0; round < 200; ++round) {
        std::uint32_t keys[16];
        for (std::uint32_t i = 0; i < 16; ++i) {
            keys[i] =
                random() % 3 == 0 ? kNone : visit_key(static_cast<float>(random() % 9) * 0.25f, i);
        }
        std::vector<std::uint32_t> expected(keys, keys + 16);
        std::sort(expected.begin(), expected.end());
        sort_visits<16>(keys);
        CHECK(std::vector<std::uint32_t>(keys, keys + 16) == expected);
    }
}

TEST_CASE("subtrees: a tree is cut at its levels, and stays valid", "[reference][subtrees]") {
    const Scene scene = height_field(60);
    const WideBvh whole = build_wide_bvh(scene, {4, 2, 1, 0});
    REQUIRE(whole.level_count() > 5);
    CHECK_FALSE(whole.has_subtrees());
    for (const std::uint32_t levels : {1u, 2u, 5u}) {
        const WideBvh cut = build_wide_bvh(scene, {4, 2, 1, levels});
        CHECK(cut.level_count() == levels);
        CHECK(cut.has_subtrees());
        CHECK(cut.node_refs == whole.node_refs);
        CHECK(validate(cut, scene) == std::vector<std::string>{});
        CHECK(cut.ends_queues(cut.level_begins[levels - 1]));
        CHECK(cut.ends_queues(0) == (levels == 1));
        CHECK(fingerprint(cut) != fingerprint(whole));
        WideBvh again = cut;  // as a program does that is handed a tree that is cut already
        cut_levels(again, 4);
        CHECK(again.level_count() == 4);
        cut_levels(again, 0);
        CHECK(fingerprint(again) == fingerprint(whole));
    }
    WideBvh more = whole;
    cut_levels(more, 64);
    CHECK(fingerprint(more) == fingerprint(whole));
}

TEST_CASE("subtrees: a tree too deep for the stack keeps more levels", "[reference][subtrees]") {
    Scene scene;
    scene.materials.emplace_back();
    // Nested: each level of a tree of width 16 splits off a few.
    for (int octave = 60; octave > -140; --octave) {
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 at(0.0f);
            at[axis] = std::ldexp(1.0f, octave / 2);
            add_triangle(scene, at, 1.5f * at, 1.25f * at);
        }
    }
    for (const int width : {2, 16}) {
        const WideBvh whole = build_wide_bvh(scene, {width, 1, 1, 0});
        const WideBvh cut = build_wide_bvh(scene, {width, 1, 1, 1});
        const std::uint32_t below = whole.level_count() - cut.level_count();
        CHECK(below * static_cast<std::uint32_t>(width - 1) <= kSubtreeStack);
        CHECK((cut.level_count() == 1) ==
              (whole.level_count() - 1 <= kSubtreeStack / static_cast<std::uint32_t>(width - 1)));
        CHECK(validate(cut, scene) == std::vector<std::string>{});
    }
}
