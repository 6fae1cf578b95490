/// Does the device compute the host's bits? Every operation and numerics function that kernels use.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace scotty::gpu {

struct ParityResult {
    std::string name;
    std::uint64_t tried = 0;
    std::uint64_t mismatches = 0;  ///< results that differ in a bit, NaN against NaN excepted
    std::string first;             ///< operands and both results of the first one, in hex
};

/// `count` operand sets a function: random bits, unit range, and special values (zeros, subnormals,
/// infinities, NaN, powers of two) mixed. Throws missing_environment without a device.
std::vector<ParityResult> test_parity(std::uint64_t count);

}  // namespace scotty::gpu
