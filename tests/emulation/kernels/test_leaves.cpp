/// The level kernel on leaves: the closest hit of each ray, recorded once, never out of bounds.
#include <bit>
#include <cstring>
#include <numeric>
#include <utility>

#include "reference/truth/tracers.h"
#include "tests/catch.h"
#include "tests/emulation/one_level.h"

using namespace scotty::emulation;
using namespace scotty::emulation::test;
using scotty::reference::EarlyOut;
using scotty::reference::Hit;
using scotty::reference::HitMode;
using scotty::reference::Scene;

namespace {

/// One leaf with all triangles of a scene, and a queue of ray ids.
struct OneLeaf {
    explicit OneLeaf(Scene all, std::uint32_t hit_capacity = 1)
        : scene(std::move(all)), capacity(hit_capacity) {
        for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
            const auto& [a, b, c] = scene.triangles[i];
            triangles.push_back({scene.vertices[a], scene.vertices[b], scene.vertices[c], i});
        }
        leaf = {0, static_cast<std::uint32_t>(triangles.size())};
    }

    void run(const std::vector<std::uint32_t>& queue, HitMode mode, EarlyOut policy,
             bool any_hit = false, std::uint32_t threads = 32) {
        counts.assign(rays.size(), 0);
        candidates.assign(rays.size() * capacity, {-7.0f, kPoison});
        packed.assign(rays.size(), kNoPackedHit);
        if (minimum.size() != rays.size()) minimum.assign(rays.size(), kInfinity);
        lowered = minimum;
        const auto count = static_cast<std::uint32_t>(queue.size());
        const std::uint32_t ref = scotty::reference::kLeafBit;
        const std::vector<std::uint32_t> queue_offsets{0, count};
        const std::vector<std::uint32_t> blocks{0, (count + threads - 1) / threads};
        const LevelView level{
            0,       1,       1,       &count, queue_offsets.data(), queue.data(), blocks.data(),
            nullptr, nullptr, nullptr, nullptr};
        Device device({2, ScheduleKind::free, 0});
        device.launch(blocks[1], threads, [&](const Block& block) {
            intersect(
                block, scotty::reference::WideBvhView<8>{nullptr, &leaf, triangles.data(), &ref},
                rays.data(), level,
                HitView{mode, capacity, counts.data(), candidates.data(), packed.data(), &needed},
                MinimumView{policy, any_hit, minimum.data(), lowered.data()}, 0);
        });
    }

    Scene scene;
    std::uint32_t capacity;
    scotty::reference::Leaf leaf{};
    std::vector<scotty::reference::LeafTriangle> triangles;
    std::vector<Ray> rays;
    std::vector<std::uint32_t> counts;
    std::vector<HitCandidate> candidates;
    std::vector<std::uint64_t> packed;
    std::vector<float> minimum, lowered;
    std::uint32_t needed = 0;
};

std::vector<std::uint32_t> ids(std::uint32_t count) {
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    return all;
}

std::uint64_t pack(float t, std::uint32_t primitive) {
    return std::uint64_t{std::bit_cast<std::uint32_t>(t)} << 32 | primitive;
}

/// The same triangle many times, seen from z = 5 at t = 5.
Scene coincident(std::uint32_t count) {
    Scene scene;
    scene.materials.emplace_back();
    for (std::uint32_t i = 0; i < count; ++i) {
        scotty::reference::test::add_triangle(scene, Vec3(-1, -1, 0), Vec3(1, -1, 0),
                                              Vec3(0, 1, 0));
    }
    return scene;
}

Ray towards_origin() { return {Vec3(0, 0, 5), 0.0f, Vec3(0, 0, -1), kInfinity}; }

}  // namespace

