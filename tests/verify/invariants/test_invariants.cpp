/// Every invariant is seen to fail, at the right place, on a run of the emulator that was spoiled;
/// and not to fail on the run as it was.
#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "tests/verify/spheres_run.h"
#include "verify/invariants/invariants.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using verify::Failure;
using verify::InvariantChecker;
using verify::test::small_parameters;
using verify::test::spheres;
using verify::test::StageCopies;
using verify::test::StageCopy;
using Run = verify::test::SpheresRun;
namespace invariant = verify::invariant;

/// The first failure under that name; fails the test where there is none.
Failure first(const std::vector<Failure>& failures, const char* tag) {
    for (const Failure& failure : failures) {
        if (failure.invariant == tag) return failure;
    }
    std::string all;
    for (const Failure& failure : failures) all += to_string(failure) + "\n";
    FAIL("no failure '" << tag << "' among:\n" << all);
    return {};
}

/// A child of the stage's level with at least `count` rays in its queue: position in its level.
std::uint32_t child_with(StageCopy& stage, std::uint32_t count) {
    const auto counts = stage.output<std::uint32_t>("child_counts");
    for (std::uint32_t child = 0; child < counts.size(); ++child) {
        if (counts[child] >= count) return child;
    }
    FAIL("no child of " << stage.view.name << " has " << count << " rays");
    return 0;
}

TEST_CASE("invariants: a correct run violates none, whatever the parameters",
          "[verify][invariants]") {
    for (const EarlyOut early_out : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
        for (const HitMode hit_mode : {HitMode::buffer, HitMode::packed}) {
            for (const ShadowQuery query : {ShadowQuery::any, ShadowQuery::closest}) {
                for (const std::uint32_t batch : {1u << 18, 61u, 1u}) {
                    if (batch == 1 && hit_mode == HitMode::packed)
                        continue;  // slow, not another case
                    PipelineParameters p = small_parameters();
                    if (batch == 1) p.image_width = p.image_height = 3;
                    p.early_out = early_out;
                    p.hit_mode = hit_mode;
                    p.shadow_query = query;
                    p.batch_rays = batch;
                    p.block_order = batch == 61 ? BlockOrder::strided : BlockOrder::linear;
                    p.hit_capacity = batch == 61 ? 1 : 8;
                    p.queue_levels = batch == 61 ? 2 : 0;
                    p.samples_per_pass = batch == 61 ? 1 : 0;
                    const WideBvh bvh = build_wide_bvh(spheres(), bvh_parameters(p, 0));
                    InvariantChecker checker(spheres(), bvh, p);
                    emulation::Pipeline(spheres(), bvh, p, {}, &checker).render();
                    INFO(to_string(early_out) << ' ' << to_string(hit_mode) << ' '
                                              << to_string(query) << " batch " << batch);
                    for (const Failure& failure : checker.failures()) {
                        UNSCOPED_INFO(to_string(failure));
                    }
                    CHECK(checker.failures().empty());
                    CHECK(checker.counts().stages > 10);
                    CHECK(checker.counts().pushes > 100);
                    CHECK(checker.counts().leaf_hits > 0);
                    // Two levels are too few for a hit to cull what is below it.
                    if (early_out != EarlyOut::off && p.queue_levels == 0 && batch > 1) {
                        CHECK(checker.counts().culled > 0);
                    }
                }
            }
        }
    }
}

TEST_CASE("invariants: a retried traversal is judged by its last attempt alone",
          "[verify][invariants]") {
    Run run(small_parameters());
    InvariantChecker checker(spheres(), run.bvh, run.parameters);
    for (const StageCopy& stage : run.stages.all()) {
        if (stage.view.name == "bounce0/merge_intersections") break;
        StageView spoiled = stage.view;
        if (stage.view.name == "bounce0/level1/intersect")
            std::erase_if(spoiled.outputs, [](auto& b) { return b.name == "child_counts"; });
        checker.on_stage(spoiled);
    }
    CHECK_FALSE(checker.failures().empty());
    checker.on_retry("bounce0/merge_intersections", "the buffer had 1 slot");
    CHECK(checker.failures().empty());
    CHECK(checker.counts().failures == 0);
    bool counts = false;
    for (const StageCopy& stage : run.stages.all()) {
        counts = counts || stage.view.name == "bounce0/level0/scan_counts";
        if (counts) checker.on_stage(stage.view);
    }
    CHECK(checker.failures().empty());
    CHECK(checker.counts().retries == 1);
}

