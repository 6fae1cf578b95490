/// From an index in a buffer to level, node, block, ray and pixel.
#include <algorithm>

#include "reference/contract/last_queues.h"
#include "verify/diff/diff_parts.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::kNotApplicable;
using reference::StageKind;
using reference::StageView;

namespace {

/// Position of a ray in a node's queue; none if it is not in it.
std::optional<std::uint32_t> position_in_queue(const StageView& stage, std::uint32_t position,
                                               std::uint32_t ray) {
    const auto counts = stage.get(buffers::node_counts);
    if (stage.level == 0) return ray;
    const auto offsets = stage.get(buffers::queue_offsets);
    const auto queue = stage.get(buffers::queue);
    if (position >= counts.size() || position >= offsets.size()) return std::nullopt;
    const std::size_t begin = std::min<std::size_t>(offsets[position], queue.size());
    const std::size_t count = std::min<std::size_t>(counts[position], queue.size() - begin);
    const auto entries = queue.subspan(begin, count);
    const auto found = std::find(entries.begin(), entries.end(), ray);
    if (found == entries.end()) return std::nullopt;
    return static_cast<std::uint32_t>(found - entries.begin());
}

}  // namespace

Places::Places(const Capture& capture, const reference::WideBvh* bvh)
    : capture_(capture), bvh_(bvh) {}

std::uint32_t Places::node_id(std::uint32_t level, std::size_t position) const {
    const auto offset = static_cast<std::uint32_t>(position);
    if (bvh_ == nullptr || level >= bvh_->level_begins.size()) return offset;
    return std::min(bvh_->level_begins[level] + offset, bvh_->node_count());
}

std::uint32_t Places::node_of_inner(std::uint32_t inner) const {
    if (bvh_ == nullptr) return kNotApplicable;
    const auto& refs = bvh_->node_refs;
    const auto found = std::find(refs.begin(), refs.end(), inner);
    return found == refs.end() ? kNotApplicable : static_cast<std::uint32_t>(found - refs.begin());
}

std::uint32_t Places::last_queue_of(std::uint32_t primitive) {
    if (bvh_ == nullptr) return kNotApplicable;
    if (last_queues_.empty()) last_queues_ = reference::last_queues(*bvh_);
    return primitive < last_queues_.size() ? last_queues_[primitive] : kNotApplicable;
}

/// Uses B's queue, or A's if B has no such ray.
void Places::fill_thread(Divergence& out, const BufferPair& pair, std::uint32_t node) {
    if (bvh_ == nullptr || pair.b_stage.level >= bvh_->level_count()) return;
    const std::uint32_t first = bvh_->level_begins[pair.b_stage.level];
    if (node < first) return;
    if (capture_.header().parameters.queues == reference::QueueKind::pairs) {
        // Leaves are tested in the launch that finds them.
        const bool leaf = reference::is_leaf(bvh_->node_refs[node]);
        return fill_pair_thread(out, pair, bvh_->node_refs[leaf ? bvh_->parents[node] : node]);
    }
    for (const StageView* stage : {&pair.b_stage, &pair.a_stage}) {
        const auto position = position_in_queue(*stage, node - first, out.ray);
        const auto offsets = stage->get(buffers::block_offsets);
        if (!position || node - first >= offsets.size() || stage->threads == 0) continue;
        out.block = offsets[node - first] + *position / stage->threads;
        out.thread = *position % stage->threads;
        return;
    }
}

void Places::fill_pair_thread(Divergence& out, const BufferPair& pair, std::uint32_t inner) {
    for (const StageView* stage : {&pair.b_stage, &pair.a_stage}) {
        const auto pairs = stage->get(buffers::pairs);
        const auto found =
            std::find_if(pairs.begin(), pairs.end(), [&](const reference::NodeRay& each) {
                return each.node == inner && each.ray == out.ray;
            });
        const bool root = stage->level == 0;
        if ((!root && found == pairs.end()) || stage->threads == 0) continue;
        const auto entry = root ? out.ray : static_cast<std::uint32_t>(found - pairs.begin());
        out.block = entry / stage->threads;
        out.thread = entry % stage->threads;
        return;
    }
}

void Places::fill(Divergence& out, const BufferPair& pair, const Comparison& first) {
    const StageView& stage = pair.b_stage;
    const auto row = static_cast<std::uint32_t>(first.row);
    out.level = stage.level;
    switch (reference::buffer_info(pair.a.name).row) {
        case Row::ray:
            out.ray = row;
            break;
        case Row::node:
            out.node = node_id(stage.level, row);
            out.ray = first.entry_ray;
            break;
        case Row::child_node:
            out.node = node_id(stage.level + 1, row);
            out.ray = first.entry_ray;
            break;
        case Row::pixel: {
            const std::uint32_t width = capture_.header().parameters.image_width;
            out.pixel_x = row % width;
            out.pixel_y = row / width;
            break;
        }
        case Row::pair:
        case Row::child_pair:
            out.node = node_of_inner(first.entry_inner);
            out.ray = first.entry_ray;
            break;
        case Row::none:
            break;
    }
    if (first.field == "shape") {
        out.node = out.ray = out.pixel_x = out.pixel_y = kNotApplicable;
        return;
    }
    if (is_level_kernel(stage.kind)) {
        if (out.ray != kNotApplicable && out.node != kNotApplicable && bvh_ != nullptr &&
            out.node < bvh_->node_count()) {
            const Row kind = reference::buffer_info(pair.a.name).row;
            const bool child = kind == Row::child_node || kind == Row::child_pair;
            fill_thread(out, pair, child ? bvh_->parents[out.node] : out.node);
        } else if (first.entry_primitive != kNotApplicable) {
            out.node = last_queue_of(first.entry_primitive);
            if (out.node != kNotApplicable) fill_thread(out, pair, out.node);
        }
    } else if (out.ray != kNotApplicable && stage.threads != 0 &&
               stage.kind != StageKind::primary_rays &&
               stage.kind != StageKind::reconstruct_image) {
        out.block = out.ray / stage.threads;  // one thread per ray
        out.thread = out.ray % stage.threads;
    }
    fill_provenance(out, stage.batch);
}

void Places::fill_provenance(Divergence& out, std::uint32_t batch) {
    if (out.ray == kNotApplicable) return;
    auto found = origins_.find(batch);
    if (found == origins_.end()) {
        Origins origins;
        const StageRecord* primary = capture_.find(
            reference::stage_name(StageKind::primary_rays, batch, kNotApplicable, kNotApplicable,
                                  kNotApplicable, capture_.header().several_batches));
        if (primary != nullptr && primary->output(buffers::pixel.name) != nullptr &&
            primary->output(buffers::sample.name) != nullptr) {
            const LoadedStage loaded = capture_.load(*primary);
            const auto pixel = loaded.view.get(buffers::pixel);
            const auto sample = loaded.view.get(buffers::sample);
            origins.pixel.assign(pixel.begin(), pixel.end());
            origins.sample.assign(sample.begin(), sample.end());
        }
        found = origins_.emplace(batch, std::move(origins)).first;
    }
    const Origins& origins = found->second;
    if (out.ray >= origins.pixel.size() || out.ray >= origins.sample.size()) return;
    const std::uint32_t width = capture_.header().parameters.image_width;
    out.pixel_x = origins.pixel[out.ray] % width;
    out.pixel_y = origins.pixel[out.ray] / width;
    out.sample = origins.sample[out.ray];
}

}  // namespace scotty::verify