TEST_CASE("leaf: each ray's closest hit is brute force's, for odd queues and both hit modes",
          "[emulation][leaf]") {
    OneLeaf leaf(scotty::reference::test::soup(200, 0.6f, 4));
    leaf.rays = scotty::reference::test::random_rays(400, 1.5f, 5);
    for (std::size_t i = 0; i < leaf.rays.size(); i += 7) {
        leaf.rays[i] = scotty::reference::dead_ray();
    }
    std::vector<Hit> exact(leaf.rays.size());
    scotty::reference::brute_force_closest(leaf.scene, leaf.rays, exact);
    for (const std::uint32_t threads : {32u, 64u, 1024u}) {
        for (const std::uint32_t count : {1u, 31u, 32u, 33u, 64u, 65u, 400u}) {
            for (const HitMode mode : {HitMode::buffer, HitMode::packed}) {
                leaf.run(ids(count), mode, EarlyOut::off, false, threads);
                CHECK(leaf.needed == 0);
                for (std::uint32_t i = 0; i < leaf.rays.size(); ++i) {
                    const bool hit = i < count && is_hit(exact[i]);
                    if (mode == HitMode::packed) {
                        CHECK(leaf.packed[i] ==
                              (hit ? pack(exact[i].t, exact[i].primitive) : kNoPackedHit));
                        continue;
                    }
                    // For rays that are not in the queue, dead or missing, nothing is written.
                    CHECK(leaf.counts[i] == (hit ? 1 : 0));
                    CHECK(leaf.candidates[i].primitive == (hit ? exact[i].primitive : kPoison));
                    if (hit) CHECK(leaf.candidates[i].t == exact[i].t);
                }
            }
        }
    }
}

TEST_CASE("leaf: hits on edges and corners, among rays that pass beside them, are brute force's",
          "[emulation][leaf]") {
    using namespace scotty::reference::test;
    // A grid of whole numbers seen along z: lines through corners, edges and the insides of cells.
    Scene scene;
    scene.materials.emplace_back();
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 4; ++x) {
            const auto fx = static_cast<float>(x);
            const auto fy = static_cast<float>(y);
            add_triangle(scene, Vec3(fx, fy, 0), Vec3(fx + 1, fy, 0), Vec3(fx + 1, fy + 1, 0));
            add_triangle(scene, Vec3(fx, fy, 0), Vec3(fx + 1, fy + 1, 0), Vec3(fx, fy + 1, 0));
        }
    }
    OneLeaf leaf(std::move(scene));
    for (int i = 0; i < 9 * 9; ++i) {
        const Vec3 at(0.5f * static_cast<float>(i % 9), 0.5f * static_cast<float>(i / 9), 7.0f);
        leaf.rays.push_back({at, 0.0f, Vec3(0, 0, -1), kInfinity});
    }
    for (const Ray& ray : random_rays(100, 3.0f, 6)) leaf.rays.push_back(ray);
    std::vector<Hit> exact(leaf.rays.size());
    scotty::reference::brute_force_closest(leaf.scene, leaf.rays, exact);
    leaf.run(ids(static_cast<std::uint32_t>(leaf.rays.size())), HitMode::packed, EarlyOut::off);
    std::size_t hits = 0;
    for (std::size_t i = 0; i < leaf.rays.size(); ++i) {
        const bool hit = is_hit(exact[i]);
        hits += hit ? 1 : 0;
        CHECK(leaf.packed[i] == (hit ? pack(exact[i].t, exact[i].primitive) : kNoPackedHit));
    }
    CHECK(hits >= 9 * 9);  // the closed square, its border too
}

TEST_CASE("leaf: of 1, 64, 65 or 1000 coincident triangles the lowest id wins",
          "[emulation][leaf]") {
    for (const std::uint32_t count : {1u, 64u, 65u, 1000u}) {
        OneLeaf leaf(coincident(count));
        // In any order of the leaf, the tie goes by id and not by place.
        std::reverse(leaf.triangles.begin(), leaf.triangles.end());
        leaf.rays.assign(3, towards_origin());
        leaf.run(ids(3), HitMode::buffer, EarlyOut::off);
        for (int i = 0; i < 3; ++i) {
            CHECK(leaf.counts[i] == 1);
            CHECK(leaf.candidates[i].t == 5.0f);
            CHECK(leaf.candidates[i].primitive == 0);
        }
    }
}

