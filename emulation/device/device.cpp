#include "emulation/device/device.h"

namespace scotty::emulation {

Device::Device(const DeviceOptions& options)
    : options_(options),
      arena_(options.threads == 0 ? oneapi::tbb::task_arena::automatic
                                  : static_cast<int>(options.threads)) {}

}  // namespace scotty::emulation
