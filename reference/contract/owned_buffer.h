/// A named buffer that owns its bytes: what a stage that was run on its own hands back.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "reference/contract/stage_observer.h"

namespace scotty::reference {

struct OwnedBuffer {
    std::string name;
    ElementType type = ElementType::uint32;
    std::vector<std::size_t> shape;
    std::string meaning;
    std::vector<std::byte> bytes;

    /// Valid as long as this is neither changed nor moved.
    BufferView view() const { return {name, type, shape, bytes.data(), meaning, bytes.size()}; }
};

/// A copy of what a view shows.
inline OwnedBuffer own(const BufferView& view) {
    const auto* first = static_cast<const std::byte*>(view.data);
    return {std::string(view.name),
            view.type,
            view.shape,
            std::string(view.meaning),
            {first, first + view.bytes}};
}

}  // namespace scotty::reference
