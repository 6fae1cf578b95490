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
    const bool of_level = info.row == Row::node || info.row == Row::child_node;
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
                   std::size_t byte, const std::string& writer) {
    Failure failure =
        failure_at(stage, invariant::kHandOver, "not what " + writer + " has written");
    const std::size_t row = byte / info.element_bytes;
    const std::size_t field = byte % info.element_bytes / sizeof(std::uint32_t);
    failure.field = fmt::format("{}[{}]", info.name, row);
    if (!info.fields[field].name.empty()) {
        failure.field += fmt::format(".{}", info.fields[field].name);
    }
    if (info.order == BufferOrder::ordered && info.row == Row::ray) {
        failure.ray = static_cast<std::uint32_t>(row);
    }
    if (info.order == BufferOrder::ordered && info.row == Row::node) {
        failure.node = state.bvh.level_begins[stage.level] + static_cast<std::uint32_t>(row);
    }
    return failure;
}

std::string shown(const BufferInfo& info, std::size_t byte, const std::byte* bytes) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, bytes + byte, sizeof bits);
    const bool is_float = info.fields[byte % info.element_bytes / sizeof(std::uint32_t)].is_float;
    return is_float ? exact(std::bit_cast<float>(bits)) : std::to_string(bits);
}

}  // namespace

void check_hand_over(CheckState& state, const StageView& stage) {
    for (const BufferView& buffer : stage.inputs) {
        const BufferInfo& info = buffer_info(buffer.name);
        const auto found = state.handed_over.written.find(key_of(stage, info, true));
        if (found == state.handed_over.written.end()) continue;
        const HandOver::Written& written = found->second;
        if (written.bytes.size() != buffer.bytes) {
            Failure failure = failure_of(state, stage, info, 0, written.stage);
            failure.field = info.name;
            failure.expected = fmt::format("{} bytes", written.bytes.size());
            failure.found = fmt::format("{} bytes", buffer.bytes);
            state.add(std::move(failure));
            continue;
        }
        const auto* bytes = static_cast<const std::byte*>(buffer.data);
        for (const auto& [begin, end] : used(stage, buffer)) {
            if (std::memcmp(bytes + begin, written.bytes.data() + begin, end - begin) == 0)
                continue;
            std::size_t byte = begin;
            while (std::memcmp(bytes + byte, written.bytes.data() + byte, sizeof(std::uint32_t)) ==
                   0) {
                byte += sizeof(std::uint32_t);
            }
            Failure failure = failure_of(state, stage, info, byte, written.stage);
            failure.expected = shown(info, byte, written.bytes.data());
            failure.found = shown(info, byte, bytes);
            state.add(std::move(failure));
            break;
        }
    }
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
        of.bytes.assign(bytes, bytes + buffer.bytes);
        of.stage = stage.name;
    }
}

void forget_traversal(CheckState& state) {
    std::erase_if(state.handed_over.written,
                  [](const auto& each) { return std::get<0>(each.first)->depends_on_timing; });
}

}  // namespace scotty::verify
