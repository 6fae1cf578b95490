#include "emulation/simt/executor.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <string>

#include "emulation/check/bad_address.h"
#include "emulation/simt/interleave/interleaver.h"
#include "emulation/simt/late_stores.h"

namespace scotty::emulation::simt {

Executor::Executor(const SimtOptions& options)
    : options_(options),
      arena_(options.threads == 0 ? oneapi::tbb::task_arena::automatic
                                  : static_cast<int>(options.threads)) {
    catch_bad_addresses();
}

void Executor::run(Launch& launch) {
    if (launch.blocks == 0 || launch.threads == 0 || launch.threads > kMaxThreads) {
        throw reference::Error::internal(
            "kernel " + std::string(launch.kernel) + ": a launch of " +
            std::to_string(launch.blocks) + " blocks of " + std::to_string(launch.threads) +
            " threads; at least one block of 1 to " + std::to_string(kMaxThreads) + " is needed");
    }
    ++launches_;
    if (interleaver_ != nullptr) {
        launch.interleaver = interleaver_;
        interleaver_->run(launch);
        return;
    }
    if (checker_ == nullptr) {
        run_blocks(launch);
        return;
    }
    launch.checker = checker_.get();
    launch.first_block = checker_->begin_launch(launch.kernel, launch.blocks);
    throw_findings_of(*checker_, launch.kernel, launch.threads, [&] { run_blocks(launch); });
}

void Executor::check_memory() { checker_ = std::make_unique<MemoryChecker>(); }

void Executor::run_blocks(Launch& launch) {
    const auto seed_of = [this](std::uint32_t block) {
        return mixed(options_.schedule_seed, launches_, block);
    };
    if (options_.schedule != ScheduleKind::free) {
        const Schedule schedule{options_.schedule, options_.schedule_seed};
        LateStores late_stores(seed_of(0));
        const bool late = options_.schedule == ScheduleKind::adversarial ||
                          options_.schedule == ScheduleKind::shuffled;
        if (late) launch.late_stores = &late_stores;
        for (const std::uint32_t block : block_order(schedule, launches_, launch.blocks)) {
            late_stores.block_starts();
            runners_.local().run(launch, block, options_.schedule, seed_of(block));
        }
        late_loads_ += late_stores.late_loads();
        return;
    }
    // A worker takes blocks of about a thousand threads together at once.
    const std::uint32_t grain = std::max<std::uint32_t>(1, 1024 / launch.threads);
    arena_.execute([&] {
        oneapi::tbb::parallel_for(
            oneapi::tbb::blocked_range<std::uint32_t>(0, launch.blocks, grain),
            [&](const oneapi::tbb::blocked_range<std::uint32_t>& range) {
                BlockRunner& runner = runners_.local();
                for (std::uint32_t block = range.begin(); block != range.end(); ++block) {
                    runner.run(launch, block, ScheduleKind::linear, 0);
                }
            });
    });
}

std::uint64_t Executor::threads_run() const {
    std::uint64_t total = 0;
    for (const BlockRunner& runner : runners_) total += runner.threads_run();
    return total;
}

}  // namespace scotty::emulation::simt
