/// Counter-based random numbers: Philox-4x32-10 (Salmon et al. 2011) from Random123.
///
/// Keyed by seed, counted by (pixel, sample, bounce, dimension): no state, so no thread can share
/// or skip one, and any ray's numbers can be recomputed on their own.
#pragma once

#include <Random123/philox.h>

#include <cstdint>

#include "reference/base/host_device.h"

namespace scotty::reference {

/// What a number is used for. Two uses never share a counter.
enum class Dimension : std::uint32_t {
    camera = 0,  ///< jitter inside the pixel
    scatter = 1,
    light = 16  ///< light + i for direct-light sample i
};

/// Four numbers in [0, 1), multiples of 2^-24.
struct Random4 {
    float a, b, c, d;
};

SCOTTY_HD float to_unit_interval(std::uint32_t bits) {
    return static_cast<float>(bits >> 8) * 5.9604644775390625e-8f;  // 2^-24
}

SCOTTY_HD Random4 random4(std::uint64_t seed, std::uint32_t pixel, std::uint32_t sample,
                          std::uint32_t bounce, std::uint32_t dimension) {
    philox4x32_ctr_t counter;
    counter.v[0] = pixel;
    counter.v[1] = sample;
    counter.v[2] = bounce;
    counter.v[3] = dimension;
    philox4x32_key_t key;
    key.v[0] = static_cast<std::uint32_t>(seed);
    key.v[1] = static_cast<std::uint32_t>(seed >> 32);
    const philox4x32_ctr_t bits = philox4x32_R(10, counter, key);
    return {to_unit_interval(bits.v[0]), to_unit_interval(bits.v[1]), to_unit_interval(bits.v[2]),
            to_unit_interval(bits.v[3])};
}

}  // namespace scotty::reference
