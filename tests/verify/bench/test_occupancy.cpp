#include <nlohmann/json.hpp>

#include "emulation/host/pipeline.h"
#include "reference/base/error.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/small_parameters.h"
#include "tests/verify/stage_copies.h"
#include "verify/bench/bench_occupancy.h"
#include "verify/bench/measure.h"
#include "verify/bench/occupancy_counter.h"
#include "verify/capture/capture_format.h"

namespace {

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::Ray;
using reference::Vec3;
using verify::Occupancy;
using verify::TraversalCounts;

/// Two right triangles, in the planes z = 1 and z = 2: a root with two leaves.
reference::Scene two_triangles() {
    reference::Scene scene;
    scene.vertices = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {0, 0, 2}, {1, 0, 2}, {0, 1, 2}};
    scene.triangles = {{0, 1, 2}, {3, 4, 5}};
    scene.material_of = {0, 0};
    scene.materials.emplace_back();
    return scene;
}

/// Through both triangles; through both boxes only; past both; dead; from between the two.
std::vector<Ray> five_rays() {
    const auto along_z = [](float x, float y, float z) {
        return Ray{Vec3(x, y, z), 0.0f, Vec3(0, 0, 1), reference::kInfinity};
    };
    return {along_z(0.1f, 0.1f, 0.0f), along_z(0.9f, 0.9f, 0.0f), along_z(5.0f, 5.0f, 0.0f),
            reference::dead_ray(), along_z(0.1f, 0.1f, 1.5f)};
}

reference::PipelineParameters plain() {
    reference::PipelineParameters p;
    p.width = 2;
    p.rays_per_block = 32;
    p.max_leaf_size = 1;
    p.early_out = reference::EarlyOut::off;
    return p;
}

Occupancy count_five(const reference::PipelineParameters& p) {
    const reference::Scene scene = two_triangles();
    const reference::WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 1));
    verify::OccupancyCounter counter(bvh, p);
    const std::vector<Ray> rays = five_rays();
    std::vector<reference::Hit> hits(rays.size());
    emulation::Pipeline(scene, bvh, p, {1}, &counter)
        .trace(rays, reference::TraversalKind::closest, hits);
    return counter.result();
}

TEST_CASE("occupancy: five rays in a root with two leaves, counted by hand", "[verify][bench]") {
    const Occupancy counted = count_five(plain());
    REQUIRE(counted.levels.size() == 2);
    const TraversalCounts& root = counted.levels[0];
    CHECK(root.visits == 4);
    CHECK(root.dead == 1);
    CHECK(root.blocks == 1);
    CHECK(root.warps == 1);
    CHECK(root.fill[5] == 1);
    CHECK(root.box_tests == 5 * 2);
    CHECK(root.triangle_tests == 0);
    CHECK(root.redundant == 0);
    CHECK(root.traffic.queues == 4 * 5);  // five entries written, none read
    CHECK(root.traffic.rays == 5 * 32);
    CHECK(root.traffic.nodes == 4 + sizeof(reference::WideNode<2>));
    CHECK(root.traffic.triangles == 0);

    const TraversalCounts& leaves = counted.levels[1];
    CHECK(leaves.visits == 2 + 3);
    CHECK(leaves.dead == 0);
    CHECK(leaves.blocks == 2);
    CHECK(leaves.warps == 2);
    CHECK(leaves.fill[2] == 1);
    CHECK(leaves.fill[3] == 1);
    CHECK(leaves.fill_quantile(0.5) == 2);
    CHECK(leaves.fill_quantile(0.51) == 3);
    CHECK(leaves.triangle_tests == 5);
    CHECK(leaves.redundant == 1);  // the first ray in the farther leaf
    CHECK(leaves.leaf_hits == 3);
    CHECK(leaves.traffic.queues == 4 * 5);
    CHECK(leaves.traffic.rays == 5 * 32);
    CHECK(leaves.traffic.nodes == 2 * (4 + 8));
    CHECK(leaves.traffic.triangles == 2 * 40);
    CHECK(leaves.traffic.hits == 3 * 16);

    CHECK(counted.all.rays == 4);
    CHECK(counted.all.hits == 2);
    CHECK(counted.all.visits == 9);
    CHECK(counted.all.blocks == 3);
    CHECK(counted.all.traffic.hits == 3 * 16 + 5 * 20 + 3 * 8 + 2 * 80);
    REQUIRE(counted.kinds.size() == 1);
    CHECK(counted.kinds[0].name == "given");
    CHECK(counted.rays_in_flight == 5);
    CHECK(counted.triangle_bytes == 2 * 40);

    const nlohmann::json all = to_json(counted)["all"];
    CHECK(all["rays_per_block"]["mean"].get<double>() == Approx(10.0 / 3));
    CHECK(all["active_lanes"]["of_blocks"].get<double>() == Approx(10.0 / 96));
    CHECK(all["active_lanes"]["of_warps"].get<double>() == Approx(10.0 / 96));
    CHECK(all["traffic_bytes"]["all"] == counted.all.traffic.total());
}

