/// The order in which blocks and threads run, for the emulator and for the CUDA text alike.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace scotty::emulation {

/// The most threads per block, as on every CUDA device.
constexpr std::uint32_t kMaxThreads = 1024;

/// `free` leaves the order to TBB, on all threads. All others run one block after the other and
/// replay exactly. Where threads of a block have an order (in the CUDA text, and in the checked
/// emulator), it follows the same rule.
enum class ScheduleKind {
    free,
    linear,       ///< ascending
    reversed,     ///< descending
    strided,      ///< a square walked column by column: neighbours in time are far apart
    shuffled,     ///< drawn by the seed, anew for every launch and phase
    adversarial,  ///< block_order() describes it
};

struct Schedule {
    ScheduleKind kind = ScheduleKind::free;
    std::uint64_t seed = 0;  ///< used by shuffled

    bool operator==(const Schedule&) const = default;
};

/// "free", "linear", "reversed", "strided", "adversarial" or "shuffle:17".
std::string to_string(const Schedule& schedule);
/// The reverse of to_string(). Throws bad_input.
Schedule parse_schedule(const std::string& word);

/// The first `count` of linear, reversed, strided, adversarial, shuffle:1, shuffle:2, ...
std::vector<Schedule> seeded_schedules(std::size_t count);

struct DeviceOptions {
    std::size_t threads = 0;  ///< worker threads; 0: as many as the machine has
    ScheduleKind schedule = ScheduleKind::free;
    std::uint64_t schedule_seed = 0;  ///< for shuffled
};

/// The order of `count` blocks in a launch (1 is the first), the same on every machine.
///
/// adversarial uses four orders in turn, one per launch, that break common assumptions: block 0
/// comes last (waiting for it, or relying on its initialisation, fails); the two ends alternate, so
/// that the middle starves; all odd blocks precede the even ones, so that every neighbour is late;
/// and the second half precedes the first. Threads run last first.
std::vector<std::uint32_t> block_order(const Schedule& schedule, std::uint64_t launch,
                                       std::uint32_t count);

}  // namespace scotty::emulation