TEST_CASE("scan: a wrong block offset is found at its node", "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/level1/scan_counts");
    stage.output<std::uint32_t>("block_offsets")[2] += 1;
    const Failure failure = first(run.check(), invariant::kScan);
    CHECK(failure.stage == "bounce0/level1/scan_counts");
    CHECK(failure.launch == stage.view.launch);
    CHECK(failure.level == 1);
    CHECK(failure.node == run.first_node(1) + 2);
    CHECK(failure.field == "block_offsets[2]");
}

TEST_CASE("scan: a wrong child region is found at its child", "[verify][invariants]") {
    Run run(small_parameters());
    run.stages.at("bounce0/light0/level0/scan_counts").output<std::uint32_t>("child_offsets")[1] -=
        1;
    const Failure failure = first(run.check(), invariant::kScan);
    CHECK(failure.stage == "bounce0/light0/level0/scan_counts");
    CHECK(failure.node == run.first_node(1) + 1);
}

TEST_CASE("hand-over: a level that reads another queue than the one written is found",
          "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/level2/intersect");
    const auto counts = stage.input<std::uint32_t>("node_counts");
    const auto offsets = stage.input<std::uint32_t>("queue_offsets");
    std::uint32_t node = 0;
    while (counts[node] < 2) ++node;
    auto queue = stage.input<std::uint32_t>("queue");
    std::swap(queue[offsets[node]], queue[offsets[node] + 1]);
    const Failure failure = first(run.check(), invariant::kHandOver);
    CHECK(failure.stage == "bounce0/level2/intersect");
    CHECK(failure.node == run.first_node(2) + node);
    CHECK(failure.field == "queue[" + std::to_string(offsets[node]) + "]");
}

TEST_CASE("hand-over: rays that change on their way into a traversal are found",
          "[verify][invariants]") {
    Run run(small_parameters());
    run.stages.at("bounce1/level0/intersect_root").input<Ray>("rays")[17].t_max = 3.0f;
    const Failure failure = first(run.check(), invariant::kHandOver);
    CHECK(failure.stage == "bounce1/level0/intersect_root");
    CHECK(failure.ray == 17);
}

TEST_CASE("hand-over: a traversal that ends while rays wait in a queue is found",
          "[verify][invariants]") {
    Run run(small_parameters());
    InvariantChecker checker(spheres(), run.bvh, run.parameters);
    for (const StageCopy& stage : run.stages.all()) {
        if (stage.view.bounce == 0 && stage.view.light == kNotApplicable &&
            stage.view.level != kNotApplicable && stage.view.level >= 2) {
            continue;  // left out
        }
        checker.on_stage(stage.view);
    }
    const Failure failure = first(checker.failures(), invariant::kHandOver);
    CHECK(failure.stage == "bounce0/merge_intersections");
    CHECK(failure.level == 2);
    CHECK(failure.node >= run.first_node(2));
}

TEST_CASE("slot-written-once: a reserved slot that was never written is found",
          "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/level1/intersect");
    const std::uint32_t child = child_with(stage, 3);
    const std::uint32_t begin = stage.input<std::uint32_t>("child_offsets")[child];
    stage.output<std::uint32_t>("child_queue")[begin + 1] = 0xcdcdcdcd;
    const Failure failure = first(run.check(), invariant::kSlotWrittenOnce);
    CHECK(failure.stage == "bounce0/level1/intersect");
    CHECK(failure.launch == stage.view.launch);
    CHECK(failure.node == run.bvh.parents[run.first_node(2) + child]);
    CHECK(failure.ray == 0xcdcdcdcd);
}

TEST_CASE("slot-written-once: more pushes than a node's region has room for are found",
          "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/level1/intersect");
    const auto offsets = stage.input<std::uint32_t>("child_offsets");
    const std::uint32_t child = child_with(stage, 1);
    stage.output<std::uint32_t>("child_counts")[child] = offsets[child + 1] - offsets[child] + 1;
    const Failure failure = first(run.check(), invariant::kSlotWrittenOnce);
    CHECK(failure.stage == "bounce0/level1/intersect");
    CHECK(failure.node == run.bvh.parents[run.first_node(2) + child]);
}