TEST_CASE("occupancy: blocks fill up, and a warp without rays is not counted", "[verify][bench]") {
    reference::PipelineParameters p = plain();
    p.rays_per_block = 64;
    const reference::Scene scene = two_triangles();
    const reference::WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 1));
    verify::OccupancyCounter counter(bvh, p);
    const std::vector<Ray> rays(64 + 33, five_rays()[2]);
    std::vector<reference::Hit> hits(rays.size());
    emulation::Pipeline(scene, bvh, p, {1}, &counter)
        .trace(rays, reference::TraversalKind::closest, hits);
    CHECK(counter.result().all.blocks == 2);
    CHECK(counter.result().all.warps == 4);
    emulation::Pipeline(scene, bvh, p, {1}, &counter)
        .trace(std::span(rays).first(20), reference::TraversalKind::closest,
               std::span(hits).first(20));
    const Occupancy counted = counter.result();
    CHECK(counted.all.blocks == 3);
    CHECK(counted.all.warps == 5);
    CHECK(counted.all.fill[64] == 1);
    CHECK(counted.all.fill[33] == 1);
    CHECK(counted.all.fill[20] == 1);
    CHECK(counted.all.visits == 117);
}

TEST_CASE("occupancy: an early-out adds the bytes of minima", "[verify][bench]") {
    reference::PipelineParameters p = plain();
    p.early_out = reference::EarlyOut::level;
    const Occupancy counted = count_five(p);
    CHECK(counted.all.visits == 9);  // both leaves are of one level: nothing to save yet
    CHECK(counted.levels[0].traffic.rays == 5 * 36);
    CHECK(counted.levels[0].traffic.hits == 5 * 8);
    CHECK(counted.levels[1].traffic.hits == 3 * 24 + 5 * 8);
}

TEST_CASE("occupancy: a walk below the queues is counted node by node", "[verify][bench]") {
    reference::PipelineParameters p = plain();
    p.queue_levels = 1;
    const Occupancy counted = count_five(p);
    REQUIRE(counted.levels.size() == 1);
    CHECK(counted.all.visits == 4);
    CHECK(counted.all.box_tests == 5 * 2);
    // The first ray stops at the nearer triangle, the second tries both, the last the farther one.
    CHECK(counted.all.triangle_tests == 1 + 2 + 1);
    CHECK(counted.all.traffic.triangles == 4 * 40);
    // A ray reads six planes of two children; three rays have children to go on to or put aside.
    CHECK(counted.all.traffic.nodes == 4 + 5 * (24 + 6 * 2 * 4) + 4 * (2 + 2 + 1));
    CHECK(counted.all.leaf_hits == 2);
}

