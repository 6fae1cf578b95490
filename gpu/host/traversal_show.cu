/// What an observer sees of a traversal: device buffers, copied to the host.
#include <cstdint>
#include <vector>

#include "gpu/host/host_copies.h"
#include "gpu/host/traversal.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/scan_counts.h"

namespace SCOTTY_DEVICE_NAMESPACE {

namespace buffers = reference::buffers;
using reference::BufferInfo;
using reference::BufferView;
using reference::StageKind;
using reference::StagePlace;

void Traversal::show_scan(const StagePlace& place) {
    show(StageKind::scan_counts, place, scan_blocks_of(place.level), kScanThreads);
}

void Traversal::show_level(const StagePlace& place) {
    show(place.level == 0 ? StageKind::intersect_root : StageKind::intersect, place, 0,
         static_cast<std::uint32_t>(parameters_.rays_per_block));
}

void Traversal::show(StageKind kind, const StagePlace& place, std::uint32_t blocks,
                     std::uint32_t threads, const reference::Hit* merged) {
    if (!log_.wants(kind)) return;
    const LevelView level =
        place.level == reference::kNotApplicable ? LevelView{} : level_view(place.level);
    const auto entries = [&](std::uint32_t of_level) {
        return download(node_counts_.data() + of_level, 1, "queue lengths").front();
    };
    HostCopies copies;
    const auto last = [](const std::uint32_t* offsets, std::uint32_t nodes) {
        return download(offsets + nodes, 1, "queue offsets").front();
    };
    const auto view_of = [&](const BufferInfo& wanted) {
        const auto is = [&](const BufferInfo& one) { return one.name == wanted.name; };
        if (is(buffers::rays)) return copies.view(buffers::rays, rays_, count_);
        if (is(buffers::merged)) return copies.view(buffers::merged, merged, count_);
        if (is(buffers::minimum)) return copies.view(buffers::minimum, minimum_.data(), count_);
        if (is(buffers::lowered)) return copies.view(buffers::lowered, lowered_.data(), count_);
        if (is(buffers::packed_hits)) {
            return copies.view(buffers::packed_hits, packed_.data(), count_);
        }
        if (is(buffers::hit_counts)) {
            return copies.view(buffers::hit_counts, hit_counts_.data(), count_);
        }
        if (is(buffers::hits)) {
            return copies.view(buffers::hits, candidates_.data(),
                               std::size_t{count_} * hit_capacity_, count_);
        }
        if (is(buffers::pairs)) {
            return copies.view(buffers::pairs, pairs_.data(), entries(place.level));
        }
        if (is(buffers::child_pairs)) {
            return copies.view(buffers::child_pairs, child_pairs_.data(), entries(place.level + 1));
        }
        if (is(buffers::child_counts)) {
            return copies.view(buffers::child_counts, level.child_counts, level.child_node_count);
        }
        if (is(buffers::child_offsets)) {
            return copies.view(buffers::child_offsets, level.child_offsets,
                               level.child_node_count + 1);
        }
        if (is(buffers::child_queue)) {
            return copies.view(buffers::child_queue, level.child_queue,
                               last(level.child_offsets, level.child_node_count));
        }
        if (is(buffers::node_counts)) {
            return copies.view(buffers::node_counts, level.node_counts, level.node_count);
        }
        if (is(buffers::block_offsets)) {
            return copies.view(buffers::block_offsets, level.block_offsets, level.node_count + 1);
        }
        if (is(buffers::queue)) {
            return copies.view(buffers::queue, level.queue,
                               last(level.queue_offsets, level.node_count));
        }
        if (level.queue != nullptr) {
            return copies.view(buffers::queue_offsets, level.queue_offsets, level.node_count + 1);
        }
        return copies.view(buffers::queue_offsets, std::vector<std::uint32_t>{0, count_});
    };
    if (reference::is_level_kernel(kind)) {
        blocks = has_pairs() ? (entries(place.level) + threads - 1) / threads
                             : last(level.block_offsets, level.node_count);
    }
    log_.show(parameters_, kind, place, blocks, threads, view_of, alone_);
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