TEST_CASE("slot-written-once: more hits than a ray has slots are found", "[verify][invariants]") {
    Run run(small_parameters());
    run.stages.at("bounce0/level3/intersect").output<std::uint32_t>("hit_counts")[5] = 1000;
    const Failure failure = first(run.check(), invariant::kSlotWrittenOnce);
    CHECK(failure.stage == "bounce0/level3/intersect");
    CHECK(failure.ray == 5);
}

TEST_CASE("no-duplicate: a ray that is in a queue twice is found", "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/level0/intersect_root");
    const std::uint32_t child = child_with(stage, 3);
    const std::uint32_t begin = stage.input<std::uint32_t>("child_offsets")[child];
    auto queue = stage.output<std::uint32_t>("child_queue");
    const std::uint32_t lost = queue[begin + 2];
    queue[begin + 2] = queue[begin];
    const auto failures = run.check();
    const Failure twice = first(failures, invariant::kNoDuplicate);
    CHECK(twice.stage == "bounce0/level0/intersect_root");
    CHECK(twice.node == 0);
    CHECK(twice.ray == queue[begin]);
    CHECK(twice.block == queue[begin] / 32);
    CHECK(first(failures, invariant::kRequiredPresent).ray == lost);
}

TEST_CASE("nothing-extra: a ray in the queue of a box that it does not enter is found",
          "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/level1/intersect");
    const auto offsets = stage.input<std::uint32_t>("child_offsets");
    const auto counts = stage.output<std::uint32_t>("child_counts");
    auto queue = stage.output<std::uint32_t>("child_queue");
    std::uint32_t child = 0;  // one with a free slot: not all of the parent's rays enter it
    while (counts[child] == 0 || offsets[child] + counts[child] == offsets[child + 1]) ++child;
    const std::uint32_t parent = run.bvh.parents[run.first_node(2) + child] - run.first_node(1);
    const auto parents = stage.input<std::uint32_t>("queue").subspan(
        stage.input<std::uint32_t>("queue_offsets")[parent],
        stage.input<std::uint32_t>("node_counts")[parent]);
    const auto pushed = queue.subspan(offsets[child], counts[child]);
    const auto outsider = std::find_if(parents.begin(), parents.end(), [&](std::uint32_t ray) {
        return std::find(pushed.begin(), pushed.end(), ray) == pushed.end();
    });
    REQUIRE(outsider != parents.end());
    queue[offsets[child] + counts[child]] = *outsider;
    counts[child] += 1;
    const auto failures = run.check();
    const Failure extra = first(failures, invariant::kNothingExtra);
    CHECK(extra.stage == "bounce0/level1/intersect");
    CHECK(extra.node == run.first_node(1) + parent);
    CHECK(extra.ray == *outsider);
    CHECK(first(failures, invariant::kCountEqualsPushes).node == run.first_node(1) + parent);
}

TEST_CASE("required-present: a ray that was not pushed is found, with its node and block",
          "[verify][invariants]") {
    for (const EarlyOut early_out : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
        PipelineParameters p = small_parameters();
        p.early_out = early_out;
        Run run(p);
        auto& stage = run.stages.at("bounce0/level0/intersect_root");
        const std::uint32_t child = child_with(stage, 2);
        const std::uint32_t begin = stage.input<std::uint32_t>("child_offsets")[child];
        auto& count = stage.output<std::uint32_t>("child_counts")[child];
        const std::uint32_t lost = stage.output<std::uint32_t>("child_queue")[begin + count - 1];
        count -= 1;
        const auto failures = run.check();
        const Failure missing = first(failures, invariant::kRequiredPresent);
        CHECK(missing.stage == "bounce0/level0/intersect_root");
        CHECK(missing.level == 0);
        CHECK(missing.node == 0);
        CHECK(missing.ray == lost);
        CHECK(missing.block == lost / 32);
        if (early_out != EarlyOut::immediate) {
            CHECK(first(failures, invariant::kCountEqualsPushes).expected ==
                  std::to_string(count + 1));
        }
    }
}

