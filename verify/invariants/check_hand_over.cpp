/// What a stage reads is what the stage before has written, for every buffer of the contract's
/// tables.
#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "reference/contract/buffers.h"
#include "verify/capture/canonical.h"
#include "verify/invariants/check_state.h"

namespace scotty::verify {

using namespace reference;  // in this file only: the contract's tables

namespace {

/// Under this name and level a buffer is kept. A traversal of shadow rays reads its rays from
/// shadow_rays, and its hits are apart from the path's.
HandOver::Key key_of(const StageView& stage, const BufferInfo& info, bool reads) {
    const bool shadow = stage.light != kNotApplicable;
    const bool before = reads && info.written_as != nullptr;
    const BufferInfo* written = before ? info.written_as : &info;
    if (reads && shadow && written == &buffers::rays &&
        stage.kind != StageKind::direct_light_rays) {
        return {&buffers::shadow_rays, kNotApplicable, false};
    }
    if (written == &buffers::merged) {
        return {written, kNotApplicable, reads ? &info == &buffers::shadow_hits : shadow};
    }
    const bool of_level = info.row == Row::node || info.row == Row::child_node ||
                          info.row == Row::pair || info.row == Row::child_pair;
    return {written, of_level ? stage.level - (before ? 1u : 0u) : kNotApplicable, false};
}

/// The bytes of a buffer that have a meaning, as ranges.
std::vector<std::pair<std::size_t, std::size_t>> used(const StageView& stage,
                                                      const BufferView& buffer) {
    const Regions regions = regions_of(stage, buffer, false);
    if (buffer_info(buffer.name).order == BufferOrder::ordered) return {{0, buffer.bytes}};
    std::vector<std::pair<std::size_t, std::size_t>> ranges;
    for (const Regions::Region& region : regions.regions) {
        ranges.emplace_back(region.begin * regions.element_bytes,
                            (region.begin + region.count) * regions.element_bytes);
    }
    return ranges;
}

Failure failure_of(const CheckState& state, const StageView& stage, const BufferInfo& info,
                   std::size_t byte, std::size_t region, const HandOver::Written& written) {
    Failure failure = failure_at(
        stage, invariant::kHandOver,
        fmt::format("not what {} has {}", written.stage, written.was_read ? "read" : "written"));
    const std::size_t row = byte / info.element_bytes;
    const std::size_t field = byte % info.element_bytes / sizeof(std::uint32_t);
    failure.field = fmt::format("{}[{}]", info.name, row);
    if (!info.fields[field].name.empty()) {
        failure.field += fmt::format(".{}", info.fields[field].name);
    }
    if (info.order == BufferOrder::ordered && info.row == Row::ray) {
        failure.ray = static_cast<std::uint32_t>(row);
    }
    const bool of_queue = &info == &buffers::queue;
    const bool by_node = of_queue || (info.order == BufferOrder::ordered && info.row == Row::node);
    if (by_node && stage.level < state.bvh.level_count()) {
        failure.node = state.bvh.level_begins[stage.level] +
                       static_cast<std::uint32_t>(of_queue ? region : row);
    }
    if (&info == &buffers::hits) failure.ray = static_cast<std::uint32_t>(region);
    return failure;
}

std::string shown(const BufferInfo& info, std::size_t byte, const std::byte* bytes) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, bytes + byte, sizeof bits);
    const bool is_float = info.fields[byte % info.element_bytes / sizeof(std::uint32_t)].is_float;
    return is_float ? exact(std::bit_cast<float>(bits)) : std::to_string(bits);
}

