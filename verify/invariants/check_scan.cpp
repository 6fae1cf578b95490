/// scan_counts: both outputs are exclusive scans of the queues' lengths.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>

#include "verify/invariants/check_state.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::kNotApplicable;
using reference::StageView;

namespace {

/// Reports the first place where `scan` is not the exclusive scan of value(i), total last.
template <class Value>
void expect_scan(CheckState& state, const StageView& stage, std::string_view field,
                 std::span<const std::uint32_t> scan, std::uint32_t first_node,
                 const Value& value) {
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < scan.size(); ++i) {
        if (scan[i] != sum) {
            Failure failure =
                failure_at(stage, invariant::kScan,
                           sum > 0xffffffffull ? "the sum does not fit in 32 bits"
                                               : "not the exclusive scan of the level's counts");
            failure.field = fmt::format("{}[{}]", field, i);
            if (i + 1 < scan.size()) failure.node = first_node + static_cast<std::uint32_t>(i);
            failure.expected = std::to_string(sum);
            failure.found = std::to_string(scan[i]);
            state.add(std::move(failure));
            return;
        }
        if (i + 1 < scan.size()) sum += value(static_cast<std::uint32_t>(i));
    }
}

}  // namespace

void check_scan(CheckState& state, const StageView& stage) {
    const auto& begins = state.bvh.level_begins;
    const std::uint32_t level = stage.level;
    if (level == kNotApplicable || level + 1 >= begins.size()) {
        state.add(failure_at(stage, invariant::kHandOver, "the BVH has no such level"));
        return;
    }
    const std::uint32_t first = begins[level];
    const std::uint32_t nodes = begins[level + 1] - first;
    const std::uint32_t first_child = begins[level + 1];
    const std::uint32_t children = level + 2 < begins.size() ? begins[level + 2] - first_child : 0u;
    const auto counts = expect_buffer(state, stage, buffers::node_counts, nodes);
    const auto blocks = expect_buffer(state, stage, buffers::block_offsets, nodes + 1);
    const auto regions = expect_buffer(state, stage, buffers::child_offsets, children + 1);
    if (counts.empty()) return;
    const auto per_block = static_cast<std::uint32_t>(state.parameters.rays_per_block);
    expect_scan(state, stage, buffers::block_offsets.name, blocks, first, [&](std::uint32_t node) {
        return (std::uint64_t{counts[node]} + per_block - 1) / per_block;
    });
    expect_scan(state, stage, buffers::child_offsets.name, regions, first_child,
                [&](std::uint32_t child) {
                    return counts[state.bvh.parents[first_child + child] - first];
                });
}

void follow_scan(CheckState& state, const StageView& stage) {
    TraversalState& traversal = state.traversal;
    traversal.level = stage.level;
    traversal.scanned = true;
    traversal.block_offsets = copy_of(stage.get(buffers::block_offsets));
    traversal.child_offsets = copy_of(stage.get(buffers::child_offsets));
    if (stage.level == 0) traversal.node_counts = copy_of(stage.get(buffers::node_counts));
}

}  // namespace scotty::verify