TEST_CASE("required-present: under immediate, a ray culled by a distance that it never had",
          "[verify][invariants]") {
    PipelineParameters p = small_parameters();
    p.early_out = EarlyOut::immediate;
    Run run(p);
    // The minimum is spoiled with it, so that only the final hit can tell.
    auto& stage = run.stages.at("bounce0/level0/intersect_root");
    const std::uint32_t child = child_with(stage, 2);
    const std::uint32_t begin = stage.input<std::uint32_t>("child_offsets")[child];
    auto& count = stage.output<std::uint32_t>("child_counts")[child];
    const std::uint32_t lost = stage.output<std::uint32_t>("child_queue")[begin + count - 1];
    count -= 1;
    stage.input<float>("minimum")[lost] = -1.0f;
    const auto failures = run.check();
    const Failure minimum = first(failures, invariant::kMinimum);
    CHECK(minimum.ray == lost);
    const Failure missing = first(failures, invariant::kRequiredPresent);
    CHECK(missing.stage == "bounce0/merge_intersections");
    CHECK(missing.launch == stage.view.launch);
    CHECK(missing.ray == lost);
    CHECK(missing.node == run.first_node(1) + child);
}

TEST_CASE("conservation: a ray that is neither pushed nor missed nor culled is found",
          "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/level0/intersect_root");
    const auto offsets = stage.input<std::uint32_t>("child_offsets");
    const auto counts = stage.output<std::uint32_t>("child_counts");
    auto queue = stage.output<std::uint32_t>("child_queue");
    const std::uint32_t lost = queue[offsets[child_with(stage, 1)]];
    for (std::uint32_t child = 0; child < counts.size(); ++child) {
        const auto begin = queue.begin() + offsets[child];
        const auto end = std::remove(begin, begin + counts[child], lost);
        counts[child] = static_cast<std::uint32_t>(end - begin);
    }
    const Failure failure = first(run.check(), invariant::kConservation);
    CHECK(failure.stage == "bounce0/level0/intersect_root");
    CHECK(failure.node == 0);
    CHECK(failure.expected == "286 in");
}

TEST_CASE("leaf hits: below the queues a ray's closest hit counts, and no other",
          "[verify][invariants]") {
    for (const std::uint32_t levels : {1u, 2u}) {
        for (const HitMode mode : {HitMode::buffer, HitMode::packed}) {
            PipelineParameters p = small_parameters();
            p.queue_levels = levels;
            p.hit_mode = mode;
            p.early_out = EarlyOut::off;
            Run run(p);
            CAPTURE(levels, to_string(mode));
            CHECK(run.check().empty());
            const std::string name =
                levels == 1 ? "bounce0/level0/intersect_root" : "bounce0/level1/intersect";
            auto& stage = run.stages.at(name);
            std::size_t ray = 0;
            if (mode == HitMode::packed) {
                const auto packed = stage.output<std::uint64_t>("packed_hits");
                while (packed[ray] == ~std::uint64_t{0}) ++ray;
                packed[ray] += std::uint64_t{1} << 32;  // a unit in the last place farther
            } else {
                const auto counts = stage.output<std::uint32_t>("hit_counts");
                while (counts[ray] == 0) ++ray;
                auto& hit = stage.output<HitCandidate>("hits")[ray * p.hit_capacity];
                hit.t = std::nextafter(hit.t, kInfinity);
            }
            const Failure failure = first(run.check(), invariant::kLeafHits);
            CHECK(failure.stage == name);
            CHECK(failure.ray == ray);
        }
    }
}

TEST_CASE("conservation: a leaf's hit that was not appended is found by the sum and by the ray",
          "[verify][invariants]") {
    Run run(small_parameters());
    for (StageCopy& stage : run.stages.all()) {
        if (stage.view.kind != StageKind::intersect) continue;
        auto counts = stage.output<std::uint32_t>("hit_counts");
        const auto ray = std::find_if(counts.begin(), counts.end(), [](auto c) { return c != 0; });
        if (ray == counts.end()) continue;
        *ray -= 1;
        const auto failures = run.check();
        const Failure lost = first(failures, invariant::kLeafHits);
        CHECK(lost.stage == stage.view.name);
        CHECK(lost.ray == ray - counts.begin());
        CHECK(is_leaf(run.bvh.node_refs[lost.node]));
        CHECK(lost.block != kNotApplicable);
        CHECK(first(failures, invariant::kConservation).stage == stage.view.name);
        return;
    }
    FAIL("no leaf was hit");
}

