/// The error that ends a launch: threads that do not meet, or one that failed.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "emulation/execution/site.h"
#include "reference/base/error.h"

namespace scotty::emulation::simt {

/// Threads of one block that stopped at one place, or left at one.
struct ThreadGroup {
    const Site* stop;     ///< &kLeft for those that left
    const Site* left_at;  ///< for those that left: the SCOTTY_RETURN; null: the kernel's end
    std::vector<std::uint32_t> threads;  ///< ascending
};

/// "0-31, 40, 42".
std::string thread_list(const std::vector<std::uint32_t>& threads);
/// "threads 0-31 wait at the barrier gpu/kernels/intersect.h:120".
std::string to_text(const ThreadGroup& group);

/// The message names kernel, block and threads, and for a divergence every place.
class LaunchError : public reference::Error {
 public:
    LaunchError(std::string kernel_name, std::uint32_t block_id, std::uint32_t block_size,
                std::vector<ThreadGroup> thread_groups, const std::string& what)
        : Error(reference::ErrorKind::internal,
                "kernel " + kernel_name + ", block " + std::to_string(block_id) + " (" +
                    std::to_string(block_size) + " threads): " + what),
          kernel(std::move(kernel_name)),
          block(block_id),
          groups(std::move(thread_groups)) {}

    std::string kernel;
    std::uint32_t block;
    std::vector<ThreadGroup> groups;  ///< of a divergence
};

}  // namespace scotty::emulation::simt
