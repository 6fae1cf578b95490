/// Whole traversals of given rays: brute force's hits, growth, and every error.
#include "tests/properties.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "emulation/host/traversal.h"
#include "reference/truth/tracers.h"
#include "tests/catch.h"
#include "tests/emulation/renders.h"
#include "tests/reference/hard_cases.h"
#include "tests/reference/meshes.h"

using namespace scotty::emulation;
using namespace scotty::emulation::test;
using namespace scotty::reference;
using scotty::reference::test::add_triangle;
using scotty::reference::test::random_rays;
using scotty::reference::test::soup;

namespace {

std::vector<Hit> brute_force(const Scene& scene, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    brute_force_closest(scene, rays, hits);
    return hits;
}

std::vector<Hit> trace(const Scene& scene, const std::vector<Ray>& rays,
                       const PipelineParameters& p, TraversalKind kind = TraversalKind::closest,
                       StageObserver* observer = nullptr, const DeviceOptions& device = {2}) {
    const WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 1));
    std::vector<Hit> hits(rays.size());
    Pipeline(scene, bvh, p, device, observer).trace(rays, kind, hits);
    return hits;
}

/// `count` triangles one behind the other on the z axis, seen from z = 1: a hit in each leaf.
Scene stack(std::uint32_t count) {
    Scene scene;
    scene.materials.emplace_back();
    for (std::uint32_t i = 0; i < count; ++i) {
        const float z = -static_cast<float>(i);
        add_triangle(scene, Vec3(-1, -1, z), Vec3(1, -1, z), Vec3(0, 1, z));
    }
    return scene;
}

PipelineParameters random_parameters(std::mt19937& random) {
    const auto below = [&](std::uint32_t end) {
        return static_cast<std::uint32_t>(random() % end);
    };
    PipelineParameters p;
    p.width = 2 << below(4);
    p.rays_per_block = static_cast<int>(32 * (1 + below(32)));
    p.max_leaf_size = static_cast<int>(1 + below(64));
    p.queue_levels = below(5);
    p.queues = static_cast<QueueKind>(below(2));
    p.early_out = static_cast<EarlyOut>(below(3));
    p.block_order = static_cast<BlockOrder>(below(2));
    p.hit_mode = static_cast<HitMode>(below(2));
    p.hit_capacity = 1 + below(8);
    p.batch_rays = below(2) == 0 ? 1 + below(400) : 1u << 16;
    return p;
}

PipelineParameters one_triangle_leaves() {
    PipelineParameters p;
    p.max_leaf_size = 1;
    p.early_out = EarlyOut::off;
    return p;
}

const Ray kThroughStack{Vec3(0, 0, 1), 0.0f, Vec3(0, 0, -1), kInfinity};

/// Counts the stages that it is shown.
class Counter : public StageObserver {
 public:
    void on_stage(const StageView& stage) override {
        if (stage.kind != StageKind::intersect_root) return;
        for (const std::uint32_t n : stage.get<std::uint32_t>("child_counts")) pushes += n;
    }
    void on_retry(std::string_view stage, std::string_view reason) override {
        retries.push_back(std::string(stage) + ": " + std::string(reason));
    }
    std::size_t pushes = 0;
    std::vector<std::string> retries;
};

/// Message and kind of the exception that `action` throws.
template <class Action>
std::string error_of(ErrorKind kind, Action&& action) {
    try {
        action();
    } catch (const Error& error) {
        CHECK(error.kind() == kind);
        return error.what();
    }
    FAIL("nothing was thrown");
    return {};
}

void check_contains(const std::string& message, const std::vector<std::string>& parts) {
    for (const std::string& part : parts)
        CHECK_THAT(message, Catch::Matchers::ContainsSubstring(part));
}

}  // namespace