TEST_CASE("input-order: two neighbours of one block's run exchanged are found",
          "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/level0/intersect_root");
    const auto offsets = stage.input<std::uint32_t>("child_offsets");
    const auto counts = stage.output<std::uint32_t>("child_counts");
    auto queue = stage.output<std::uint32_t>("child_queue");
    for (std::uint32_t child = 0; child < counts.size(); ++child) {
        for (std::uint32_t i = 0; i + 1 < counts[child]; ++i) {
            std::uint32_t& a = queue[offsets[child] + i];
            std::uint32_t& b = queue[offsets[child] + i + 1];
            if (a / 32 != b / 32) continue;
            std::swap(a, b);
            const Failure failure = first(run.check(), invariant::kInputOrder);
            CHECK(failure.stage == "bounce0/level0/intersect_root");
            CHECK(failure.block == a / 32);
            CHECK(failure.ray == b);
            return;
        }
    }
    FAIL("no block pushed two rays");
}

TEST_CASE("input-order: a block's run that is torn apart is found", "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/level0/intersect_root");
    const auto offsets = stage.input<std::uint32_t>("child_offsets");
    const auto counts = stage.output<std::uint32_t>("child_counts");
    auto queue = stage.output<std::uint32_t>("child_queue");
    std::uint32_t child = 0;
    // Two entries of the first block, and others of another.
    const auto fits = [&](std::uint32_t c) {
        const std::uint32_t* ids = &queue[offsets[c]];
        return counts[c] > 2 && ids[0] / 32 == ids[1] / 32 &&
               ids[0] / 32 != ids[counts[c] - 1] / 32;
    };
    while (!fits(child)) REQUIRE(++child < counts.size());
    // The first entry goes behind the last: its block's others stay in front.
    const auto region = queue.subspan(offsets[child], counts[child]);
    const std::uint32_t moved = region[0];
    std::rotate(region.begin(), region.begin() + 1, region.end());
    const Failure failure = first(run.check(), invariant::kInputOrder);
    CHECK(failure.ray == moved);
    CHECK(failure.block == moved / 32);
}

TEST_CASE("leaf-hits: a hit that no leaf has, and a wrong distance, are found",
          "[verify][invariants]") {
    for (const HitMode mode : {HitMode::buffer, HitMode::packed}) {
        PipelineParameters p = small_parameters();
        p.hit_mode = mode;
        Run run(p);
        for (StageCopy& stage : run.stages.all()) {
            if (stage.view.kind != StageKind::intersect) continue;
            std::uint32_t ray = kNotApplicable;
            if (mode == HitMode::buffer) {
                const auto counts = stage.output<std::uint32_t>("hit_counts");
                for (std::uint32_t r = 0; r < counts.size() && ray == kNotApplicable; ++r) {
                    if (counts[r] != 0) ray = r;
                }
                if (ray == kNotApplicable) continue;
                stage.output<HitCandidate>("hits")[ray * p.hit_capacity].t *= 1.0000002f;
            } else {
                const auto packed = stage.output<std::uint64_t>("packed_hits");
                for (std::uint32_t r = 0; r < packed.size() && ray == kNotApplicable; ++r) {
                    if (packed[r] != ~std::uint64_t{0}) ray = r;
                }
                if (ray == kNotApplicable) continue;
                packed[ray] += std::uint64_t{1} << 32;
            }
            const Failure failure = first(run.check(), invariant::kLeafHits);
            CHECK(failure.stage == stage.view.name);
            CHECK(failure.ray == ray);
            break;
        }
    }
}

