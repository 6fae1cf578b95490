#include <algorithm>
#include <string>
#include <utility>

#include "gpu/host/launch_subtrees.h"
#include "gpu/host/traversal.h"
#include "gpu/kernels/clear_traversal.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/intersect.h"
#include "gpu/kernels/intersect_pairs.h"
#include "gpu/kernels/intersect_root.h"
#include "gpu/kernels/merge_intersections.h"
#include "gpu/kernels/publish_minimum.h"
#include "gpu/kernels/scan_counts.h"

namespace SCOTTY_DEVICE_NAMESPACE {

namespace buffers = reference::buffers;
using reference::EarlyOut;
using reference::HitMode;
using reference::StageKind;
using reference::StagePlace;

namespace {

/// How many blocks of a kernel the device holds at once.
template <class Kernel>
std::uint32_t resident_blocks(Kernel kernel, int rays_per_block) {
    int device = 0;
    int multiprocessors = 0;
    int a_multiprocessor = 0;
    check(cudaGetDevice(&device), "asking for the device");
    check(cudaDeviceGetAttribute(&multiprocessors, cudaDevAttrMultiProcessorCount, device),
          "asking for multiprocessors");
    check(
        cudaOccupancyMaxActiveBlocksPerMultiprocessor(&a_multiprocessor, kernel, rays_per_block, 0),
        "asking for the occupancy of the level kernel");
    return static_cast<std::uint32_t>(std::max(1, multiprocessors * a_multiprocessor));
}

/// Blocks of launches whose work the host does not know, by kernel.
template <int Width>
LevelBlocks level_blocks(int rays_per_block) {
    return {resident_blocks(intersect<Width>, rays_per_block),
            std::max(resident_blocks(intersect_subtrees_any<Width>, kSubtreeThreads),
                     resident_blocks(intersect_subtrees_closest<Width>, kSubtreeThreads)),
            resident_blocks(intersect_pairs<Width>, rays_per_block),
            std::max(resident_blocks(intersect_pair_subtrees_any<Width>, kSubtreeThreads),
                     resident_blocks(intersect_pair_subtrees_closest<Width>, kSubtreeThreads))};
}

LevelBlocks level_blocks(int width, int rays_per_block) {
    switch (width) {
        case 2:
            return level_blocks<2>(rays_per_block);
        case 4:
            return level_blocks<4>(rays_per_block);
        case 8:
            return level_blocks<8>(rays_per_block);
        default:
            return level_blocks<16>(rays_per_block);
    }
}

/// Pairs of a level at most: the counter, which runs on where there is no more room, does not reach
/// its end before a block has noted that.
constexpr std::size_t kMostPairs = std::size_t{1} << 31;

StageKind level_stage(const StagePlace& place) {
    return place.level == 0 ? StageKind::intersect_root : StageKind::intersect;
}

}  // namespace

Traversal::Traversal(const DeviceScene& scene, const reference::PipelineParameters& parameters,
                     MemoryBudget& budget, LaunchLog& log, cudaStream_t stream)
    : scene_(scene),
      parameters_(parameters),
      log_(log),
      stream_(stream),
      level_blocks_(level_blocks(scene.width(), parameters.rays_per_block)),
      hit_capacity_(parameters.hit_capacity),
      node_counts_(budget),
      queue_offsets_(budget),
      block_offsets_(budget),
      scans_(budget),
      queue_(budget),
      child_queue_(budget),
      pairs_(budget),
      child_pairs_(budget),
      hit_counts_(budget),
      candidates_(budget),
      packed_(budget),
      minimum_(budget),
      lowered_(budget),
      ray_ticket_(budget),
      faults_(budget) {
    scan_begins_.push_back(0);
    for (std::uint32_t level = 0; level < scene.level_count(); ++level) {
        scan_begins_.push_back(scan_begins_.back() + 1 + scan_blocks_of(level));
    }
}

std::uint32_t Traversal::scan_blocks_of(std::uint32_t level) const {
    return scan_blocks(scene_.level_nodes(level), scene_.level_nodes(level + 1));
}

void Traversal::release() {
    for (auto* buffer : {&queue_, &child_queue_, &hit_counts_}) buffer->release();
    pairs_.release();
    child_pairs_.release();
    candidates_.release();
    packed_.release();
    minimum_.release();
    lowered_.release();
    queue_capacity_ = 0;  // it was a larger batch's
}

void Traversal::run(const TracedRays& traced, const StagePlace& place, const FinalHits& hits) {
    do {
        enqueue(traced, place, hits);
    } while (!is_one_launch() && grow(place));
}

void Traversal::enqueue(const TracedRays& traced, const StagePlace& place, const FinalHits& hits) {
    rays_ = traced.rays;
    count_ = traced.count;
    kind_ = traced.kind;
    coherent_ = traced.coherent;
    final_hits_ = is_one_launch() ? hits : FinalHits{};
    prepare_levels();
    if (is_one_launch()) {
        launch_kernel(place.at_level(0), level_view(0));
        return;
    }
    prepare_rays(count_);
    clear(place);
    for (std::uint32_t level = 0; level < levels(); ++level) {
        const StagePlace here = place.at_level(level);
        // The emulator stops at the first empty level; show no more than it does.
        if (log_.observed() && is_empty(level)) break;
        if (!launch_level(here)) return;  // run() grows what was too small
        if (parameters_.early_out == EarlyOut::level) launch_publish(here);
        swap(queue_, child_queue_);
        swap(pairs_, child_pairs_);
    }
    launch_merge(place, hits.merged);
}

bool Traversal::is_empty(std::uint32_t level) const {
    if (has_pairs()) return download(node_counts_.data() + level, 1, "queue lengths")[0] == 0;
    const LevelView view = level_view(level);
    const auto counts = download(view.node_counts, view.node_count, "queue lengths");
    return std::all_of(counts.begin(), counts.end(), [](auto count) { return count == 0; });
}

void Traversal::prepare_levels() {
    const std::size_t nodes = scene_.level_begins().back();
    const std::size_t offsets = nodes + 2 * scene_.level_count() + 2;
    if (has_pairs()) {
        node_counts_.resize(scene_.level_count() + 1, "queue lengths");
    } else {
        node_counts_.resize(nodes, "queue lengths");
        queue_offsets_.resize(offsets, "queue offsets");
        block_offsets_.resize(offsets, "block offsets");
        scans_.resize(scan_begins_.back(), "scan tiles");
    }
    if (ray_ticket_.size() != 0) return;
    faults_.resize(1, "fault flags");
    ray_ticket_.resize(1, "ray ticket");
    check(cudaMemset(faults_.data(), 0, sizeof(FaultView)), "clearing the fault flags");
    check(cudaMemset(ray_ticket_.data(), 0, sizeof(RayTicket)), "clearing the ray ticket");
}

void Traversal::prepare_rays(std::uint32_t count) {
    queue_capacity_ = std::max(queue_capacity_, 2 * static_cast<std::size_t>(count) *
                                                    static_cast<std::size_t>(scene_.width()));
    if (has_pairs()) {
        queue_capacity_ = std::min(queue_capacity_, kMostPairs);
        pairs_.resize(queue_capacity_, "pairs");
        child_pairs_.resize(queue_capacity_, "pairs");
    } else {
        queue_.resize(queue_capacity_, "ray queues");
        child_queue_.resize(queue_capacity_, "ray queues");
    }
    if (parameters_.hit_mode == HitMode::packed) {
        packed_.resize(count, "packed hits");
    } else {
        hit_counts_.resize(count, "hit counts");
        candidates_.resize(std::size_t{count} * hit_capacity_, "the multi-intersection buffer");
    }
    if (culls()) minimum_.resize(count, "minimum distances");
    if (parameters_.early_out == EarlyOut::level) lowered_.resize(count, "minimum distances");
}

void Traversal::clear(const StagePlace& place) {
    discard_slots(candidates_.data(), candidates_.size() * sizeof(reference::HitCandidate));
    const auto nodes = static_cast<std::uint32_t>(node_counts_.size());
    const auto scans = static_cast<std::uint32_t>(scans_.size());
    SCOTTY_LAUNCH(clear_traversal, item_blocks(std::max(nodes, scans)), kItemThreads, stream_,
                  count_, nodes, node_counts_.data(), scans, scans_.data(), faults_.data());
    if (const cudaError_t status = cudaGetLastError(); status != cudaSuccess) {
        check(status, "clearing before " + place.name(StageKind::merge_intersections));
    }
}

void Traversal::launch_scan(const StagePlace& place, const LevelView& level) {
    const std::uint32_t tiles = scan_blocks_of(place.level);
    log_.run(StageKind::scan_counts, place, tiles, level.node_count, stream_, [&] {
        SCOTTY_LAUNCH(scan_counts, tiles, kScanThreads, stream_, level,
                      static_cast<std::uint32_t>(parameters_.rays_per_block));
    });
}

bool Traversal::launch_level(const StagePlace& place) {
    const LevelView level = level_view(place.level);
    if (!has_pairs()) {
        launch_scan(place, level);
        if (log_.observed() && overflowed()) return false;
        show_scan(place);
    }
    discard_slots(child_queue_.data(), child_queue_.size() * 4);
    discard_slots(child_pairs_.data(), child_pairs_.size() * sizeof(reference::NodeRay));
    launch_kernel(place, level);
    if (log_.observed() && overflowed()) return false;
    show_level(place);
    return true;
}

void Traversal::launch_kernel(const StagePlace& place, const LevelView& level) {
    const std::uint32_t blocks = has_pairs() ? level_blocks_.pairs : level_blocks_.queues;
    log_.run(level_stage(place), place, blocks, place.level == 0 ? count_ : 0, stream_, [&] {
        switch (scene_.width()) {
            case 2:
                launch_intersect<2>(place, level);
                break;
            case 4:
                launch_intersect<4>(place, level);
                break;
            case 8:
                launch_intersect<8>(place, level);
                break;
            default:
                launch_intersect<16>(place, level);
                break;
        }
    });
}

template <int Width>
void Traversal::launch_intersect(const StagePlace& place, const LevelView& level) {
    const auto threads = static_cast<std::uint32_t>(parameters_.rays_per_block);
    const bool strided = parameters_.block_order == reference::BlockOrder::strided;
    const bool root_is_subtree = place.level == 0 && scene_.is_level_of_subtrees(0);
    if (has_pairs() && !root_is_subtree) {
        launch_pairs<Width>(place, level);
    } else if (scene_.is_level_of_subtrees(place.level)) {
        launch_subtrees<Width>(
            {scene_.bvh<Width>(), rays_, level, hit_view(), minimum_view()}, level_blocks_.subtrees,
            {count_, threads, strided, coherent_, scene_.root()}, final_hits_, stream_);
    } else if (place.level == 0) {
        const std::uint32_t blocks = (count_ + threads - 1) / threads;
        SCOTTY_LAUNCH(intersect_root<Width>, std::min(blocks, level_blocks_.queues), threads,
                      stream_, scene_.bvh<Width>(), rays_, count_, level, hit_view(),
                      minimum_view());
    } else {
        SCOTTY_LAUNCH(intersect<Width>, level_blocks_.queues, threads, stream_, scene_.bvh<Width>(),
                      rays_, level, hit_view(), minimum_view(), strided);
    }
}

template <int Width>
void Traversal::launch_pairs(const StagePlace& place, const LevelView& level) {
    const auto threads = static_cast<std::uint32_t>(parameters_.rays_per_block);
    const bool strided = parameters_.block_order == reference::BlockOrder::strided;
    if (scene_.is_level_of_subtrees(place.level)) {
        launch_pair_subtrees<Width>({scene_.bvh<Width>(), rays_, level, hit_view(), minimum_view()},
                                    level_blocks_.pair_subtrees,
                                    {0, threads, strided, false, scene_.root()}, stream_);
        return;
    }
    const std::uint32_t enough = (count_ + threads - 1) / threads;
    const std::uint32_t blocks =
        place.level == 0 ? std::min(enough, level_blocks_.pairs) : level_blocks_.pairs;
    if (blocks == 0) return;
    SCOTTY_LAUNCH(intersect_pairs<Width>, blocks, threads, stream_, scene_.bvh<Width>(), rays_,
                  pair_view(place.level), scene_.root(), hit_view(), minimum_view(), strided);
}

void Traversal::launch_publish(const StagePlace& place) {
    log_.run(StageKind::publish_minimum, place, item_blocks(count_), count_, stream_, [&] {
        SCOTTY_LAUNCH(publish_minimum, item_blocks(count_), kItemThreads, stream_, count_,
                      lowered_.data(), minimum_.data());
    });
    show(StageKind::publish_minimum, place, item_blocks(count_), kItemThreads);
}

void Traversal::launch_merge(const StagePlace& place, reference::Hit* merged) {
    log_.run(StageKind::merge_intersections, place, item_blocks(count_), count_, stream_, [&] {
        SCOTTY_LAUNCH(merge_intersections, item_blocks(count_), kItemThreads, stream_, count_,
                      scene_.view(), rays_, hit_view(), merged);
    });
    show(StageKind::merge_intersections, place, item_blocks(count_), kItemThreads, merged);
}

void Traversal::run_stage(const reference::StageView& stage, DeviceMemory<reference::Ray>& rays,
                          DeviceMemory<reference::Hit>& merged) {
    const reference::StageBuffers in(stage);
    const StagePlace place = reference::place_of(stage);
    kind_ = reference::traversal_kind_of(stage, parameters_);
    coherent_ = false;
    final_hits_ = {};
    alone_ = true;
    prepare_levels();
    // Not by the kernel that clears before a traversal: what is run here is one launch.
    node_counts_.fill_bytes(0);
    scans_.fill_bytes(0);
    faults_.fill_bytes(0);
    if (stage.kind != StageKind::scan_counts && stage.kind != StageKind::publish_minimum) {
        rays.upload(in.input(buffers::rays), "rays");
        rays_ = rays.data();
        count_ = static_cast<std::uint32_t>(rays.size());
    }
    switch (stage.kind) {
        case StageKind::scan_counts:
            load_scan(stage);
            launch_scan(place, level_view(place.level));
            show_scan(place);
            break;
        case StageKind::publish_minimum:
            lowered_.upload(in.input(buffers::lowered), "minimum distances");
            minimum_.resize(lowered_.size(), "minimum distances");
            minimum_.fill_bytes(0xff);
            count_ = static_cast<std::uint32_t>(lowered_.size());
            launch_publish(place);
            break;
        case StageKind::merge_intersections:
            load_hits(stage);
            expect_primitives(in, gathered_hits(in, parameters_, count_),
                              scene_.view().triangle_count);
            merged.resize(count_, "hits");
            merged.fill_bytes(0xff);
            launch_merge(place, merged.data());
            break;
        default:
            has_pairs() ? load_pairs(stage) : load_level(stage);
            launch_kernel(place, level_view(place.level));
            show_level(place);
            break;
    }
    alone_ = false;
    queue_capacity_ = 0;
    hit_capacity_ = parameters_.hit_capacity;
}

void Traversal::load_scan(const reference::StageView& stage) {
    const reference::LevelNodes nodes = nodes_of(scene_.level_begins(), stage);
    queue_capacity_ = 0xffffffffu;  // nothing is pushed
    upload_to(node_counts_.data() + nodes.first,
              reference::StageBuffers(stage).input(buffers::node_counts, nodes.count),
              "queue lengths");
    block_offsets_.fill_bytes(0xff);
    queue_offsets_.fill_bytes(0xff);
}

void Traversal::load_level(const reference::StageView& stage) {
    const reference::StageBuffers in(stage);
    const reference::LevelNodes nodes = nodes_of(scene_.level_begins(), stage);
    const reference::LevelInput level = reference::level_input(in, nodes, parameters_, stage);
    const std::uint32_t begin = nodes.first + stage.level;  // of the level's offsets
    upload_to(node_counts_.data() + nodes.first, level.node_counts, "queue lengths");
    upload_to(queue_offsets_.data() + begin, level.queue_offsets, "queue offsets");
    upload_to(block_offsets_.data() + begin, level.block_offsets, "block offsets");
    upload_to(queue_offsets_.data() + nodes.first_child + stage.level + 1, level.child_offsets,
              "queue offsets");
    queue_.upload(level.queue, "ray queues");
    queue_capacity_ = level.child_offsets.back();
    child_queue_.resize(level.child_offsets.back(), "ray queues");
    child_queue_.fill_bytes(0xff);
    load_minimum(stage);
    load_hits(stage);
}

void Traversal::load_pairs(const reference::StageView& stage) {
    const reference::StageBuffers in(stage);
    nodes_of(scene_.level_begins(), stage);  // throws where there is no such level
    std::uint32_t count = count_;
    if (stage.level != 0) {
        const auto pairs = reference::level_pairs(in, count_, scene_.inner_begins()[stage.level],
                                                  scene_.inner_begins()[stage.level + 1]);
        pairs_.upload(pairs, "pairs");
        count = static_cast<std::uint32_t>(pairs.size());
    }
    upload_to(node_counts_.data() + stage.level, std::span<const std::uint32_t>(&count, 1),
              "queue lengths");
    queue_capacity_ = static_cast<std::size_t>(count) * static_cast<std::size_t>(scene_.width());
    child_pairs_.resize(queue_capacity_, "pairs");
    child_pairs_.fill_bytes(0xff);
    load_minimum(stage);
    load_hits(stage);
}

void Traversal::load_minimum(const reference::StageView& stage) {
    const reference::StageBuffers in(stage);
    if (culls()) minimum_.upload(in.input(buffers::minimum, count_), "minimum distances");
    if (parameters_.early_out == EarlyOut::level) {
        lowered_.upload(in.input(buffers::lowered, count_), "minimum distances");
    }
}

void Traversal::load_hits(const reference::StageView& stage) {
    const reference::StageBuffers in(stage);
    const reference::GatheredHits hits = reference::gathered_hits(in, parameters_, count_);
    hit_capacity_ = hits.capacity;
    hit_counts_.upload(hits.counts, "hit counts");
    candidates_.upload(hits.candidates, "the multi-intersection buffer");
    packed_.upload(hits.packed, "packed hits");
}

bool Traversal::overflowed() const {
    const FaultView faults = download(faults_.data(), 1, "fault flags").front();
    return faults.hits_needed != 0 || faults.queue_needed != 0 || faults.node_overflow != 0;
}

reference::Error Traversal::overflow_of(std::uint32_t node, const StagePlace& place) const {
    std::uint32_t above = 0;
    while (scene_.level_begins()[above + 2] <= node) ++above;
    const LevelView level = level_view(above);
    const std::uint32_t child = node - level.first_child_node;
    const auto region = download(level.child_offsets + child, 2, "queue offsets");
    const auto pushed = download(level.child_counts + child, 1, "queue lengths");
    const StageKind kind = above == 0 ? StageKind::intersect_root : StageKind::intersect;
    return reference::Error::internal(place.at_level(above).name(kind) + ": the queue of node " +
                                      std::to_string(node) + " has " +
                                      std::to_string(region[1] - region[0]) + " slots, but " +
                                      std::to_string(pushed[0]) + " rays were pushed to it");
}

bool Traversal::grow(const StagePlace& place) {
    FaultView faults{};
    check(cudaMemcpyAsync(&faults, faults_.data(), sizeof(faults), cudaMemcpyDeviceToHost, stream_),
          "reading the fault flags of " + place.name(StageKind::merge_intersections));
    check(cudaStreamSynchronize(stream_), "running " + place.name(StageKind::merge_intersections));
    const std::string stage = place.name(StageKind::merge_intersections);
    // First: what followed an overflow means nothing.
    if (faults.node_overflow != 0) throw overflow_of(faults.node_overflow - 1, place);
    if (faults.queue_needed != 0) {
        if (has_pairs() && queue_capacity_ >= kMostPairs) {
            throw reference::Error::bad_input(
                stage, std::to_string(count_) + " rays need more than " +
                           std::to_string(kMostPairs) +
                           " pairs in a level; trace fewer rays at once (--batch-rays, now " +
                           std::to_string(parameters_.batch_rays) + ")");
        }
        const std::string sizes = std::to_string(faults.queue_needed) + " entries, capacity " +
                                  std::to_string(queue_capacity_);
        queue_capacity_ = std::max<std::size_t>(faults.queue_needed, 2 * queue_capacity_);
        if (has_pairs()) queue_capacity_ = std::min(queue_capacity_, kMostPairs);
        log_.retry(stage, "a level's queues need " + sizes);
        return true;
    }
    if (faults.hits_needed != 0) {
        const std::string sizes = std::to_string(faults.hits_needed) + " hits, the buffer had " +
                                  std::to_string(hit_capacity_) + " slots";
        hit_capacity_ = std::max(faults.hits_needed, 2 * hit_capacity_);
        log_.retry(stage, "a ray has " + sizes);
        return true;
    }
    return false;
}

PairView Traversal::pair_view(std::uint32_t level) const {
    return {node_counts_.data() + level,
            level == 0 ? nullptr : pairs_.data(),
            node_counts_.data() + level + 1,
            child_pairs_.data(),
            static_cast<std::uint32_t>(std::min(queue_capacity_, kMostPairs)),
            faults_.data()};
}

LevelView Traversal::level_view(std::uint32_t level) const {
    if (has_pairs()) {
        LevelView view{};
        view.first_node = scene_.level_begins()[level];
        view.node_count = scene_.level_nodes(level);
        view.faults = faults_.data();
        view.ray_ticket = ray_ticket_.data();
        view.pairs = pairs_.data();
        view.pair_count = node_counts_.data() + level;
        return view;
    }
    const auto& begins = scene_.level_begins();
    const std::uint32_t first = begins[level];
    const std::uint32_t next = begins[level + 1];
    return {first,
            scene_.level_nodes(level),
            next,
            scene_.level_nodes(level + 1),
            static_cast<std::uint32_t>(std::min<std::size_t>(queue_capacity_, 0xffffffffu)),
            scene_.parent_positions() + next,
            node_counts_.data() + first,
            queue_offsets_.data() + first + level,
            level == 0 ? nullptr : queue_.data(),
            block_offsets_.data() + first + level,
            node_counts_.data() + next,
            queue_offsets_.data() + next + level + 1,
            child_queue_.data(),
            reinterpret_cast<std::uint32_t*>(scans_.data() + scan_begins_[level]),
            scans_.data() + scan_begins_[level] + 1,
            faults_.data(),
            ray_ticket_.data()};
}

HitView Traversal::hit_view() const {
    return {parameters_.hit_mode == HitMode::packed ? 1u : 0u,
            hit_capacity_,
            hit_counts_.data(),
            candidates_.data(),
            packed_.data(),
            faults_.data()};
}

MinimumView Traversal::minimum_view() const {
    return {culls() ? 1u : 0u, kind_ == reference::TraversalKind::any ? 1u : 0u, minimum_.data(),
            parameters_.early_out == EarlyOut::level ? lowered_.data() : minimum_.data()};
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
