/// Smooth value noise on an integer hash: the same numbers on every machine.
#pragma once

#include <cmath>
#include <cstdint>

namespace scotty::scenes {

/// 32 well-mixed bits (Wellons' lowbias32).
inline std::uint32_t hash32(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

/// A number in [-1, 1) for each (i, seed).
inline double signed_hash(std::uint32_t i, std::uint32_t seed) {
    return static_cast<double>(hash32(i ^ hash32(seed + 0x9e3779b9u))) / 2147483648.0 - 1.0;
}

/// Value noise in [-1, 1], with continuous second derivatives.
inline double value_noise(double x, double y, double z, std::uint32_t seed) {
    const double fx = std::floor(x);
    const double fy = std::floor(y);
    const double fz = std::floor(z);
    const auto ease = [](double t) { return t * t * t * (t * (t * 6.0 - 15.0) + 10.0); };
    const double weight[3] = {ease(x - fx), ease(y - fy), ease(z - fz)};
    const auto cell = [](double f) {
        return static_cast<std::uint32_t>(static_cast<std::int64_t>(f));
    };
    const std::uint32_t ix = cell(fx);
    const std::uint32_t iy = cell(fy);
    const std::uint32_t iz = cell(fz);
    double sum = 0.0;
    for (std::uint32_t corner = 0; corner < 8; ++corner) {
        const std::uint32_t dx = corner & 1u;
        const std::uint32_t dy = corner >> 1 & 1u;
        const std::uint32_t dz = corner >> 2;
        const std::uint32_t key = hash32(hash32(ix + dx) + 31u * (iy + dy)) + 17u * (iz + dz);
        sum += signed_hash(key, seed) * (dx ? weight[0] : 1.0 - weight[0]) *
               (dy ? weight[1] : 1.0 - weight[1]) * (dz ? weight[2] : 1.0 - weight[2]);
    }
    return sum;
}

}  // namespace scotty::scenes
