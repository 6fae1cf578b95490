/// The table of stages: a stage is a function from named buffers to named buffers, and which those
/// are is said once, here.
///
/// Both pipelines show these buffers, replay looks up what a stage needs besides them, and the
/// invariants that are asked of a stage are listed with it. A test holds runs to this table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include "reference/contract/buffers.h"
#include "reference/contract/invariant_names.h"
#include "reference/contract/pipeline_parameters.h"

namespace scotty::reference {

enum class StageKind {
    primary_rays,
    scan_counts,
    intersect_root,
    intersect,
    publish_minimum,
    merge_intersections,
    direct_light_rays,
    resolve_light,
    scene_rays,
    reconstruct_image,
    filter
};
inline constexpr std::size_t kStageKinds = static_cast<std::size_t>(StageKind::filter) + 1;

/// When a stage has a buffer.
enum class When {
    always,
    below_root,   ///< at every level but the first
    culling,      ///< under an early-out
    level,        ///< under early-out `level`
    immediate,    ///< under early-out `immediate`
    hit_lists,    ///< with hit mode `buffer`
    packed_hits,  ///< with hit mode `packed`
    nodes,        ///< with a queue per node
    pairs         ///< with queues of pairs
};
/// Whether that is so for a launch at that level.
constexpr bool applies(When when, const PipelineParameters& p, std::uint32_t level) {
    switch (when) {
        case When::always:
            break;
        case When::below_root:
            return level != 0;
        case When::culling:
            return p.early_out != EarlyOut::off;
        case When::level:
            return p.early_out == EarlyOut::level;
        case When::immediate:
            return p.early_out == EarlyOut::immediate;
        case When::hit_lists:
            return p.hit_mode == HitMode::buffer;
        case When::packed_hits:
            return p.hit_mode == HitMode::packed;
        case When::nodes:
            return p.queues == QueueKind::nodes;
        case When::pairs:
            return p.queues == QueueKind::pairs;
    }
    return true;
}

/// A buffer that a stage reads or writes.
struct StageBuffer {
    constexpr StageBuffer() = default;
    constexpr StageBuffer(const BufferInfo& info, When condition = When::always)
        : buffer(&info), when(condition) {}

    const BufferInfo* buffer = nullptr;
    When when = When::always;
};

/// Where a stage that is run alone takes a buffer from that its record does not hold.
enum class Source {
    blank,          ///< nothing is known yet
    minimum,        ///< the stage's own minimum: between levels all that was lowered is published
    level_before,   ///< the kernel of the level before
    primary_rays,   ///< of the batch
    vertex_before,  ///< scene_rays of the bounce before, or else primary_rays
    light_before,   ///< resolve_light of the light sample before, or else vertex_before
    last_light,     ///< resolve_light of the bounce's last light sample, or else vertex_before
    batch_before    ///< reconstruct_image of the batch before, or else blank
};

/// What a stage updates in place or reads besides its inputs, as it was before the launch.
struct StageNeed {
    constexpr StageNeed() = default;
    constexpr StageNeed(const BufferInfo& info, Source from, When condition = When::always)
        : buffer(&info), source(from), when(condition) {}

    const BufferInfo* buffer = nullptr;
    Source source = Source::blank;
    When when = When::always;
};

/// A short list in a table.
template <class T, std::size_t Capacity>
class ShortList {
 public:
    constexpr ShortList() = default;
    constexpr ShortList(std::initializer_list<T> values) {
        for (const T& value : values) items_[size_++] = value;
    }
    constexpr const T* begin() const { return items_.data(); }
    constexpr const T* end() const { return items_.data() + size_; }
    constexpr std::size_t size() const { return size_; }

