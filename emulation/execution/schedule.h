/// In which order blocks and threads run: what both tiers of the virtual device are told.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace scotty::emulation {

/// Threads a block may have, as on every CUDA device.
constexpr std::uint32_t kMaxThreads = 1024;

/// `free` leaves it to TBB, on all threads. All others run one block after the other and replay
/// exactly; where threads of a block have an order (the exact tier; the checked volume tier), it
/// follows the same rule.
enum class ScheduleKind {
    free,
    linear,       ///< ascending
    reversed,     ///< descending
    strided,      ///< a square walked column by column: neighbours in time are far apart
    shuffled,     ///< drawn by the seed, anew for every launch and phase
    adversarial,  ///< block_order() says how it hurts
};

struct Schedule {
    ScheduleKind kind = ScheduleKind::free;
    std::uint64_t seed = 0;  ///< of shuffled

    bool operator==(const Schedule&) const = default;
};

/// "free", "linear", "reversed", "strided", "adversarial" or "shuffle:17".
std::string to_string(const Schedule& schedule);
/// Its reverse. Throws bad_input.
Schedule parse_schedule(const std::string& word);

/// The first `count` of linear, reversed, strided, adversarial, shuffle:1, shuffle:2, ...
std::vector<Schedule> seeded_schedules(std::size_t count);

struct DeviceOptions {
    std::size_t threads = 0;  ///< worker threads; 0: all of the machine
    ScheduleKind schedule = ScheduleKind::free;
    std::uint64_t schedule_seed = 0;  ///< for shuffled
};

/// The order of `count` blocks in a launch (1 is the first), as every machine has it.
///
/// adversarial goes through four orders, another at each launch, that break what is easily assumed:
/// block 0 comes last (who waits for it, or has it initialise, loses); the two ends by turns, so
/// that the middle starves; all odd blocks before the even ones, so that every neighbour is late;
/// and the second half before the first. Threads run last first.
std::vector<std::uint32_t> block_order(const Schedule& schedule, std::uint64_t launch,
                                       std::uint32_t count);

}  // namespace scotty::emulation