/// The traversal must not end while rays still wait in a queue.
bool check_nothing_waits(CheckState& state, const StageView& stage) {
    if (!state.traversal.running) return true;
    if (const auto& pairs = state.traversal.pairs; !pairs.empty()) {
        Failure failure = failure_at(stage, invariant::kHandOver,
                                     "the traversal ended while pairs waited in a queue");
        failure.level = state.traversal.level + 1;
        failure.ray = pairs.front().ray;
        failure.field = buffers::pairs.name;
        failure.expected = "0 pairs";
        failure.found = fmt::format("{} pairs", pairs.size());
        state.add(std::move(failure));
        return false;
    }
    const auto& counts = state.traversal.node_counts;
    const std::uint32_t level = state.traversal.level + 1;
    for (std::uint32_t node = 0; node < counts.size(); ++node) {
        if (counts[node] == 0) continue;
        Failure failure = failure_at(stage, invariant::kHandOver,
                                     "the traversal ended while rays waited in a queue");
        failure.level = level;
        failure.node = state.bvh.level_begins[level] + node;
        failure.field = buffers::node_counts.name;
        failure.expected = std::to_string(0);
        failure.found = std::to_string(counts[node]);
        state.add(std::move(failure));
        return false;
    }
    return true;
}

}  // namespace

bool check_hand_over(CheckState& state, const StageView& stage) {
    bool same = stage.kind != StageKind::merge_intersections || check_nothing_waits(state, stage);
    for (const BufferView& buffer : stage.inputs) {
        const BufferInfo& info = buffer_info(buffer.name);
        const auto found = state.handed_over.written.find(key_of(stage, info, true));
        if (found == state.handed_over.written.end()) continue;
        const HandOver::Written& written = found->second;
        if (written.bytes.size() != buffer.bytes) {
            Failure failure = failure_of(state, stage, info, 0, 0, written);
            failure.field = info.name;
            failure.expected = fmt::format("{} bytes", written.bytes.size());
            failure.found = fmt::format("{} bytes", buffer.bytes);
            state.add(std::move(failure));
            same = false;
            continue;
        }
        const auto* bytes = static_cast<const std::byte*>(buffer.data);
        std::size_t region = 0;  // of a queue its node, of a hit list its ray
        for (const auto& [begin, end] : used(stage, buffer)) {
            if (std::memcmp(bytes + begin, written.bytes.data() + begin, end - begin) == 0) {
                ++region;
                continue;
            }
            std::size_t byte = begin;
            while (std::memcmp(bytes + byte, written.bytes.data() + byte, sizeof(std::uint32_t)) ==
                   0) {
                byte += sizeof(std::uint32_t);
            }
            Failure failure = failure_of(state, stage, info, byte, region, written);
            failure.expected = shown(info, byte, written.bytes.data());
            failure.found = shown(info, byte, bytes);
            state.add(std::move(failure));
            same = false;
            break;
        }
    }
    return same;
}

void follow_hand_over(CheckState& state, const StageView& stage) {
    auto& written = state.handed_over.written;
    const bool timed = state.parameters.early_out == EarlyOut::immediate;
    for (const BufferView& buffer : stage.outputs) {
        const BufferInfo& info = buffer_info(buffer.name);
        // Blocks of later launches may lower a minimum at any time.
        if (timed && &info == &buffers::minimum) continue;
        const auto* bytes = static_cast<const std::byte*>(buffer.data);
        auto& of = written[key_of(stage, info, false)];
        of = {{bytes, bytes + buffer.bytes}, stage.name, false};
    }
    // Rays that a caller gave are nobody's output: later levels read what the first one has.
    const BufferView* rays = stage.find(buffers::rays.name);
    if (rays == nullptr || stage.bounce != kNotApplicable || !is_of_traversal(stage.kind)) return;
    const auto* bytes = static_cast<const std::byte*>(rays->data);
    written.try_emplace(key_of(stage, buffers::rays, true),
                        HandOver::Written{{bytes, bytes + rays->bytes}, stage.name, true});
}

void forget_traversal(CheckState& state) {
    std::erase_if(state.handed_over.written, [](const auto& each) {
        return each.second.was_read || std::get<0>(each.first)->depends_on_timing;
    });
}

}  // namespace scotty::verify
