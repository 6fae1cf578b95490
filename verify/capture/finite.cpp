#include "verify/capture/finite.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <span>

#include "verify/capture/canonical.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::BufferView;
using reference::Field;
using reference::StageView;

namespace {

bool is_wrong(const Field& field, std::uint32_t bits) {
    if (!field.is_float || std::isfinite(std::bit_cast<float>(bits))) return false;
    return !(field.may_be_infinite && bits == buffers::kInfinityBits);
}

class Finder {
 public:
    explicit Finder(const BufferView& buffer)
        : buffer_(buffer), fields_(reference::buffer_info(buffer.name).fields) {}

    std::size_t rows() const { return buffer_.bytes / (sizeof(std::uint32_t) * fields_.size()); }

    /// `owner`: the ray or pixel that the row belongs to.
    void look(std::size_t row, std::size_t owner) {
        if (is_blank(row)) return;
        const std::uint64_t before = found_.values;
        for (std::size_t column = 0; column < fields_.size(); ++column) {
            const std::uint32_t bits = word(row, column);
            if (!is_wrong(fields_[column], bits)) continue;
            if (found_.values++ != 0) continue;
            found_.row = static_cast<std::uint32_t>(owner);
            found_.field = fields_[column].name;
            found_.bits = bits;
        }
        if (found_.values != before) ++found_.rows;
    }
    const NonFiniteValues& found() const { return found_; }

 private:
    std::uint32_t word(std::size_t row, std::size_t column) const {
        return word_at(buffer_, row * fields_.size() + column);
    }
    /// A row of several fields that says "nothing": no hit.
    bool is_blank(std::size_t row) const {
        bool blank = fields_.size() > 1;
        bool says_something = false;
        for (std::size_t column = 0; column < fields_.size(); ++column) {
            blank = blank && word(row, column) == fields_[column].blank;
            says_something = says_something || fields_[column].blank != 0;
        }
        return blank && says_something;
    }

    const BufferView& buffer_;
    std::span<const Field> fields_;
    NonFiniteValues found_;
};

}  // namespace

std::uint32_t word_at(const BufferView& buffer, std::size_t index) {
    std::uint32_t word = 0;
    std::memcpy(&word, static_cast<const std::byte*>(buffer.data) + sizeof word * index,
                sizeof word);
    return word;
}

NonFiniteValues find_non_finite_values(const StageView& stage, const BufferView& output) {
    Finder finder(output);
    if (reference::buffer_info(output.name).order != reference::BufferOrder::hit_list) {
        for (std::size_t row = 0; row < finder.rows(); ++row) finder.look(row, row);
        return finder.found();
    }
    const Regions lists = regions_of(stage, output, true);
    for (std::size_t ray = 0; ray < lists.regions.size(); ++ray) {
        const Regions::Region& list = lists.regions[ray];
        for (std::size_t i = list.begin; i < list.begin + list.count; ++i) finder.look(i, ray);
    }
    return finder.found();
}

}  // namespace scotty::verify
