/// Equality as the contract means it: bit for bit, so that -0 is not 0 and a NaN equals itself.
#pragma once

#include <cstring>
#include <type_traits>

#include "reference/contract/image.h"

namespace scotty::verify {

/// For types without padding.
template <class T>
bool same_bits(const T& a, const T& b) {
    static_assert(std::is_trivially_copyable_v<T>);
    return std::memcmp(&a, &b, sizeof(T)) == 0;
}

inline bool same_pixels(const reference::Image& a, const reference::Image& b) {
    return a.width == b.width && a.height == b.height && a.pixels.size() == b.pixels.size() &&
           (a.pixels.empty() || std::memcmp(a.pixels.data(), b.pixels.data(),
                                            a.pixels.size() * sizeof a.pixels[0]) == 0);
}

}  // namespace scotty::verify