TEST_CASE("minimum: one that rises, and one that is not the nearest hit, are found",
          "[verify][invariants]") {
    for (const float factor : {2.0f, 0.5f}) {
        Run run(small_parameters());
        for (StageCopy& stage : run.stages.all()) {
            if (stage.view.kind != StageKind::publish_minimum) continue;
            const auto minimum = stage.output<float>("minimum");
            const auto ray = std::find_if(minimum.begin(), minimum.end(),
                                          [](float t) { return t > 0.0f && t < kInfinity; });
            if (ray == minimum.end()) continue;
            *ray *= factor;
            const Failure failure = first(run.check(), invariant::kMinimum);
            CHECK(failure.stage == stage.view.name);
            CHECK(failure.ray == ray - minimum.begin());
            break;
        }
    }
}

TEST_CASE("merge: a hit that is not the closest of those gathered is found",
          "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/merge_intersections");
    const auto merged = stage.output<Hit>("merged");
    const auto hit =
        std::find_if(merged.begin(), merged.end(), [](const Hit& h) { return is_hit(h); });
    REQUIRE(hit != merged.end());
    SECTION("another distance") { hit->t *= 1.0000002f; }
    SECTION("another barycentric") { hit->u += 1e-6f; }
    SECTION("lost") { *hit = no_hit(); }
    const Failure failure = first(run.check(), invariant::kMerge);
    CHECK(failure.stage == "bounce0/merge_intersections");
    CHECK(failure.ray == hit - merged.begin());
}

TEST_CASE("resolve-light: light through something, and light withheld, are found",
          "[verify][invariants]") {
    for (const bool blocked : {true, false}) {
        Run run(small_parameters());
        auto& stage = run.stages.at("bounce0/light0/resolve_light");
        const auto hits = stage.input<Hit>("shadow_hits");
        const auto rays = stage.input<Ray>("shadow_rays");
        const auto potential = stage.input<Vec3>("potential");
        const auto radiance = stage.output<Vec3>("radiance");
        std::uint32_t ray = 0;
        while (is_dead(rays[ray]) || is_hit(hits[ray]) != blocked) ++ray;
        radiance[ray] += blocked ? potential[ray] : -potential[ray];
        const Failure failure = first(run.check(), invariant::kResolveLight);
        CHECK(failure.stage == "bounce0/light0/resolve_light");
        CHECK(failure.ray == ray);
    }
}

TEST_CASE("ray-record: a living ray whose direction is not of unit length is found",
          "[verify][invariants]") {
    for (const auto& [name, buffer] :
         {std::pair{"primary_rays", "rays"}, std::pair{"bounce0/scene_rays", "rays"},
          std::pair{"bounce0/light0/direct_light_rays", "shadow_rays"}}) {
        Run run(small_parameters());
        const auto rays = run.stages.at(name).output<Ray>(buffer);
        const auto ray =
            std::find_if(rays.begin(), rays.end(), [](const Ray& r) { return !is_dead(r); });
        REQUIRE(ray != rays.end());
        ray->direction *= 1.01f;
        const Failure failure = first(run.check(), invariant::kRayRecord);
        CHECK(failure.stage == name);
        CHECK(failure.ray == ray - rays.begin());
    }
}

TEST_CASE("path-state: a path that lives on without a ray is found", "[verify][invariants]") {
    Run run(small_parameters());
    const auto rays = run.stages.at("bounce1/scene_rays").output<Ray>("rays");
    const auto flags = run.stages.at("bounce1/scene_rays").output<std::uint32_t>("flags");
    REQUIRE(is_dead(rays[3]));
    flags[3] |= kPathAlive;
    const Failure failure = first(run.check(), invariant::kPathState);
    CHECK(failure.stage == "bounce1/scene_rays");
    CHECK(failure.ray == 3);
}

TEST_CASE("pixels: a pixel that was not written is found", "[verify][invariants]") {
    Run run(small_parameters());
    run.stages.at("reconstruct_image").output<Vec3>("image")[30] = Vec3(0.125f);
    const Failure failure = first(run.check(), invariant::kPixels);
    CHECK(failure.stage == "reconstruct_image");
    CHECK(failure.field == "image[30] (x 4, y 2)");
}

