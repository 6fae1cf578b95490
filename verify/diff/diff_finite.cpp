/// What must be finite and is not.
///
/// Every float of an output must be, but for these, where +infinity says something:
///  - t_max of a ray: no limit
///  - t of a hit of a ray that hits nothing (primitive 0xffffffff)
///  - the nearest distance known (minimum, lowered): none so far
/// Of hit lists only the entries in use count; a packed hit of all ones is "none".
#include <bit>
#include <cmath>
#include <cstring>

#include "reference/contract/records.h"
#include "verify/diff/diff_parts.h"

namespace scotty::verify {

using reference::BufferView;
using reference::StageView;

namespace {

bool is_positive_infinity(std::uint32_t bits) { return bits == 0x7f800000u; }

/// Whether +infinity has a meaning in that field of that row.
bool may_be_infinite(const BufferView& buffer, const Field& field, std::size_t row) {
    const std::string_view name = buffer.name;
    const std::string_view which = field.name;
    if (name == "rays" || name == "shadow_rays") return which == "t_max";
    if (name == "merged") return which == "t" && word_at(buffer, 4 * row + 1) == reference::kNone;
    return name == "minimum" || name == "lowered";
}

bool is_none(const BufferView& buffer, std::size_t row) {
    return buffer.name == "packed_hits" && word_at(buffer, 2 * row) == reference::kNone &&
           word_at(buffer, 2 * row + 1) == 0xffffffffu;
}

class Finder {
 public:
    Finder(const StageView& stage, const BufferView& buffer)
        : buffer_(buffer), layout_(layout_of(buffer.name)) {
        found_.stage = stage.name;
        found_.launch = stage.launch;
        found_.buffer = buffer.name;
    }

    void look(std::size_t row, std::size_t column, std::uint32_t bits, std::uint32_t owner) {
        const Field& field = layout_.fields[column];
        if (!field.is_float || std::isfinite(std::bit_cast<float>(bits))) return;
        if (is_positive_infinity(bits) && may_be_infinite(buffer_, field, row)) return;
        if (found_.values++ != 0) return;
        found_.first_row = owner;
        found_.field = field.name;
        found_.value = value_text(bits, true);
    }

    std::optional<NonFinite> take() && {
        if (found_.values == 0) return std::nullopt;
        return std::move(found_);
    }

 private:
    const BufferView& buffer_;
    const Layout& layout_;
    NonFinite found_;
};

}  // namespace

std::optional<NonFinite> find_non_finite(const StageView& stage, const BufferView& output) {
    const Layout& layout = layout_of(output.name);
    const std::size_t columns = layout.fields.size();
    Finder finder(stage, output);
    if (output.name == "hits") {
        const Regions lists = regions_of(stage, output, true);
        for (std::size_t ray = 0; ray < lists.regions.size(); ++ray) {
            const Regions::Region& list = lists.regions[ray];
            for (std::size_t slot = list.begin; slot < list.begin + list.count; ++slot) {
                finder.look(slot, 0, word_at(output, 2 * slot), static_cast<std::uint32_t>(ray));
            }
        }
        return std::move(finder).take();
    }
    const std::size_t rows = output.bytes / (sizeof(std::uint32_t) * columns);
    for (std::size_t row = 0; row < rows; ++row) {
        if (is_none(output, row)) continue;
        for (std::size_t column = 0; column < columns; ++column) {
            finder.look(row, column, word_at(output, row * columns + column),
                        static_cast<std::uint32_t>(row));
        }
    }
    return std::move(finder).take();
}

}  // namespace scotty::verify