 private:
    std::array<T, Capacity> items_{};
    std::size_t size_ = 0;
};

struct StageInfo {
    StageKind kind = StageKind::primary_rays;
    const char* name = "";
    const char* label = "";  ///< in analyses, where several kinds may be one
    Row thread = Row::ray;   ///< what each thread has one of
    bool of_traversal = false;
    ShortList<StageBuffer, 10> inputs = {};
    ShortList<StageBuffer, 10> outputs = {};
    /// What it writes besides, which is handed back where it is run alone, but not shown.
    ShortList<StageBuffer, 2> lowers = {};
    ShortList<StageNeed, 8> needs = {};
    ShortList<const char*, 12> invariants = {};
};

namespace detail {

inline constexpr ShortList<const char*, 12> kLevelInvariants{
    invariant::kNonFinite,       invariant::kHandOver,    invariant::kCountEqualsPushes,
    invariant::kSlotWrittenOnce, invariant::kNoDuplicate, invariant::kNothingExtra,
    invariant::kRequiredPresent, invariant::kInputOrder,  invariant::kConservation,
    invariant::kLeafHits,        invariant::kMinimum};

}  // namespace detail

/// In the order of the enumeration.
inline constexpr std::array<StageInfo, kStageKinds> kStages = [] {
    using namespace buffers;    // in this function only: their handles
    using namespace invariant;  // and the invariants' names
    return std::array<StageInfo, kStageKinds>{{
        {.kind = StageKind::primary_rays,
         .name = "primary_rays",
         .label = "primary rays",
         .thread = Row::pixel,
         .outputs = {rays, throughput, radiance, potential, pixel, sample, depth, flags},
         .invariants = {kNonFinite, kHandOver, kRayRecord, kPathState, kPixels, kShading}},
        {.kind = StageKind::scan_counts,
         .name = "scan_counts",
         .label = "scans",
         .thread = Row::node,
         .of_traversal = true,
         .inputs = {node_counts},
         .outputs = {block_offsets, child_offsets},
         .invariants = {kNonFinite, kHandOver, kScan}},
        {.kind = StageKind::intersect_root,
         .name = "intersect_root",
         .label = "traversal",
         .of_traversal = true,
         .inputs = {rays,
                    {node_counts, When::nodes},
                    {queue_offsets, When::nodes},
                    {block_offsets, When::nodes},
                    {child_offsets, When::nodes},
                    {minimum, When::culling}},
         .outputs = {{child_counts, When::nodes},
                     {child_queue, When::nodes},
                     {child_pairs, When::pairs},
                     {hit_counts, When::hit_lists},
                     {hits, When::hit_lists},
                     {packed_hits, When::packed_hits}},
         .lowers = {{lowered, When::level}, {minimum, When::immediate}},
         .needs = {{hit_counts, Source::blank, When::hit_lists},
                   {hits, Source::blank, When::hit_lists},
                   {packed_hits, Source::blank, When::packed_hits},
                   {lowered, Source::minimum, When::level}},
         .invariants = detail::kLevelInvariants},
        {.kind = StageKind::intersect,
         .name = "intersect",
         .label = "traversal",
         .of_traversal = true,
         .inputs = {rays,
                    {node_counts, When::nodes},
                    {queue_offsets, When::nodes},
                    {block_offsets, When::nodes},
                    {child_offsets, When::nodes},
                    {queue, When::nodes},
                    {pairs, When::pairs},
                    {minimum, When::culling}},
         .outputs = {{child_counts, When::nodes},
                     {child_queue, When::nodes},
                     {child_pairs, When::pairs},
                     {hit_counts, When::hit_lists},
                     {hits, When::hit_lists},
                     {packed_hits, When::packed_hits}},
         .lowers = {{lowered, When::level}, {minimum, When::immediate}},
         .needs = {{hit_counts, Source::level_before, When::hit_lists},
                   {hits, Source::level_before, When::hit_lists},
                   {packed_hits, Source::level_before, When::packed_hits},
                   {lowered, Source::minimum, When::level},
                   {minimum, Source::level_before, When::immediate}},
         .invariants = detail::kLevelInvariants},
        {.kind = StageKind::publish_minimum,
         .name = "publish_minimum",
         .label = "publish minimum",
         .of_traversal = true,
         .inputs = {lowered},
         .outputs = {minimum},
         .invariants = {kNonFinite, kMinimum}},
        {.kind = StageKind::merge_intersections,
         .name = "merge_intersections",
         .label = "merge",
         .inputs = {rays,
                    {hit_counts, When::hit_lists},
                    {hits, When::hit_lists},
                    {packed_hits, When::packed_hits}},
         .outputs = {merged},
         .invariants = {kNonFinite, kHandOver, kMerge, kRequiredPresent}},
        {.kind = StageKind::direct_light_rays,
         .name = "direct_light_rays",
         .label = "direct-light rays",
         .inputs = {rays, path_hits, throughput, flags},
         .outputs = {shadow_rays, potential},
         .needs = {{pixel, Source::primary_rays}, {sample, Source::primary_rays}},
         .invariants = {kNonFinite, kHandOver, kRayRecord, kPathState, kShading}},
        {.kind = StageKind::resolve_light,
         .name = "resolve_light",
         .label = "resolve light",
         .inputs = {shadow_rays, shadow_hits, potential},
         .outputs = {radiance},
         .needs = {{radiance, Source::light_before}},
         .invariants = {kNonFinite, kHandOver, kResolveLight}},
        {.kind = StageKind::scene_rays,
         .name = "scene_rays",
         .label = "scene rays",
         .inputs = {path_hits},
         .outputs = {rays, throughput, radiance, flags, depth},
         .needs = {{pixel, Source::primary_rays},
                   {sample, Source::primary_rays},
                   {rays, Source::vertex_before},
                   {throughput, Source::vertex_before},
                   {flags, Source::vertex_before},
                   {depth, Source::vertex_before},
                   {radiance, Source::last_light}},
         .invariants = {kNonFinite, kHandOver, kRayRecord, kPathState, kShading}},
        {.kind = StageKind::reconstruct_image,
         .name = "reconstruct_image",
         .label = "image",
         .thread = Row::pixel,
         .inputs = {radiance, pixel},
         .outputs = {image, variance},
         .needs = {{image, Source::batch_before}, {variance, Source::batch_before}},
         .invariants = {kNonFinite, kHandOver, kPixels}},
        {.kind = StageKind::filter,
         .name = "filter",
         .label = "image",
         .thread = Row::pixel,
         .inputs = {image},
         .outputs = {filtered},
         .invariants = {kNonFinite, kHandOver, kFilter}},
    }};
}();

constexpr const StageInfo& stage_info(StageKind kind) {
    return kStages[static_cast<std::size_t>(kind)];
}
constexpr const char* to_string(StageKind kind) { return stage_info(kind).name; }
/// One of the launches that a traversal makes for every level.
constexpr bool is_of_traversal(StageKind kind) { return stage_info(kind).of_traversal; }
/// The kernels that read one level's queues and write the next's.
constexpr bool is_level_kernel(StageKind kind) {
    return kind == StageKind::intersect_root || kind == StageKind::intersect;
}

namespace detail {

/// Every list of buffers of every stage.
template <class F>
constexpr bool all_stage_buffers(const F& f) {
    bool all = true;
    for (const StageInfo& stage : kStages) {
        for (const StageBuffer& each : stage.inputs) all = all && f(each.buffer);
        for (const StageBuffer& each : stage.outputs) all = all && f(each.buffer);
        for (const StageBuffer& each : stage.lowers) all = all && f(each.buffer);
        for (const StageNeed& each : stage.needs) all = all && f(each.buffer);
    }
    return all;
}
constexpr bool is_written(const BufferInfo* buffer) {
    if (buffer->written_as != nullptr) buffer = buffer->written_as;
    for (const StageInfo& stage : kStages) {
        for (const StageBuffer& each : stage.outputs) {
            if (each.buffer == buffer) return true;
        }
        for (const StageBuffer& each : stage.lowers) {
            if (each.buffer == buffer) return true;
        }
    }
    return false;
}
constexpr bool is_used(const BufferInfo* buffer) {
    return !all_stage_buffers([&](const BufferInfo* each) { return each != buffer; });
}

static_assert(all_stage_buffers([](const BufferInfo* each) {
                  return find_buffer(each->name) == each;
              }),
              "a stage has a buffer that is not in the table");
static_assert(all_stage_buffers(is_written), "a stage reads what no stage writes");
static_assert(
    [] {
        for (const BufferInfo* info : kBuffers) {
            if (!is_used(info)) return false;
        }
        return true;
    }(),
    "a buffer of the table is no stage's");
static_assert(
    [] {
        for (std::size_t i = 0; i < kStageKinds; ++i) {
            if (static_cast<std::size_t>(kStages[i].kind) != i) return false;
            for (std::size_t j = 0; j < i; ++j) {
                if (std::string_view(kStages[i].name) == kStages[j].name) return false;
            }
        }
        return true;
    }(),
    "the stages are not in the order of their enumeration, or a name occurs twice");

}  // namespace detail

}  // namespace scotty::reference
