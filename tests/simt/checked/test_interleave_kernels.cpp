/// Every kernel of gpu/ in few small blocks, in every order in which these can touch memory.
#include <map>
#include <set>

#include "emulation/simt/cuda/cuda_runtime.h"
#include "emulation/simt/interleave/replayer.h"
#include "gpu/clear_traversal.h"
#include "gpu/scan_counts.h"
#include "tests/simt/executor_tools.h"
#include "tests/verify/capture_tools.h"
#include "verify/canonical.h"
#include "verify/replay_inputs.h"
#include "verify/simt/simt_interleave.h"

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

/// By stage kind, the schedules of the stage in which most blocks met.
struct Tally {
    std::map<StageKind, std::uint64_t> exhausted;
    std::map<StageKind, std::uint64_t> words;
};

void explore_all(const PipelineParameters& p, const ExploreOptions& options,
                 std::uint32_t most_blocks, Tally& tally) {
    const TemporaryFolder folder;
    const verify::Capture capture = make_capture(folder / "c", p);
    const verify::PipelineInput input = spheres_input(p);
    for (const verify::StageRecord& record : capture.stages()) {
        if (record.blocks < 2 || record.blocks > most_blocks) continue;
        if (tally.words[record.kind] != 0 || tally.exhausted[record.kind] > 100) continue;
        const Exploration all = explore_stage(capture, record, input, options);
        INFO(record.name << " in " << record.blocks << " blocks: " << all.schedules
                         << " schedules, blocks meet in " << all.words << " words");
        CHECK_FALSE(all.failing.has_value());
        if (!all.complete) continue;
        tally.exhausted[record.kind] += all.schedules;
        tally.words[record.kind] = all.words;
    }
}

TEST_CASE("interleaving: the kernels of gpu/ give one outcome in every order of few small blocks",
          "[simt][interleave][kernels]") {
    Tally tally;
    explore_all(few_rays(8, 8), {{}, 400}, 4, tally);  // two blocks at the root
    explore_all(few_rays(2, 1), {{}, 400}, 4, tally);  // few rays, in several leaves
    PipelineParameters shading = few_rays(24, 23);     // three blocks of 256 paths
    shading.filter = reference::Filter::median;
    shading.filter_threshold = 2;
    shading.early_out = reference::EarlyOut::level;
    explore_all(shading, {{}, 400}, 4, tally);
    for (const StageKind kind :
         {StageKind::primary_rays, StageKind::intersect_root, StageKind::intersect,
          StageKind::publish_minimum, StageKind::merge_intersections, StageKind::direct_light_rays,
          StageKind::resolve_light, StageKind::scene_rays, StageKind::reconstruct_image,
          StageKind::filter}) {
        INFO(to_string(kind) << ": " << tally.exhausted[kind] << " schedules, " << tally.words[kind]
                             << " words");
        CHECK(tally.exhausted[kind] >= 1);
    }
    // Where blocks meet, there is more than one order.
    CHECK(tally.words[StageKind::intersect_root] >= 1);
    CHECK(tally.exhausted[StageKind::intersect_root] > 1);
    CHECK(tally.words[StageKind::intersect] >= 1);
    CHECK(tally.exhausted[StageKind::intersect] > 1);
}

TEST_CASE("interleaving: more blocks of the level kernels, with at most two preemptions",
          "[simt][interleave][kernels]") {
    Tally tally;
    explore_all(few_rays(16, 10), {2u, 400}, 8, tally);
    CHECK(tally.exhausted[StageKind::intersect_root] > 1);
}

}  // namespace

namespace scotty::gpu::simt {
namespace {

using scotty::simt::test::Executor;

/// scan_counts over more nodes than one tile holds: tiles wait for each other.
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