TEST_CASE("trace: equals brute force bit for bit, whatever the parameters",
          "[emulation][traversal]") {
    scotty::tests::check_property("random scenes, rays and parameters", [](std::uint32_t seed) {
        std::mt19937 random(seed);
        const auto below = [&](std::uint32_t end) {
            return static_cast<std::uint32_t>(random() % end);
        };
        const Scene scene =
            soup(1 + below(300), 0.05f + 0.002f * static_cast<float>(below(300)), seed);
        std::vector<Ray> rays = random_rays(1 + below(300), 1.5f, seed + 1);
        for (Ray& ray : rays) {
            if (below(10) == 0) ray.t_max = 0.4f;
            if (below(10) == 0) ray.t_min = 0.3f;
            if (below(20) == 0) ray = dead_ray();
            if (below(10) == 0) ray.direction = Vec3(0, below(2) == 0 ? 1.0f : -1.0f, 0);
        }
        const PipelineParameters p = random_parameters(random);
        const DeviceOptions device{1 + below(2), static_cast<ScheduleKind>(below(6)), seed};
        const std::vector<Hit> exact = brute_force(scene, rays);
        RC_ASSERT(same_bits(trace(scene, rays, p, TraversalKind::closest, nullptr, device), exact));
        // An any-hit query agrees on whether there is a hit.
        const std::vector<Hit> any = trace(scene, rays, p, TraversalKind::any, nullptr, device);
        for (std::size_t i = 0; i < rays.size(); ++i) RC_ASSERT(is_hit(any[i]) == is_hit(exact[i]));
    });
}

TEST_CASE("trace: equals brute force bit for bit on scenes that are hard on it",
          "[emulation][traversal]") {
    using namespace scotty::reference::test;
    for (std::uint32_t kind = 0; kind < kHardScenes; ++kind) {
        scotty::tests::check_property(
            "random hard scenes and parameters", [kind](std::uint32_t seed) {
                Random random(seed);
                Scene scene = hard_scene(static_cast<HardScene>(kind), 1 + random() % 200, random);
                validate_and_repair(scene);
                const std::vector<Ray> rays = hard_rays(scene, 1 + random() % 300, random);
                const std::vector<Hit> exact = brute_force(scene, rays);
                RC_ASSERT(same_bits(trace(scene, rays, random_parameters(random)), exact));
            });
    }
}

TEST_CASE("trace: leaves of coincident triangles, larger than a leaf may be, give the lowest id",
          "[emulation][traversal]") {
    for (const std::uint32_t count : {1u, 64u, 65u, 1000u}) {
        Scene scene;
        scene.materials.emplace_back();
        for (std::uint32_t i = 0; i < count; ++i) {
            add_triangle(scene, Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0));
        }
        for (const int leaf_size : {1, 4, 64}) {
            PipelineParameters p;
            p.max_leaf_size = leaf_size;
            const std::vector<Hit> hits = trace(scene, {kThroughStack}, p);
            CHECK(hits[0].primitive == 0);
            CHECK(hits[0].t == 1.0f);
        }
    }
}

TEST_CASE("trace: a hit buffer that is too small grows, says so, and changes nothing",
          "[emulation][traversal]") {
    const Scene scene = stack(100);
    PipelineParameters p = one_triangle_leaves();
    p.hit_capacity = 1;
    std::vector<Ray> rays(70, kThroughStack);
    rays[3].direction = Vec3(0, 0, 1);
    Counter counter;
    const std::vector<Hit> hits = trace(scene, rays, p, TraversalKind::closest, &counter);
    CHECK(same_bits(hits, brute_force(scene, rays)));
    REQUIRE_FALSE(counter.retries.empty());
    CHECK(counter.retries.size() < 8);  // it doubles at least
    CHECK_THAT(counter.retries[0], Catch::Matchers::ContainsSubstring("merge_intersections"));
    CHECK_THAT(counter.retries[0], Catch::Matchers::ContainsSubstring("the buffer had 1 slots"));
    // A buffer that is large enough from the start gives the same bits, and no retry.
    Counter quiet;
    p.hit_capacity = 100;
    CHECK(same_bits(trace(scene, rays, p, TraversalKind::closest, &quiet), hits));
    CHECK(quiet.retries.empty());
    p.hit_mode = HitMode::packed;
    p.hit_capacity = 1;
    CHECK(same_bits(trace(scene, rays, p, TraversalKind::closest, &quiet), hits));
    CHECK(quiet.retries.empty());
}

TEST_CASE("trace: a grown hit buffer is kept for the next call", "[emulation][traversal]") {
    const Scene scene = stack(50);
    PipelineParameters p = one_triangle_leaves();
    p.hit_capacity = 1;
    const WideBvh bvh = build_wide_bvh(scene, {p.width, p.max_leaf_size, 1});
    Counter counter;
    Pipeline pipeline(scene, bvh, p, {1}, &counter);
    std::vector<Hit> hits(1);
    pipeline.trace({&kThroughStack, 1}, TraversalKind::closest, hits);
    const std::size_t retries = counter.retries.size();
    CHECK(retries > 0);
    pipeline.trace({&kThroughStack, 1}, TraversalKind::closest, hits);
    CHECK(counter.retries.size() == retries);
}

