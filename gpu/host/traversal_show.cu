/// What an observer sees of a traversal: device buffers, copied to the host.
#include <algorithm>
#include <cstdint>
#include <vector>

#include "gpu/host/traversal.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/scan_counts.h"

namespace SCOTTY_DEVICE_NAMESPACE {

namespace buffers = reference::buffers;
using reference::buffer_view;
using reference::EarlyOut;
using reference::HitMode;
using reference::StageKind;
using reference::StagePlace;
using reference::StageView;

namespace {

/// Host copies that live as long as the stage view that points into them.
template <class T>
std::span<const T> keep(std::vector<std::vector<T>>& kept, const T* device, std::size_t count,
                        const char* name) {
    kept.push_back(download(device, count, name));
    return kept.back();
}

}  // namespace

void Traversal::show_scan(const StagePlace& place, const LevelView& level) {
    const auto counts = download(level.node_counts, level.node_count, "node_counts");
    const auto blocks = download(level.block_offsets, level.node_count + 1, "block_offsets");
    const auto children =
        download(level.child_offsets, level.child_node_count + 1, "child_offsets");
    StageView stage =
        log_.stage(StageKind::scan_counts, place, scan_blocks_of(place.level), kScanThreads);
    stage.inputs = {buffer_view(buffers::node_counts, std::span<const std::uint32_t>(counts))};
    stage.outputs = {buffer_view(buffers::block_offsets, std::span<const std::uint32_t>(blocks)),
                     buffer_view(buffers::child_offsets, std::span<const std::uint32_t>(children))};
    log_.show(stage);
}

void Traversal::show_level(const StagePlace& place, const LevelView& level) {
    std::vector<std::vector<std::uint32_t>> words;
    words.reserve(8);
    const auto rays = download(rays_, count_, "rays");
    const auto counts = keep(words, level.node_counts, level.node_count, "node_counts");
    const auto blocks = keep(words, level.block_offsets, level.node_count + 1, "block_offsets");
    const auto child_offsets =
        keep(words, level.child_offsets, level.child_node_count + 1, "child_offsets");
    const auto child_counts =
        keep(words, level.child_counts, level.child_node_count, "child_counts");
    const auto child_queue = keep(words, level.child_queue, child_offsets.back(), "child_queue");

    const StageKind kind = place.level == 0 ? StageKind::intersect_root : StageKind::intersect;
    StageView stage = log_.stage(kind, place, blocks.back(),
                                 static_cast<std::uint32_t>(parameters_.rays_per_block));
    stage.inputs = {buffer_view(buffers::rays, std::span<const reference::Ray>(rays)),
                    buffer_view(buffers::node_counts, counts)};
    std::vector<std::uint32_t> queue_offsets{0, count_};
    std::vector<std::uint32_t> queue;
    if (place.level > 0) {
        queue_offsets = download(level.queue_offsets, level.node_count + 1, "queue_offsets");
        queue = download(level.queue, queue_offsets.back(), "queue");
    }
    stage.inputs.push_back(
        buffer_view(buffers::queue_offsets, std::span<const std::uint32_t>(queue_offsets)));
    stage.inputs.push_back(buffer_view(buffers::block_offsets, blocks));
    stage.inputs.push_back(buffer_view(buffers::child_offsets, child_offsets));
    if (place.level > 0) {
        stage.inputs.push_back(buffer_view(buffers::queue, std::span<const std::uint32_t>(queue)));
    }
    std::vector<float> minimum;
    if (culls()) {
        minimum = download(minimum_.data(), count_, "minimum");
        stage.inputs.push_back(buffer_view(buffers::minimum, std::span<const float>(minimum)));
    }
    stage.outputs = {buffer_view(buffers::child_counts, child_counts),
                     buffer_view(buffers::child_queue, child_queue)};
    std::vector<std::uint64_t> packed;
    std::vector<std::uint32_t> hit_counts;
    std::vector<reference::HitCandidate> candidates;
    if (parameters_.hit_mode == HitMode::packed) {
        packed = download(packed_.data(), count_, "packed_hits");
        stage.outputs.push_back(
            buffer_view(buffers::packed_hits, std::span<const std::uint64_t>(packed)));
    } else {
        hit_counts = download(hit_counts_.data(), count_, "hit_counts");
        candidates = download(candidates_.data(), std::size_t{count_} * hit_capacity_, "hits");
        stage.outputs.push_back(
            buffer_view(buffers::hit_counts, std::span<const std::uint32_t>(hit_counts)));
        stage.outputs.push_back(
            buffer_view(buffers::hits, std::span<const reference::HitCandidate>(candidates)));
        stage.outputs.back().shape = {count_, hit_capacity_, 2};
    }
    std::vector<float> lowered;
    if (alone_ && culls()) {
        const bool by_level = parameters_.early_out == EarlyOut::level;
        lowered = download(by_level ? lowered_.data() : minimum_.data(), count_, "lowered");
        stage.outputs.push_back(buffer_view(by_level ? buffers::lowered : buffers::minimum,
                                            std::span<const float>(lowered)));
    }
    log_.show(stage);
}

void Traversal::show_publish(const StagePlace& place) {
    const auto lowered = download(lowered_.data(), count_, "lowered");
    const auto minimum = download(minimum_.data(), count_, "minimum");
    StageView stage =
        log_.stage(StageKind::publish_minimum, place, item_blocks(count_), kItemThreads);
    stage.inputs = {buffer_view(buffers::lowered, std::span<const float>(lowered))};
    stage.outputs = {buffer_view(buffers::minimum, std::span<const float>(minimum))};
    log_.show(stage);
}

void Traversal::show_merge(const StagePlace& place, const reference::Hit* merged) {
    const auto rays = download(rays_, count_, "rays");
    const auto hits = download(merged, count_, "merged");
    StageView stage =
        log_.stage(StageKind::merge_intersections, place, item_blocks(count_), kItemThreads);
    stage.inputs = {buffer_view(buffers::rays, std::span<const reference::Ray>(rays))};
    std::vector<std::uint64_t> packed;
    std::vector<std::uint32_t> counts;
    std::vector<reference::HitCandidate> candidates;
    if (parameters_.hit_mode == HitMode::packed) {
        packed = download(packed_.data(), count_, "packed_hits");
        stage.inputs.push_back(
            buffer_view(buffers::packed_hits, std::span<const std::uint64_t>(packed)));
    } else {
        counts = download(hit_counts_.data(), count_, "hit_counts");
        candidates = download(candidates_.data(), std::size_t{count_} * hit_capacity_, "hits");
        stage.inputs.push_back(
            buffer_view(buffers::hit_counts, std::span<const std::uint32_t>(counts)));
        stage.inputs.push_back(
            buffer_view(buffers::hits, std::span<const reference::HitCandidate>(candidates)));
        stage.inputs.back().shape = {count_, hit_capacity_, 2};
    }
    stage.outputs = {buffer_view(buffers::merged, std::span<const reference::Hit>(hits))};
    log_.show(stage);
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
