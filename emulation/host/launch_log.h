/// Launch bookkeeping: names and times.
#pragma once

#include <chrono>
#include <cstdint>

#include "emulation/device/watch.h"
#include "reference/contract/stage_log.h"

namespace scotty::emulation {

using reference::StagePlace;

class LaunchLog : public reference::StageLog {
 public:
    using StageLog::StageLog;

    /// Runs and times one launch.
    template <class Launch>
    void timed(reference::StageKind kind, const StagePlace& place, std::uint32_t blocks,
               std::uint64_t items, Launch&& launch) {
        Watch::name_launch(kind, place, records_.size());
        const auto begin = std::chrono::steady_clock::now();
        launch();
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
        note(kind, place, blocks, items, taken.count());
    }
};

}  // namespace scotty::emulation