TEST_CASE("trace: dead rays enter no queue, under every early-out", "[emulation][traversal]") {
    const Scene scene = soup(100, 0.5f, 1);
    for (const EarlyOut early_out : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
        PipelineParameters p;
        p.early_out = early_out;
        Counter counter;
        const std::vector<Hit> hits =
            trace(scene, std::vector<Ray>(100, dead_ray()), p, TraversalKind::closest, &counter);
        CHECK(counter.pushes == 0);
        for (const Hit& hit : hits) CHECK_FALSE(is_hit(hit));
    }
}

TEST_CASE("trace: no rays give no hits and no launches", "[emulation][traversal]") {
    const Scene scene = stack(3);
    const WideBvh bvh = build_wide_bvh(scene, {8, 4, 1});
    Pipeline pipeline(scene, bvh, {}, {});
    pipeline.trace({}, TraversalKind::closest, {});
    CHECK(pipeline.launches().empty());
}

TEST_CASE("trace: a level of more than 6,000 nodes and more than 16 levels are no limit",
          "[emulation][traversal]") {
    const Scene scene = soup(20000, 0.02f, 1);
    PipelineParameters p = one_triangle_leaves();
    p.early_out = EarlyOut::level;
    p.width = 2;
    const WideBvh bvh = build_wide_bvh(scene, {2, 1, 1});
    std::uint32_t most = 0;
    for (std::uint32_t level = 0; level < bvh.level_count(); ++level) {
        most = std::max(most, bvh.level_begins[level + 1] - bvh.level_begins[level]);
    }
    REQUIRE(most > 6000);
    REQUIRE(bvh.level_count() > 16);
    const std::vector<Ray> rays = random_rays(200, 1.0f, 2);
    std::vector<Hit> hits(rays.size());
    Pipeline(scene, bvh, p, {2}).trace(rays, TraversalKind::closest, hits);
    CHECK(same_bits(hits, brute_force(scene, rays)));
}

TEST_CASE("trace: a ray that kernels cannot rely on is refused by number and fault",
          "[emulation][traversal]") {
    const Scene scene = stack(3);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const auto refuse = [&](const char* fault, auto&& spoil) {
        std::vector<Ray> rays(5, kThroughStack);
        spoil(rays[3]);
        check_contains(error_of(ErrorKind::bad_input, [&] { trace(scene, rays, {}); }),
                       {"ray 3", fault});
    };
    refuse("origin is not finite", [&](Ray& ray) { ray.origin.y = nan; });
    refuse("origin is not finite", [&](Ray& ray) { ray.origin.x = kInfinity; });
    refuse("direction is not finite", [&](Ray& ray) { ray.direction.z = nan; });
    refuse("direction is not finite", [&](Ray& ray) { ray.direction.z = -kInfinity; });
    refuse("direction is zero", [&](Ray& ray) { ray.direction = Vec3(0.0f); });
    refuse("t_min is negative", [&](Ray& ray) { ray.t_min = -1e-9f; });
    refuse("t_min is negative or NaN", [&](Ray& ray) { ray.t_min = nan; });
    refuse("t_max is NaN", [&](Ray& ray) { ray.t_max = nan; });
}

TEST_CASE("trace: hits of another length than rays, or a BVH of another width, break a contract",
          "[emulation][traversal]") {
    const Scene scene = stack(3);
    const WideBvh bvh = build_wide_bvh(scene, {8, 4, 1});
    std::vector<Hit> hits(2);
    Pipeline pipeline(scene, bvh, {}, {});
    check_contains(error_of(ErrorKind::internal,
                            [&] {
                                pipeline.trace({&kThroughStack, 1}, TraversalKind::closest, hits);
                            }),
                   {"1 vs 2"});
    PipelineParameters p;
    p.width = 4;
    check_contains(error_of(ErrorKind::internal, [&] { Pipeline(scene, bvh, p, {}); }), {"8 vs 4"});
    p.width = 5;
    check_contains(error_of(ErrorKind::bad_input, [&] { Pipeline(scene, bvh, p, {}); }),
                   {"tree width", "5"});
}

