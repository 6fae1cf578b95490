/// The table of buffers: each one that a stage reads or writes is described once, here.
///
/// Captures, comparisons, invariants and documentation look up layout, canonical form, finiteness,
/// tolerance and meaning in this table, so a new buffer has all of them by being in it. stages.h
/// says which stage reads and writes what.
#pragma once

#include "reference/contract/buffer_info.h"

namespace scotty::reference {

namespace buffers {

// State of the paths.
inline constexpr Buffer<Ray> rays{"rays", Row::ray, kRay, kFloats,
                                  "origin, t_min, direction, t_max"};
inline constexpr Buffer<Ray> shadow_rays{"shadow_rays", Row::ray, kRay, kFloats,
                                         "origin, t_min, direction, t_max"};
inline constexpr Buffer<Vec3> throughput{"throughput", Row::ray, kColour, kFloats,
                                         "importance of the path"};
inline constexpr Buffer<Vec3> radiance{"radiance", Row::ray, kColour, kFloats,
                                       "light gathered so far"};
inline constexpr Buffer<Vec3> potential{"potential", Row::ray, kColour, kFloats,
                                        "light if the shadow ray is free"};
inline constexpr Buffer<std::uint32_t> pixel{"pixel", Row::ray, kNumber, kExact, "y * width + x"};
inline constexpr Buffer<std::uint32_t> sample{"sample", Row::ray, kNumber, kExact,
                                              "sample of the pixel"};
inline constexpr Buffer<std::uint32_t> depth{"depth", Row::ray, kNumber, kForks,
                                             "scatterings so far"};
inline constexpr Buffer<std::uint32_t> flags{"flags", Row::ray, kNumber, kForks,
                                             "1 alive, 2 last scattering specular"};

// The queues that a level writes for its children, and what it reads as written by its parents.
inline constexpr Buffer<std::uint32_t> child_counts{
    "child_counts", Row::child_node, kNumber, kForks, "queue length by child", lengths_of_queues()};
inline constexpr Buffer<std::uint32_t> child_offsets{
    "child_offsets",    Row::child_node, kNumber, kForks, "first queue slot by child node",
    offsets_of_queues()};
inline constexpr Buffer<std::uint32_t> child_queue{
    "child_queue", Row::child_node, kRayId,
    kForks,        "ray ids",       queue_of(child_counts, child_offsets)};
inline constexpr Buffer<std::uint32_t> node_counts{"node_counts",
                                                   Row::node,
                                                   kNumber,
                                                   kForks,
                                                   "queue length by node",
                                                   lengths_of_queues(&child_counts)};
inline constexpr Buffer<std::uint32_t> queue_offsets{"queue_offsets",
                                                     Row::node,
                                                     kNumber,
                                                     kForks,
                                                     "first queue slot by node",
                                                     offsets_of_queues(&child_offsets)};
inline constexpr Buffer<std::uint32_t> queue{
    "queue", Row::node, kRayId,
    kForks,  "ray ids", queue_of(node_counts, queue_offsets, &child_queue)};
inline constexpr Buffer<std::uint32_t> block_offsets{
    "block_offsets", Row::node, kNumber, kForks, "first block by node", offsets_of_queues()};

// With queues of pairs the same: what a level writes for the next one, and what it reads.
inline constexpr Buffer<NodeRay> child_pairs{"child_pairs", Row::child_pair,   kNodeRay,
                                             kForks,        "inner node, ray", set_of_pairs()};
inline constexpr Buffer<NodeRay> pairs{"pairs", Row::pair,         kNodeRay,
                                       kForks,  "inner node, ray", set_of_pairs(&child_pairs)};

// What a traversal finds.
inline constexpr Buffer<std::uint32_t> hit_counts{
    "hit_counts", Row::ray, kNumber, kForks, "hits gathered by ray", lengths_of_queues()};
inline constexpr Buffer<HitCandidate> hits{"hits", Row::ray,       kHitCandidate,
                                           kForks, "t, primitive", hit_list_of(hit_counts)};
inline constexpr Buffer<std::uint64_t> packed_hits{
    "packed_hits", Row::ray, kPackedHit, kDistances, "t bits << 32 | primitive", of_traversal()};
inline constexpr Buffer<float> lowered{
    "lowered", Row::ray, kDistance, kFloats, "nearest distance found by ray", of_traversal()};
inline constexpr Buffer<float> minimum{
    "minimum", Row::ray, kDistance, kFloats, "nearest distance that culls", of_traversal()};
inline constexpr Buffer<Hit> merged{"merged", Row::ray, kHit, kDistances,
                                    "closest hit: t, primitive, u, v"};
inline constexpr Buffer<Hit> path_hits{"path_hits",          Row::ray,          kHit, kDistances,
                                       "t, primitive, u, v", written_as(merged)};
inline constexpr Buffer<Hit> shadow_hits{"shadow_hits",        Row::ray,          kHit, kDistances,
                                         "t, primitive, u, v", written_as(merged)};

// The image.
inline constexpr Buffer<Vec3> image{"image", Row::pixel, kColour, kImages, "radiance by pixel"};
inline constexpr Buffer<Vec3> variance{"variance", Row::pixel, kColour, kImages,
                                       "variance of the pixel's mean"};
inline constexpr Buffer<Vec3> filtered{"filtered", Row::pixel, kColour, kImages,
                                       "radiance by pixel"};

}  // namespace buffers

inline constexpr std::array<const BufferInfo*, 29> kBuffers{
    &buffers::rays,          &buffers::shadow_rays,   &buffers::throughput,
    &buffers::radiance,      &buffers::potential,     &buffers::pixel,
    &buffers::sample,        &buffers::depth,         &buffers::flags,
    &buffers::child_counts,  &buffers::child_offsets, &buffers::child_queue,
    &buffers::node_counts,   &buffers::queue_offsets, &buffers::queue,
    &buffers::block_offsets, &buffers::child_pairs,   &buffers::pairs,
    &buffers::hit_counts,    &buffers::hits,          &buffers::packed_hits,
    &buffers::lowered,       &buffers::minimum,       &buffers::merged,
    &buffers::path_hits,     &buffers::shadow_hits,   &buffers::image,
    &buffers::variance,      &buffers::filtered};

/// Null where there is no buffer of that name.
constexpr const BufferInfo* find_buffer(std::string_view name) {
    for (const BufferInfo* info : kBuffers) {
        if (info->name == name) return info;
    }
    return nullptr;
}

/// A buffer that is not in the table has rows of one number, of which every byte counts.
inline constexpr Buffer<std::uint32_t> kUnknownBuffer{"", Row::none, buffers::kNumber,
                                                      buffers::kExact, ""};
constexpr const BufferInfo& buffer_info(std::string_view name) {
    const BufferInfo* found = find_buffer(name);
    return found == nullptr ? kUnknownBuffer : *found;
}

/// The description does not contradict itself, and what it names is in the table.
constexpr bool is_sound(const BufferInfo& info) {
    const auto in_table = [](const BufferInfo* other) {
        return other != nullptr && find_buffer(other->name) == other;
    };
    const auto says = [&](const BufferInfo* other, Content content) {
        return in_table(other) && other->content == content && other->row == info.row;
    };
    bool judged = info.tolerance.only.empty();
    for (const Field& field : info.fields) judged = judged || field.name == info.tolerance.only;
    const bool queue = info.order == BufferOrder::queue;
    return in_table(&info) && !info.meaning.empty() && info.row != Row::none && judged &&
           info.fields.size() * sizeof(std::uint32_t) == info.element_bytes &&
           (queue || info.order == BufferOrder::hit_list ? says(info.lengths, Content::lengths)
                                                         : info.lengths == nullptr) &&
           (queue ? says(info.offsets, Content::offsets) : info.offsets == nullptr) &&
           (info.written_as == nullptr ||
            (in_table(info.written_as) && info.written_as->type == info.type &&
             info.written_as->element_bytes == info.element_bytes));
}
static_assert(
    [] {
        for (const BufferInfo* info : kBuffers) {
            if (!is_sound(*info)) return false;
        }
        return true;
    }(),
    "a buffer's name occurs twice, or its description contradicts itself");

}  // namespace scotty::reference
