/// What the contract says about a buffer; buffers.h is the table of them.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>

#include "reference/contract/records.h"

namespace scotty::reference {

enum class ElementType { uint8, uint32, uint64, float32 };

/// The type that an array of records is shown as: float32 where all of a record's fields are
/// floats.
template <class T>
constexpr ElementType element_type_of() {
    if constexpr (std::is_same_v<T, float> || std::is_same_v<T, Vec3> || std::is_same_v<T, Ray>) {
        return ElementType::float32;
    } else if constexpr (std::is_same_v<T, std::uint64_t>) {
        return ElementType::uint64;
    } else {
        static_assert(sizeof(T) % sizeof(std::uint32_t) == 0);
        return ElementType::uint32;
    }
}

/// What one row of a buffer stands for. Nodes and pairs are those of the stage's level, child nodes
/// and child pairs those of the level below.
enum class Row { ray, pixel, node, child_node, none, pair, child_pair };

/// What the numbers of a buffer are to the queues.
enum class Content { values, lengths, offsets };

/// One 4-byte field of a row.
struct Field {
    std::string_view name;
    bool is_float = false;
    /// +infinity has a meaning here: there is no limit, or nothing has been found yet.
    bool may_be_infinite = false;
    /// What the field holds where nothing is known: in unused memory and before a render begins. A
    /// row whose fields are all blank counts as finite, whatever its bits.
    std::uint32_t blank = 0;
};

/// What about a buffer's bytes the contract fixes.
enum class BufferOrder {
    ordered,   ///< every byte
    queue,     ///< per node, the set of ids in the used part of its region
    hit_list,  ///< per ray, the set of its first min(count, capacity) hits
    set        ///< the set of its rows
};

/// What fast arithmetic may change in a buffer.
struct Tolerance {
    /// Of the larger magnitude of the two numbers, or of a hundredth of the field's largest finite
    /// magnitude in the buffer, where that is more.
    double relative = 0.0;
    /// The part of the rows that may be farther off: of rays, pixels, or entries of queues and hit
    /// lists. A path forks where a comparison flips.
    double share = 0.0;
    /// The one field that is judged; all are where this is empty.
    std::string_view only = {};
};

struct BufferInfo;
/// What only some buffers have.
struct BufferTraits {
    Content content = Content::values;
    BufferOrder order = BufferOrder::ordered;
    /// Of a queue and a hit list: what holds how many entries of each region are in use.
    const BufferInfo* lengths = nullptr;
    /// Of a queue: what holds where each region begins.
    const BufferInfo* offsets = nullptr;
    /// The stage that wrote it calls it this.
    const BufferInfo* written_as = nullptr;
    /// Under early-out `immediate` it depends on when other blocks lower a minimum.
    bool depends_on_timing = false;
};

struct BufferInfo : BufferTraits {
    std::string_view name;
    Row row = Row::none;
    std::span<const Field> fields;
    Tolerance tolerance;
    std::string_view meaning;
    ElementType type = ElementType::uint32;
    std::size_t element_bytes = sizeof(std::uint32_t);
};

/// A buffer whose elements are of type T: what typed access takes instead of a name and a type.
template <class T>
struct Buffer : BufferInfo {
    constexpr Buffer(std::string_view its_name, Row its_row, std::span<const Field> its_fields,
                     Tolerance its_tolerance, std::string_view its_meaning,
                     BufferTraits traits = {})
        : BufferInfo{traits,
                     its_name,
                     its_row,
                     its_fields,
                     its_tolerance,
                     its_meaning,
                     element_type_of<T>(),
                     sizeof(T)} {}
};

namespace buffers {

// Kinds of rows.
inline constexpr std::uint32_t kInfinityBits = 0x7f800000u;
inline constexpr std::array kNumber{Field{""}};
inline constexpr std::array kRayId{Field{"", false, false, kNone}};
inline constexpr std::array kDistance{Field{"", true, true, kInfinityBits}};
inline constexpr std::array kColour{Field{"r", true}, Field{"g", true}, Field{"b", true}};
inline constexpr std::array kRay{Field{"origin.x", true},    Field{"origin.y", true},
                                 Field{"origin.z", true},    Field{"t_min", true},
                                 Field{"direction.x", true}, Field{"direction.y", true},
                                 Field{"direction.z", true}, Field{"t_max", true, true}};
inline constexpr std::array kHit{Field{"t", true, false, kInfinityBits},
                                 Field{"primitive", false, false, kNone}, Field{"u", true},
                                 Field{"v", true}};
inline constexpr std::array kHitCandidate{Field{"t", true, false, kInfinityBits},
                                          Field{"primitive", false, false, kNone}};
inline constexpr std::array kNodeRay{Field{"node", false, false, kNone},
                                     Field{"ray", false, false, kNone}};
/// Little endian: the low word comes first.
inline constexpr std::array kPackedHit{Field{"primitive", false, false, kNone},
                                       Field{"t", true, false, 0xffffffffu}};

// What fast arithmetic may change.
inline constexpr Tolerance kExact{};
inline constexpr Tolerance kForks{0.0, 0.02};
inline constexpr Tolerance kFloats{1e-3, 0.02};
inline constexpr Tolerance kImages{1e-3, 0.05};
/// Which of two coincident triangles is hit, and where on it, may change.
inline constexpr Tolerance kDistances{1e-3, 0.02, "t"};

// What only some buffers have.
constexpr BufferTraits of_traversal() { return {.depends_on_timing = true}; }
constexpr BufferTraits written_as(const BufferInfo& other) { return {.written_as = &other}; }
constexpr BufferTraits lengths_of_queues(const BufferInfo* written_as = nullptr) {
    return {.content = Content::lengths, .written_as = written_as, .depends_on_timing = true};
}
constexpr BufferTraits offsets_of_queues(const BufferInfo* written_as = nullptr) {
    return {.content = Content::offsets, .written_as = written_as, .depends_on_timing = true};
}
constexpr BufferTraits queue_of(const BufferInfo& lengths, const BufferInfo& offsets,
                                const BufferInfo* written_as = nullptr) {
    return {.order = BufferOrder::queue,
            .lengths = &lengths,
            .offsets = &offsets,
            .written_as = written_as,
            .depends_on_timing = true};
}
constexpr BufferTraits set_of_pairs(const BufferInfo* written_as = nullptr) {
    return {.order = BufferOrder::set, .written_as = written_as, .depends_on_timing = true};
}
constexpr BufferTraits hit_list_of(const BufferInfo& lengths) {
    return {.order = BufferOrder::hit_list, .lengths = &lengths, .depends_on_timing = true};
}

}  // namespace buffers

}  // namespace scotty::reference
