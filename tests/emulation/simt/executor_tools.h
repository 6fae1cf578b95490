/// Shared by the tests of the executor.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "emulation/simt/executor.h"
#include "gpu/kernels/dialect.h"
#include "tests/catch.h"

namespace scotty::simt::test {

using emulation::ScheduleKind;
using emulation::simt::Executor;
using emulation::simt::LaunchError;
using emulation::simt::SimtOptions;
using emulation::simt::ThreadGroup;

/// Every order of blocks and threads.
inline std::vector<SimtOptions> every_order() {
    return {{1, ScheduleKind::free, 0},     {2, ScheduleKind::free, 0},
            {0, ScheduleKind::linear, 0},   {0, ScheduleKind::reversed, 0},
            {0, ScheduleKind::strided, 0},  {0, ScheduleKind::adversarial, 0},
            {0, ScheduleKind::shuffled, 1}, {0, ScheduleKind::shuffled, 2}};
}

/// The error that a launch throws.
inline LaunchError error_of(const std::function<void()>& launch) {
    try {
        launch();
    } catch (const LaunchError& error) {
        return error;
    }
    FAIL("the launch did not fail");
    return {"", 0, 0, {}, ""};
}

}  // namespace scotty::simt::test