TEST_CASE("leaf: a triangle behind the first load of shared memory is found", "[emulation][leaf]") {
    OneLeaf leaf(coincident(1000));
    for (auto& triangle : leaf.triangles) triangle.v0.z = triangle.v1.z = triangle.v2.z = -1.0f;
    for (const std::uint32_t nearest : {0u, 63u, 64u, 999u}) {
        auto& triangle = leaf.triangles[nearest];
        triangle.v0.z = triangle.v1.z = triangle.v2.z = 0.0f;
        leaf.rays.assign(1, towards_origin());
        leaf.run(ids(1), HitMode::packed, EarlyOut::off);
        CHECK(leaf.packed[0] == pack(5.0f, nearest));
        triangle.v0.z = triangle.v1.z = triangle.v2.z = -1.0f;
    }
}

TEST_CASE("leaf: hits count from t_min on and before t_max", "[emulation][leaf]") {
    OneLeaf leaf(coincident(1));
    const float before = std::nextafter(5.0f, 0.0f);
    const float after = std::nextafter(5.0f, 9.0f);
    const auto hits = [&](float t_min, float t_max) {
        leaf.rays.assign(1, towards_origin());
        leaf.rays[0].t_min = t_min;
        leaf.rays[0].t_max = t_max;
        leaf.run(ids(1), HitMode::buffer, EarlyOut::off);
        return leaf.counts[0];
    };
    CHECK(hits(0.0f, kInfinity) == 1);
    CHECK(hits(5.0f, kInfinity) == 1);
    CHECK(hits(after, kInfinity) == 0);
    CHECK(hits(0.0f, after) == 1);
    CHECK(hits(0.0f, 5.0f) == 0);
    CHECK(hits(0.0f, before) == 0);
}

TEST_CASE("leaf: a hit beyond the minimum is not recorded, one as near is", "[emulation][leaf]") {
    OneLeaf leaf(coincident(1));
    leaf.rays.assign(4, towards_origin());
    leaf.minimum = {5.0f, std::nextafter(5.0f, 0.0f), kInfinity, kDone};
    for (const HitMode mode : {HitMode::buffer, HitMode::packed}) {
        leaf.run(ids(4), mode, EarlyOut::level);
        const std::vector<bool> recorded{true, false, true, false};
        for (std::size_t i = 0; i < 4; ++i) {
            if (mode == HitMode::buffer) CHECK((leaf.counts[i] == 1) == recorded[i]);
            if (mode == HitMode::packed) CHECK((leaf.packed[i] != kNoPackedHit) == recorded[i]);
        }
        // The minimum is lowered to the hit's distance, never raised.
        CHECK(leaf.lowered == std::vector<float>{5.0f, std::nextafter(5.0f, 0.0f), 5.0f, kDone});
        CHECK(leaf.minimum[2] == kInfinity);  // kernels read the old value until it is published
    }
    leaf.run(ids(4), HitMode::buffer, EarlyOut::off);
    CHECK(leaf.counts == std::vector<std::uint32_t>{1, 1, 1, 1});  // off never culls
    CHECK(leaf.lowered == leaf.minimum);
}

TEST_CASE("leaf: an any-hit query marks the ray as done", "[emulation][leaf]") {
    OneLeaf leaf(coincident(1));
    leaf.rays.assign(2, towards_origin());
    leaf.rays[1].direction = Vec3(0, 0, 1);  // misses
    leaf.run(ids(2), HitMode::buffer, EarlyOut::level, true);
    CHECK(leaf.lowered == std::vector<float>{kDone, kInfinity});
}

TEST_CASE("leaf: a full hit buffer is reported with the slots it needs, the next ray's are safe",
          "[emulation][leaf]") {
    for (const std::uint32_t capacity : {1u, 3u}) {
        OneLeaf leaf(coincident(1), capacity);
        leaf.rays.assign(3, towards_origin());
        // The middle ray is in the queue five times, as if in five leaves.
        leaf.run({1, 1, 1, 1, 1}, HitMode::buffer, EarlyOut::off);
        CHECK(leaf.counts == std::vector<std::uint32_t>{0, 5, 0});
        CHECK(leaf.needed == 5);
        for (std::uint32_t slot = 0; slot < 3 * capacity; ++slot) {
            const bool own = slot / capacity == 1;
            CHECK(leaf.candidates[slot].primitive == (own ? 0 : kPoison));
        }
    }
}
