/// Which values of a buffer must be finite and are not, by the table in
/// reference/contract/buffers.h.
///
/// Every float of an output must be finite, except where the table says that +infinity has a
/// meaning, and in rows that are blank ("no hit"). Of hit lists only the entries in use count.
#pragma once

#include <cstdint>
#include <string_view>

#include "reference/contract/stage_observer.h"

namespace scotty::verify {

struct NonFiniteValues {
    std::uint64_t values = 0;
    std::uint64_t rows = 0;  ///< that hold such a value; of a hit list, entries
    // Of the first, where there is one.
    std::uint32_t row = 0;  ///< a ray, or a pixel of an image
    std::string_view field;
    std::uint32_t bits = 0;
};
NonFiniteValues find_non_finite_values(const reference::StageView& stage,
                                       const reference::BufferView& output);

/// The 4-byte word at an index, as it lies there.
std::uint32_t word_at(const reference::BufferView& buffer, std::size_t index);

}  // namespace scotty::verify