TEST_CASE("occupancy: queues that lose a ray, or a level that is left out, are seen",
          "[verify][bench]") {
    const reference::PipelineParameters p = plain();
    const reference::Scene scene = two_triangles();
    const reference::WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 1));
    verify::test::StageCopies copies;
    const std::vector<Ray> rays = five_rays();
    std::vector<reference::Hit> hits(rays.size());
    emulation::Pipeline(scene, bvh, p, {1}, &copies)
        .trace(rays, reference::TraversalKind::closest, hits);
    verify::test::StageCopy& root = copies.at("trace/level0/intersect_root");
    verify::test::StageCopy& leaves = copies.at("trace/level1/intersect");
    {
        verify::OccupancyCounter counter(bvh, p);
        counter.on_stage(root.view);
        leaves.input<std::uint32_t>("node_counts")[0] -= 1;
        CHECK_THROWS_WITH(counter.on_stage(leaves.view),
                          ContainsSubstring("level1/intersect: 4 entries in its queues, 5 pushed"));
        leaves.input<std::uint32_t>("node_counts")[0] += 1;
    }
    {
        verify::OccupancyCounter counter(bvh, p);
        CHECK_THROWS_AS(counter.on_stage(leaves.view), reference::Error);
    }
    {
        verify::OccupancyCounter counter(bvh, p);
        root.input<std::uint32_t>("node_counts")[0] = 4;
        CHECK_THROWS_WITH(counter.on_stage(root.view),
                          ContainsSubstring("4 entries in its queues, 5"));
    }
}

TEST_CASE("occupancy: a traversal that is run again counts once", "[verify][bench]") {
    reference::PipelineParameters p = plain();
    p.hit_capacity = 1;  // the first ray has two hits
    CHECK(count_five(p).all.visits == 9);
    CHECK(count_five(p).all.leaf_hits == 3);
    CHECK(count_five(p).all.blocks == 3);
}

TEST_CASE("occupancy: a render's counts are those of its launches, on every tier",
          "[verify][bench]") {
    const reference::Scene scene = scenes::load_scene("spheres");
    reference::PipelineParameters p = scotty::test::small_picture(24, 16);
    p.width = 4;
    p.hit_mode = reference::HitMode::packed;
    const reference::WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 1));
    const Occupancy counted = verify::count_occupancy(scene, bvh, p, 1);
    const auto pipeline = verify::make_pipeline_of("emulator", scene, bvh, p, 1);
    pipeline->render();
    std::uint64_t items = 0;
    std::uint64_t blocks = 0;
    for (const reference::LaunchRecord& launch : pipeline->launches()) {
        if (!is_level_kernel(launch.kind)) continue;
        items += launch.items;
        blocks += launch.blocks;
    }
    CHECK(counted.all.lanes() == items);
    CHECK(counted.all.blocks == blocks);
    CHECK(counted.kinds.size() == 3);
    CHECK(counted.all.visits < counted.all.visits_uncut);
    std::uint64_t by_level = 0;
    for (const TraversalCounts& level : counted.levels) {
        by_level += level.visits;
        CHECK(level.visits <= level.visits_uncut);
        CHECK(level.redundant <= level.visits);
    }
    CHECK(by_level == counted.all.visits);

    reference::PipelineParameters buffered = p;
    buffered.hit_mode = reference::HitMode::buffer;
    verify::OccupancyCounter simt(bvh, buffered);
    verify::make_pipeline_of("simt", scene, bvh, buffered, 1, false, &simt)->render();
    nlohmann::json theirs = to_json(simt.result());
    nlohmann::json ours = to_json(counted);
    for (nlohmann::json* counts : {&theirs, &ours}) {
        for (auto& row : (*counts)["levels"]) {
            row.erase("visits_with_early_out_off");
            row.erase("visits_saved");
        }
    }
    CHECK(theirs["levels"] == ours["levels"]);
    CHECK_THAT(table(counted), ContainsSubstring("bounce 1") && ContainsSubstring("level 2") &&
                                   ContainsSubstring("all"));
}

TEST_CASE("occupancy: with early-out off nothing is saved", "[verify][bench]") {
    const reference::Scene scene = scenes::load_scene("cornell");
    reference::PipelineParameters p;
    p.image_width = 8;
    p.image_height = 8;
    p.spp = 1;
    p.early_out = reference::EarlyOut::off;
    const reference::WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 1));
    const Occupancy counted = verify::count_occupancy(scene, bvh, p, 1);
    CHECK(counted.all.visits == counted.all.visits_uncut);
    CHECK(to_json(counted)["all"]["visits_saved"] == 0.0);
    CHECK(to_json(counted)["depends_on_schedule"] == false);
}

}  // namespace
