#include "verify/capture/canonical.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

#include "reference/contract/records.h"
#include "verify/capture/capture_format.h"

namespace scotty::verify {

using reference::BufferView;
using reference::StageView;

namespace {

/// A buffer of the same list first: where a stage updates a buffer in place, its inputs are told
/// by the inputs.
std::span<const std::uint32_t> words(const StageView& stage, std::string_view name, bool output) {
    const auto* first = output ? &stage.outputs : &stage.inputs;
    const auto* second = output ? &stage.inputs : &stage.outputs;
    for (const auto* buffers : {first, second}) {
        for (const BufferView& buffer : *buffers) {
            if (buffer.name == name) {
                return {static_cast<const std::uint32_t*>(buffer.data),
                        buffer.bytes / sizeof(std::uint32_t)};
            }
        }
    }
    return {};
}

Regions::Region region(std::size_t begin, std::size_t end, std::size_t claimed, std::size_t size) {
    begin = std::min(begin, size);
    end = std::clamp(end, begin, size);
    return {begin, end - begin, std::min(claimed, end - begin), claimed};
}

Regions queue_regions(std::span<const std::uint32_t> offsets, std::span<const std::uint32_t> counts,
                      std::size_t size) {
    Regions out;
    if (offsets.size() < counts.size() + 1) return out;
    out.regions.reserve(counts.size());
    for (std::size_t node = 0; node < counts.size(); ++node) {
        out.regions.push_back(region(offsets[node], offsets[node + 1], counts[node], size));
    }
    return out;
}

Regions hit_regions(std::span<const std::uint32_t> counts, const BufferView& buffer) {
    Regions out;
    out.element_bytes = sizeof(reference::HitCandidate);
    const std::size_t size = buffer.bytes / out.element_bytes;
    if (counts.empty() || size % counts.size() != 0) return out;
    const std::size_t capacity = size / counts.size();
    out.regions.reserve(counts.size());
    for (std::size_t ray = 0; ray < counts.size(); ++ray) {
        out.regions.push_back(region(ray * capacity, (ray + 1) * capacity, counts[ray], size));
    }
    return out;
}

std::uint64_t entry_at(const std::byte* data, std::size_t element_bytes, std::size_t index) {
    std::uint32_t pair[2] = {0, 0};
    std::memcpy(pair, data + index * element_bytes, element_bytes);
    return element_bytes == 4 ? pair[0] : std::uint64_t{pair[0]} << 32 | pair[1];
}

template <class T>
void append(std::vector<std::byte>& bytes, T value) {
    const auto* first = reinterpret_cast<const std::byte*>(&value);
    bytes.insert(bytes.end(), first, first + sizeof value);
}

}  // namespace

Regions regions_of(const StageView& stage, const BufferView& buffer, bool output) {
    const reference::BufferInfo& info = reference::buffer_info(buffer.name);
    switch (info.order) {
        case reference::BufferOrder::ordered:
            break;
        case reference::BufferOrder::queue:
            return queue_regions(words(stage, info.offsets->name, output),
                                 words(stage, info.lengths->name, output),
                                 buffer.bytes / sizeof(std::uint32_t));
        case reference::BufferOrder::hit_list:
            return hit_regions(words(stage, info.lengths->name, output), buffer);
        case reference::BufferOrder::set: {
            const std::size_t rows = buffer.bytes / info.element_bytes;
            return {{{0, rows, rows, rows}}, info.element_bytes};
        }
    }
    return {};
}

std::vector<std::byte> without_unused(const BufferView& buffer, const Regions& regions) {
    const auto* data = static_cast<const std::byte*>(buffer.data);
    if (regions.regions.empty()) return {data, data + buffer.bytes};
    constexpr std::uint32_t kUnusedId = reference::kNone;
    constexpr reference::HitCandidate kUnusedHit{reference::kInfinity, reference::kNone};
    // A set of pairs is in use as a whole.
    const void* unused = &kUnusedId;
    if (regions.element_bytes != sizeof kUnusedId) unused = &kUnusedHit;

    std::vector<std::byte> out(buffer.bytes);
    for (std::size_t at = 0; at + regions.element_bytes <= out.size();
         at += regions.element_bytes) {
        std::memcpy(out.data() + at, unused, regions.element_bytes);
    }
    for (const Regions::Region& r : regions.regions) {
        if (r.count == 0) continue;
        std::memcpy(out.data() + r.begin * regions.element_bytes,
                    data + r.begin * regions.element_bytes, r.count * regions.element_bytes);
    }
    return out;
}

std::uint64_t entry_of(const BufferView& buffer, const Regions& regions, std::size_t element) {
    return entry_at(static_cast<const std::byte*>(buffer.data), regions.element_bytes, element);
}

std::vector<std::uint64_t> sorted_entries(const BufferView& buffer, const Regions& regions,
                                          std::size_t region) {
    const Regions::Region& r = regions.regions[region];
    const auto* data = static_cast<const std::byte*>(buffer.data);
    std::vector<std::uint64_t> entries(r.count);
    for (std::size_t i = 0; i < r.count; ++i) {
        entries[i] = entry_at(data, regions.element_bytes, r.begin + i);
    }
    std::sort(entries.begin(), entries.end());
    return entries;
}

std::vector<std::byte> canonical_bytes(const BufferView& buffer, const Regions& regions) {
    if (regions.regions.empty()) return without_unused(buffer, regions);
    std::vector<std::byte> out;
    for (std::size_t i = 0; i < regions.regions.size(); ++i) {
        append(out, std::uint64_t{regions.regions[i].claimed});
        for (const std::uint64_t entry : sorted_entries(buffer, regions, i)) append(out, entry);
    }
    return out;
}

std::string canonical_outcome(const StageView& stage,
                              const std::vector<reference::OwnedBuffer>& outputs,
                              const reference::PipelineParameters& parameters) {
    if (parameters.early_out == reference::EarlyOut::immediate &&
        reference::is_of_traversal(stage.kind)) {
        return {};
    }
    StageView view = stage;
    view.outputs.clear();
    for (const reference::OwnedBuffer& buffer : outputs) view.outputs.push_back(buffer.view());
    std::string out;
    for (const BufferView& buffer : view.outputs) {
        const std::vector<std::byte> bytes =
            canonical_bytes(buffer, regions_of(view, buffer, true));
        out.append(buffer.name).append(1, ' ').append(std::to_string(bytes.size())).append(1, '\n');
        out.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }
    return out;
}

}  // namespace scotty::verify