TEST_CASE("pixels: a sample that is generated twice is found", "[verify][invariants]") {
    Run run(small_parameters());
    run.stages.at("primary_rays").output<std::uint32_t>("sample")[9] = 0;
    const Failure failure = first(run.check(), invariant::kPixels);
    CHECK(failure.stage == "primary_rays");
    CHECK(failure.ray == 9);
}

TEST_CASE("non-finite: any such value is found, counted, and comes first of its launch",
          "[verify][invariants]") {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    struct Case {
        const char* stage;
        std::function<void(StageCopy&)> spoil;
        std::uint32_t ray;
    };
    const std::vector<Case> cases{
        {"primary_rays", [&](auto& s) { s.template output<Ray>("rays")[4].origin.y = nan; }, 4},
        {"primary_rays", [&](auto& s) { s.template output<Vec3>("throughput")[6].x = kInfinity; },
         6},
        {"bounce0/merge_intersections",
         [&](auto& s) {
             s.template output<Hit>("merged")[7] = {nan, 3, 0, 0};
         },
         7},
        {"bounce0/light0/resolve_light",
         [&](auto& s) { s.template output<Vec3>("radiance")[8].z = nan; }, 8},
        {"bounce0/scene_rays",
         [&](auto& s) { s.template output<Vec3>("radiance")[2].z = -kInfinity; }, 2},
        {"bounce0/level2/publish_minimum",
         [&](auto& s) { s.template output<float>("minimum")[1] = nan; }, 1},
        {"reconstruct_image", [&](auto& s) { s.template output<Vec3>("image")[5].y = nan; },
         kNotApplicable}};
    for (const Case& spoiled : cases) {
        Run run(small_parameters());
        spoiled.spoil(run.stages.at(spoiled.stage));
        InvariantChecker checker(spheres(), run.bvh, run.parameters);
        run.stages.show_to(checker);
        INFO(spoiled.stage);
        REQUIRE_FALSE(checker.failures().empty());
        const Failure& failure = checker.failures().front();
        CHECK(failure.invariant == invariant::kNonFinite);
        CHECK(failure.stage == spoiled.stage);
        CHECK(failure.ray == spoiled.ray);
        CHECK(checker.counts().non_finite >= 1);
    }
}

TEST_CASE("invariants: a stage pattern leaves the other stages unjudged", "[verify][invariants]") {
    Run run(small_parameters());
    run.stages.at("bounce0/level1/scan_counts").output<std::uint32_t>("block_offsets")[1] += 7;
    CHECK_FALSE(run.check({.stage_pattern = "bounce0/level1/*"}).empty());
    CHECK(run.check({.stage_pattern = "bounce1/light0/level?/intersect"}).empty());
    InvariantChecker checker(spheres(), run.bvh, run.parameters,
                             {.stage_pattern = "no such stage"});
    run.stages.show_to(checker);
    CHECK(checker.counts().stages == 0);
}

TEST_CASE("failures: the sentence carries launch, stage, node, block, ray and both values",
          "[verify][failure]") {
    Failure failure;
    failure.invariant = "scan";
    failure.stage = "bounce0/level3/scan_counts";
    failure.launch = 12;
    failure.level = 3;
    failure.node = 40;
    failure.block = 7;
    failure.ray = 1234;
    failure.field = "block_offsets[2]";
    failure.expected = "5";
    failure.found = "6";
    failure.sentence = "not a scan";
    CHECK(to_string(failure) ==
          "[scan] launch 12 bounce0/level3/scan_counts, node 40, block 7, ray 1234: not a scan "
          "(block_offsets[2]: expected 5, found 6)");
    CHECK(verify::exact(1.5f) == "0x1.8p+0 (1.5)");
}

TEST_CASE("stage patterns: part of a name, or stars and question marks for all of it",
          "[verify][failure]") {
    using verify::stage_matches;
    CHECK(stage_matches("", "bounce0/level1/intersect"));
    CHECK(stage_matches("level1", "bounce0/level1/intersect"));
    CHECK(stage_matches("bounce?/*/intersect", "bounce0/light1/level1/intersect"));
    CHECK_FALSE(stage_matches("level?", "bounce0/level1/intersect"));
    CHECK_FALSE(stage_matches("level2", "bounce0/level1/intersect"));
    CHECK(stage_matches("*", "x"));
}

}  // namespace
