#include "emulation/device.h"

#include <numeric>
#include <random>

namespace scotty::emulation {

Device::Device(const DeviceOptions& options)
    : options_(options),
      arena_(options.threads == 0 ? oneapi::tbb::task_arena::automatic
                                  : static_cast<int>(options.threads)) {}

std::vector<std::uint32_t> Device::block_order(std::uint32_t blocks) {
    std::vector<std::uint32_t> order(blocks);
    std::iota(order.begin(), order.end(), 0u);
    if (options_.schedule == ScheduleKind::reversed) std::reverse(order.begin(), order.end());
    if (options_.schedule == ScheduleKind::shuffled) {
        std::mt19937_64 generator(options_.schedule_seed + 0x9e3779b97f4a7c15ull * ++launches_);
        // Not std::shuffle: its order is the library's choice, and a seed must replay everywhere.
        for (std::size_t left = order.size(); left > 1; --left) {
            std::swap(order[left - 1], order[generator() % left]);
        }
    }
    return order;
}

}  // namespace scotty::emulation
