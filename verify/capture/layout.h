/// Between this room's types and those of capture_layout.h, which other programs use too.
#pragma once

#include "reference/base/error.h"
#include "reference/contract/records.h"
#include "reference/contract/stage_observer.h"
#include "verify/capture/include/scotty/capture_layout.h"

namespace scotty::verify {

/// Calls f; what capture_layout.h throws becomes bad_input.
template <class F>
decltype(auto) as_bad_input(const F& f) {
    try {
        return f();
    } catch (const capture::Error& error) {
        throw reference::Error::bad_input(error.where(), error.complaint());
    }
}

constexpr capture::Type layout_type(reference::ElementType type) {
    switch (type) {
        case reference::ElementType::uint8:
            return capture::Type::uint8;
        case reference::ElementType::uint64:
            return capture::Type::uint64;
        case reference::ElementType::float32:
            return capture::Type::float32;
        case reference::ElementType::uint32:
            break;
    }
    return capture::Type::uint32;
}

}  // namespace scotty::verify
