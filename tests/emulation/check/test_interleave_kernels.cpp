/// Runs every kernel of gpu/ in few small blocks, in every order in which these can touch memory.
#include <map>

#include "emulation/simt/cuda/cuda_runtime.h"
#include "emulation/simt/interleave/replayer.h"
#include "gpu/kernels/clear_traversal.h"
#include "gpu/kernels/scan_counts.h"
#include "tests/emulation/simt/executor_tools.h"
#include "tests/reference/meshes.h"
#include "tests/verify/capture_tools.h"
#include "verify/backends/simt/simt_interleave.h"
#include "verify/capture/canonical.h"
#include "verify/capture/failure.h"
#include "verify/capture/replay_inputs.h"

namespace {

using namespace scotty;
using namespace scotty::emulation::simt;
using namespace scotty::verify::test;
using reference::PipelineParameters;
using reference::StageKind;

/// Explores one stage of a capture.
Exploration explore_stage(const verify::Capture& capture, const verify::StageRecord& record,
                          const verify::PipelineInput& input, const ExploreOptions& options) {
    const verify::LoadedStage prepared = verify::prepare_stage(capture, record);
    const auto canonical = [&](const std::vector<reference::OwnedBuffer>& outputs) {
        return verify::canonical_outcome(prepared.view, outputs, input.parameters);
    };
    return simt::explore_simt_stage(
        {input.scene, input.bvh, input.parameters, prepared.view, canonical}, options);
}

PipelineParameters few_rays(std::uint32_t width, std::uint32_t height) {
    PipelineParameters p = small_parameters();
    p.width = 2;
    p.image_width = width;
    p.image_height = height;
    p.spp = 1;
    return p;
}

/// For each stage kind, the stage that took most schedules, all of them run.
struct Exhausted {
    std::string stage;
    std::uint64_t schedules = 0;
    std::uint64_t words = 0;
};
using Tally = std::map<std::string, Exhausted>;

/// Triangles behind each other that fill the picture, one per leaf: every ray is in every leaf.
verify::PipelineInput stack_input(const PipelineParameters& p, int triangles) {
    verify::PipelineInput input;
    input.scene.name = "stack";
    input.scene.materials.emplace_back();
    for (int i = 0; i < triangles; ++i) {
        const auto z = static_cast<float>(-2 - i);
        reference::test::add_triangle(input.scene, {-90.0f, -90.0f, z}, {90.0f, -90.0f, z},
                                      {0.0f, 90.0f, z});
    }
    input.parameters = p;
    input.bvh = build_wide_bvh(input.scene, bvh_parameters(p, 1));
    return input;
}

/// Explores all stages of a tiny run that have 2 to 4 blocks.
void explore_all(const verify::PipelineInput& input, const ExploreOptions& options, Tally& tally,
                 const std::string& pattern, const std::string& kind = "") {
    const TemporaryFolder folder;
    {
        verify::CaptureWriter writer(
            folder / "c", verify::header_of("emulator", input.scene, input.bvh, input.parameters),
            {});
        verify::write_pipeline_input(writer.input_folder(), input.scene, input.bvh,
                                     input.parameters);
        emulation::Pipeline(input.scene, input.bvh, input.parameters, {1}, &writer).render();
        writer.finish();
    }
    const verify::Capture capture = verify::Capture::open(folder / "c");
    for (const verify::StageRecord& record : capture.stages()) {
        if (record.blocks < 2 || record.blocks > 4) continue;
        if (!verify::stage_matches(pattern, record.name)) continue;
        const Exploration all = explore_stage(capture, record, input, options);
        INFO(record.name << " in " << record.blocks << " blocks: " << all.schedules
                         << " schedules, blocks meet in " << all.words << " words");
        CHECK_FALSE(all.failing.has_value());
        Exhausted& most = tally[kind.empty() ? to_string(record.kind) : kind];
        if (all.complete && all.schedules > most.schedules) {
            most = {record.name, all.schedules, all.words};
        }
    }
}

TEST_CASE("interleaving: the kernels of gpu/ give one outcome in every order of few small blocks",
          "[simt][interleave][kernels]") {
    Tally tally;
    // The root and its children have two blocks.
    explore_all(spheres_input(few_rays(8, 8)), {{}, 200}, tally, "bounce0/level*");
    // In leaves, several blocks gather hits of one ray and lower its minimum.
    PipelineParameters leaves = few_rays(1, 1);
    leaves.width = 4;
    leaves.max_leaf_size = 1;
    leaves.early_out = reference::EarlyOut::level;
    explore_all(stack_input(leaves, 2), {{}, 2000}, tally, "bounce0/level1/intersect", "leaves");
    leaves.early_out = reference::EarlyOut::off;
    explore_all(stack_input(leaves, 3), {{}, 2000}, tally, "bounce0/level1/intersect", "counts");
    leaves.hit_mode = reference::HitMode::packed;
    explore_all(stack_input(leaves, 3), {{}, 2000}, tally, "bounce0/level1/intersect", "packed");
    PipelineParameters shading = few_rays(24, 23);  // three blocks of 256 paths
    shading.filter = reference::Filter::median;
    shading.filter_threshold = 2;
    shading.early_out = reference::EarlyOut::level;
    for (const char* stages :
         {"primary_rays", "bounce0/level0/publish_minimum", "bounce0/merge*", "bounce0/scene*",
          "bounce0/light0/direct*", "bounce0/light0/resolve*", "reconstruct_image", "filter*"}) {
        explore_all(spheres_input(shading), {{}, 200}, tally, stages);
    }
    for (const char* kind : {"primary_rays", "intersect_root", "intersect", "leaves",
                             "publish_minimum", "merge_intersections", "direct_light_rays",
                             "resolve_light", "scene_rays", "reconstruct_image", "filter"}) {
        INFO(kind);
        CHECK(tally[kind].schedules >= 1);
    }
    // Where blocks meet, there is more than one order.
    for (const char* kind : {"intersect_root", "intersect", "leaves", "counts", "packed"}) {
        INFO(kind << ", " << tally[kind].stage);
        CHECK(tally[kind].words >= 1);
        CHECK(tally[kind].schedules > 1);
    }
}

TEST_CASE("interleaving: more orders of the level kernel, with at most two preemptions",
          "[simt][interleave][kernels]") {
    Tally tally;
    explore_all(spheres_input(few_rays(12, 8)), {2u, 1000}, tally, "bounce0/level0/intersect_root");
    CHECK(tally["intersect_root"].schedules > 6);
}

}  // namespace

