/// Two versions of one buffer: equal, equal except for a free order, or where they part first.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>

#include "reference/contract/records.h"
#include "verify/capture/npy.h"
#include "verify/diff/diff_parts.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::BufferView;

namespace {

bool same_bytes(const BufferView& a, const BufferView& b) {
    return a.bytes == b.bytes && (a.bytes == 0 || std::memcmp(a.data, b.data, a.bytes) == 0);
}

/// Sets that can hold an entry more than once: the entries that only one side has.
struct SetDifference {
    std::vector<std::uint64_t> only_a, only_b;
    std::vector<std::uint64_t> a, b;  ///< sorted

    SetDifference(std::vector<std::uint64_t> of_a, std::vector<std::uint64_t> of_b)
        : a(std::move(of_a)), b(std::move(of_b)) {
        std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(only_a));
        std::set_difference(b.begin(), b.end(), a.begin(), a.end(), std::back_inserter(only_b));
    }
    bool equal() const { return only_a.empty() && only_b.empty(); }
    std::uint64_t size() const { return std::max(only_a.size(), only_b.size()); }
    bool duplicate_in_b(std::uint64_t entry) const {
        return std::binary_search(a.begin(), a.end(), entry);
    }
    bool duplicate_in_a(std::uint64_t entry) const {
        return std::binary_search(b.begin(), b.end(), entry);
    }
};

Comparison different_shape(const BufferPair& pair) {
    Comparison out;
    out.verdict = Verdict::differs;
    out.different = 1;
    out.field = "shape";
    out.a = fmt::format("{} {}", to_string(pair.a.type), shape_text(pair.a.shape));
    out.b = fmt::format("{} {}", to_string(pair.b.type), shape_text(pair.b.shape));
    out.sentence = "the buffer has another type or shape";
    return out;
}

bool used_bytes_equal(const BufferPair& pair, const Regions& a, const Regions& b) {
    const auto* a_data = static_cast<const std::byte*>(pair.a.data);
    const auto* b_data = static_cast<const std::byte*>(pair.b.data);
    for (std::size_t i = 0; i < a.regions.size(); ++i) {
        const Regions::Region& ra = a.regions[i];
        const Regions::Region& rb = b.regions[i];
        if (ra.claimed != rb.claimed || ra.count != rb.count) return false;
        if (ra.count != 0 &&
            std::memcmp(a_data + ra.begin * a.element_bytes, b_data + rb.begin * b.element_bytes,
                        ra.count * a.element_bytes) != 0) {
            return false;
        }
    }
    return true;
}

/// The place of an entry in B's buffer; the last, if there are several.
std::optional<std::size_t> word_of(const BufferView& buffer, const Regions& regions,
                                   std::size_t region, std::uint64_t entry) {
    const Regions::Region& r = regions.regions[region];
    for (std::size_t i = r.count; i-- > 0;) {
        if (entry_of(buffer, regions, r.begin + i) == entry) {
            return (r.begin + i) * (regions.element_bytes / sizeof(std::uint32_t));
        }
    }
    return std::nullopt;
}

/// Compares region by region; `describe` is called for the first that differs.
template <class Describe>
Comparison compare_regions(const BufferPair& pair, const Describe& describe) {
    const Regions a = regions_of(pair.a_stage, pair.a, pair.output);
    const Regions b = regions_of(pair.b_stage, pair.b, pair.output);
    if (a.regions.empty() || a.regions.size() != b.regions.size()) return compare_ordered(pair);
    Comparison out;
    if (used_bytes_equal(pair, a, b)) return out;
    out.verdict = Verdict::reordered;
    for (std::size_t region = 0; region < a.regions.size(); ++region) {
        const SetDifference sets(sorted_entries(pair.a, a, region),
                                 sorted_entries(pair.b, b, region));
        const bool overflows = a.regions[region].claimed != b.regions[region].claimed;
        if (sets.equal() && !overflows) continue;
        if (out.verdict != Verdict::differs) {
            out.verdict = Verdict::differs;
            out.row = region;
            if (sets.equal()) {
                out.field = "count";
                out.a = std::to_string(a.regions[region].claimed);
                out.b = std::to_string(b.regions[region].claimed);
                out.sentence = "the count says more than there is room for";
            } else {
                describe(out, sets);
                if (!sets.only_b.empty())
                    out.word = word_of(pair.b, b, region, sets.only_b.front());
            }
        }
        out.different += std::max<std::uint64_t>(1, sets.size());
    }
    return out;
}

std::string ray_text(std::uint64_t ray) { return fmt::format("ray {} ({:#x})", ray, ray); }

void describe_queue(Comparison& out, const SetDifference& sets) {
    const bool lost = !sets.only_a.empty();
    const bool extra = !sets.only_b.empty();
    out.entry_ray = static_cast<std::uint32_t>(lost ? sets.only_a.front() : sets.only_b.front());
    out.a = lost ? ray_text(sets.only_a.front()) : "no such entry";
    out.b = extra ? ray_text(sets.only_b.front()) : "no such entry";
    if (lost && extra) {
        out.sentence = sets.duplicate_in_b(sets.only_b.front())
                           ? "one ray is missing from the node's queue and another is there twice"
                           : "the node's queue holds another ray";
    } else if (lost) {
        out.sentence = sets.duplicate_in_a(sets.only_a.front())
                           ? "the ray is in the node's queue twice, in A"
                           : "the ray is missing from the node's queue";
    } else {
        out.sentence = sets.duplicate_in_b(sets.only_b.front())
                           ? "the ray is in the node's queue twice"
                           : "the ray should not be in the node's queue";
    }
}