TEST_CASE("queue: more pushes than a child has room for are an error with stage, node and sizes",
          "[emulation][traversal]") {
    const Scene scene = soup(200, 0.1f, 1);
    WideBvh bvh = build_wide_bvh(scene, {8, 4, 1});
    // A broken tree: two slots of the root lead to the same child, and every ray enters both.
    WideNode<8>& root = std::get<std::vector<WideNode<8>>>(bvh.inner)[0];
    for (const int slot : {0, 1}) {
        root.child[slot] = 1;
        root.low_x[slot] = root.low_y[slot] = root.low_z[slot] = -9.0f;
        root.high_x[slot] = root.high_y[slot] = root.high_z[slot] = 9.0f;
    }
    const std::vector<Ray> rays = random_rays(40, 1.0f, 2);
    std::vector<Hit> hits(rays.size());
    Pipeline pipeline(scene, bvh, {}, {1});
    check_contains(
        error_of(ErrorKind::internal, [&] { pipeline.trace(rays, TraversalKind::closest, hits); }),
        {"trace/level0/intersect_root", "node 1 ", "40 slots", "80 rays were pushed"});
}

TEST_CASE("queue: a level that may need more slots than there are names stage and sizes",
          "[emulation][traversal]") {
    const Scene scene = stack(100);
    const PipelineParameters p = one_triangle_leaves();
    const WideBvh bvh = build_wide_bvh(scene, {p.width, p.max_leaf_size, 1});
    Device device({1});
    LaunchLog log(nullptr);
    const std::vector<Ray> rays(30, kThroughStack);
    std::vector<Hit> hits(rays.size());
    StagePlace place;
    place.bounce = 2;
    Traversal narrow(scene, bvh, p, device, log, {1000, 100000});
    check_contains(error_of(ErrorKind::bad_input,
                            [&] { narrow.run(rays, TraversalKind::closest, place, hits); }),
                   {"bounce2/level1/scan_counts", "240 queue entries in 8 nodes", "1920 slots",
                    "1000", "--batch-rays"});
}

TEST_CASE("hit buffer: what cannot grow further is an error with stage and sizes",
          "[emulation][traversal]") {
    const Scene scene = stack(100);
    PipelineParameters p = one_triangle_leaves();
    const WideBvh bvh = build_wide_bvh(scene, {p.width, p.max_leaf_size, 1});
    Device device({1});
    LaunchLog log(nullptr);
    const std::vector<Ray> rays(30, kThroughStack);
    std::vector<Hit> hits(rays.size());
    const auto run = [&](const TraversalLimits& limits) {
        Traversal(scene, bvh, p, device, log, limits).run(rays, TraversalKind::closest, {}, hits);
    };
    run({100000, 3000});  // just enough
    check_contains(error_of(ErrorKind::bad_input,
                            [&] {
                                run({100000, 2999});
                            }),
                   {"trace/merge_intersections", "a ray has 100 hits", "30 rays", "2999 slots",
                    "--batch-rays"});
    // Too many from the start: the error comes before memory is asked for.
    p.hit_capacity = 65536;
    check_contains(error_of(ErrorKind::bad_input,
                            [&] {
                                run({100000, 2999});
                            }),
                   {"trace/merge_intersections", "30 rays with 65536 hit slots", "2999 slots",
                    "--hit-capacity"});
}

TEST_CASE("hit buffer: slots that few rays needed do not stand in the way of many",
          "[emulation][traversal]") {
    const Scene scene = stack(100);
    PipelineParameters p = one_triangle_leaves();
    p.hit_capacity = 2;
    const WideBvh bvh = build_wide_bvh(scene, {p.width, p.max_leaf_size, 1});
    Device device({1});
    LaunchLog log(nullptr);
    Traversal traversal(scene, bvh, p, device, log, {100000, 1000});
    std::vector<Hit> hits(500);
    traversal.run({&kThroughStack, 1}, TraversalKind::closest, {}, hits);  // 100 slots
    std::vector<Ray> rays(500, kThroughStack);
    for (Ray& ray : rays) ray.t_max = 1.5f;  // one hit each
    traversal.run(rays, TraversalKind::closest, {}, hits);
    CHECK(same_bits(hits, brute_force(scene, rays)));
}