namespace scotty::gpu::simt {
namespace {

using scotty::simt::test::Executor;

/// scan_counts over more nodes than one tile holds, so that tiles wait for each other.
TEST_CASE("interleaving: tiles of a scan that wait for each other, in every order",
          "[simt][interleave][kernels]") {
    constexpr std::uint32_t kNodes = kScanThreads + 300;
    Executor executor;
    executor.check_memory();
    const emulation::simt::CurrentDevice here(executor);
    const auto run = [&](emulation::simt::Interleaver& interleaver) {
        executor.checker()->forget_all();
        const auto words = [](std::size_t count) {
            std::uint32_t* memory = nullptr;
            cudaMalloc(reinterpret_cast<void**>(&memory), 4 * count);
            cudaMemset(memory, 0, 4 * count);
            return memory;
        };
        LevelView level{};
        level.node_count = kNodes;
        level.child_node_count = 1;
        level.queue_capacity = 1u << 30;
        std::vector<std::uint32_t> counts(kNodes);
        for (std::uint32_t i = 0; i < kNodes; ++i) counts[i] = i % 77;
        std::uint32_t* const node_counts = words(kNodes);
        cudaMemcpy(node_counts, counts.data(), 4 * kNodes, cudaMemcpyHostToDevice);
        level.node_counts = node_counts;
        level.parents = words(1);
        level.block_offsets = words(kNodes + 1);
        level.child_offsets = words(2);
        std::uint32_t* const tiles = words(2 * (1 + scan_blocks(kNodes, 1)));
        level.scan_ticket = tiles;
        level.scan_tiles = reinterpret_cast<std::uint64_t*>(tiles) + 1;
        level.faults = reinterpret_cast<FaultView*>(words(sizeof(FaultView) / 4));
        executor.interleave(&interleaver);
        executor.launch("scan_counts", scan_blocks(kNodes, 1), kScanThreads, scan_counts, level,
                        32u);
        return std::string(reinterpret_cast<const char*>(level.block_offsets), 4 * (kNodes + 1)) +
               std::string(reinterpret_cast<const char*>(level.child_offsets), 8);
    };
    const auto all = emulation::simt::explore(*executor.checker(), run, {{}, 2000});
    INFO(all.schedules << " schedules, blocks meet in " << all.words << " words");
    CHECK(all.complete);
    CHECK_FALSE(all.failing.has_value());
    CHECK(all.schedules > 6);
}

}  // namespace
}  // namespace scotty::gpu::simt