std::string pair_text(std::uint64_t pair) {
    return fmt::format("inner node {}, ray {}", pair >> 32, static_cast<std::uint32_t>(pair));
}

void describe_pairs(Comparison& out, const SetDifference& sets) {
    const bool lost = !sets.only_a.empty();
    const bool extra = !sets.only_b.empty();
    const std::uint64_t first = lost ? sets.only_a.front() : sets.only_b.front();
    out.entry_ray = static_cast<std::uint32_t>(first);
    out.entry_inner = static_cast<std::uint32_t>(first >> 32);
    out.a = lost ? pair_text(sets.only_a.front()) : "no such pair";
    out.b = extra ? pair_text(sets.only_b.front()) : "no such pair";
    const bool twice = lost ? sets.duplicate_in_a(first) : sets.duplicate_in_b(sets.only_b.front());
    if (lost) {
        out.sentence = twice ? "the pair is in the queue twice, in A"
                             : "the pair is missing from the level's queue";
    } else {
        out.sentence = twice ? "the pair is in the queue twice"
                             : "the pair should not be in the level's queue";
    }
}

std::string hit_text(std::uint64_t hit) {
    return fmt::format("primitive {} at t {}", static_cast<std::uint32_t>(hit),
                       value_text(static_cast<std::uint32_t>(hit >> 32), true));
}

void describe_hits(Comparison& out, const SetDifference& sets) {
    const bool lost = !sets.only_a.empty();
    const bool extra = !sets.only_b.empty();
    const std::uint64_t a = lost ? sets.only_a.front() : 0;
    const std::uint64_t b = extra ? sets.only_b.front() : 0;
    out.entry_primitive = static_cast<std::uint32_t>(lost ? a : b);
    out.a = lost ? hit_text(a) : "no such hit";
    out.b = extra ? hit_text(b) : "no such hit";
    if (!lost || !extra) {
        const bool twice = extra ? sets.duplicate_in_b(b) : sets.duplicate_in_a(a);
        out.sentence = std::string("a hit of the ray is ") +
                       (twice ? "there twice" : (lost ? "missing" : "one too many"));
        if (twice && lost) out.sentence += ", in A";
        return;
    }
    const auto a_t = static_cast<std::uint32_t>(a >> 32);
    const auto b_t = static_cast<std::uint32_t>(b >> 32);
    out.field = a_t != b_t ? "t" : "primitive";
    if (a_t != b_t) out.ulps = ulps_between(a_t, b_t);
    out.sentence = "a hit of the ray is another one";
}

}  // namespace

Comparison compare_ordered(const BufferPair& pair) {
    Comparison out;
    if (pair.a.type != pair.b.type || pair.a.shape != pair.b.shape) return different_shape(pair);
    if (same_bytes(pair.a, pair.b)) return out;
    const reference::BufferInfo& layout = reference::buffer_info(pair.a.name);
    const std::size_t columns = layout.fields.size();
    out.verdict = Verdict::differs;
    const bool is_words = pair.a.bytes % sizeof(std::uint32_t) == 0;
    const std::size_t words = is_words ? pair.a.bytes / sizeof(std::uint32_t) : 0;
    std::size_t first = words;
    for (std::size_t i = 0; i < words; ++i) {
        if (word_at(pair.a, i) == word_at(pair.b, i)) continue;
        first = std::min(first, i);
        ++out.different;
    }
    out.sentence = "the values differ";
    if (first == words) return out;
    out.row = first / columns;
    std::size_t column = first % columns;
    if (pair.a.name == buffers::packed_hits.name &&
        word_at(pair.a, first | 1) != word_at(pair.b, first | 1)) {
        column = 1;  // t says more than the primitive
        first |= 1;
    }
    out.word = first;
    const Field& field = layout.fields[column];
    const std::uint32_t a = word_at(pair.a, first);
    const std::uint32_t b = word_at(pair.b, first);
    out.field = field.name;
    out.a = value_text(a, field.is_float);
    out.b = value_text(b, field.is_float);
    if (field.is_float) out.ulps = ulps_between(a, b);
    return out;
}

Comparison compare_queues(const BufferPair& pair) { return compare_regions(pair, describe_queue); }
Comparison compare_hit_lists(const BufferPair& pair) {
    return compare_regions(pair, describe_hits);
}
Comparison compare_pairs(const BufferPair& pair) { return compare_regions(pair, describe_pairs); }

Comparison compare_occlusion(const BufferPair& pair) {
    if (pair.a.bytes != pair.b.bytes) return different_shape(pair);
    Comparison out;
    if (same_bytes(pair.a, pair.b)) return out;
    out.verdict = Verdict::within_bounds;
    const std::size_t rays = pair.a.bytes / sizeof(reference::Hit);
    for (std::size_t ray = 0; ray < rays; ++ray) {
        const bool a = word_at(pair.a, 4 * ray + 1) != reference::kNone;
        const bool b = word_at(pair.b, 4 * ray + 1) != reference::kNone;
        if (a == b) continue;
        ++out.different;
        if (out.verdict == Verdict::differs) continue;
        out.verdict = Verdict::differs;
        out.row = ray;
        out.field = "primitive";
        out.a = a ? "something is hit" : "nothing is hit";
        out.b = b ? "something is hit" : "nothing is hit";
        out.sentence = "the answers differ";
    }
    return out;
}

Comparison compare(const BufferPair& pair) {
    switch (reference::buffer_info(pair.a.name).order) {
        case BufferOrder::queue:
            return compare_queues(pair);
        case BufferOrder::hit_list:
            return compare_hit_lists(pair);
        case BufferOrder::set:
            return compare_pairs(pair);
        case BufferOrder::ordered:
            break;
    }
    return compare_ordered(pair);
}

}  // namespace scotty::verify
