#include "emulation/simt/executor.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <exception>
#include <numeric>
#include <string>
#include <thread>

#include "emulation/simt/crash_report.h"

namespace scotty::emulation::simt {

Executor::Executor(const SimtOptions& options)
    : options_(options),
      arena_(options.threads == 0 ? oneapi::tbb::task_arena::automatic
                                  : static_cast<int>(options.threads)) {
    report_crashes();
}

void Executor::run(Launch& launch) {
    if (launch.blocks == 0 || launch.threads == 0 || launch.threads > kMaxThreads) {
        throw reference::Error::internal(
            "kernel " + std::string(launch.kernel) + ": a launch of " +
            std::to_string(launch.blocks) + " blocks of " + std::to_string(launch.threads) +
            " threads; at least one block of 1 to " + std::to_string(kMaxThreads) + " is needed");
    }
    launch.observer = observer_;
    ++launches_;
    const auto seed_of = [this](std::uint32_t block) {
        return mixed(options_.schedule_seed, launches_, block);
    };
    if (options_.schedule != ScheduleKind::free) {
        for (const std::uint32_t block : block_order(launch.blocks)) {
            runners_.local().run(launch, block, options_.schedule, seed_of(block));
        }
        return;
    }
#if defined(SCOTTY_PLAIN_THREADS)
    run_on_plain_threads(launch);
#else
    // A worker takes about a thousand threads' work at once.
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
#endif
}

#if defined(SCOTTY_PLAIN_THREADS)
/// The thread sanitizer cannot see how TBB hands work on, but it knows what starting and joining a
/// thread mean: launches are ordered, blocks of one launch on different threads are not.
void Executor::run_on_plain_threads(const Launch& launch) {
    constexpr std::uint32_t kWorkers = 3;
    std::vector<std::exception_ptr> errors(kWorkers);
    std::vector<std::thread> workers;
    for (std::uint32_t worker = 0; worker < kWorkers; ++worker) {
        workers.emplace_back([&, worker] {
            try {
                BlockRunner runner;
                for (std::uint32_t block = worker; block < launch.blocks; block += kWorkers) {
                    runner.run(launch, block, ScheduleKind::linear, 0);
                }
            } catch (...) {
                errors[worker] = std::current_exception();
            }
        });
    }
    for (std::thread& worker : workers) worker.join();
    for (const std::exception_ptr& error : errors) {
        if (error) std::rethrow_exception(error);
    }
}
#endif

std::vector<std::uint32_t> Executor::block_order(std::uint32_t blocks) const {
    std::vector<std::uint32_t> order(blocks);
    std::iota(order.begin(), order.end(), 0u);
    if (options_.schedule == ScheduleKind::reversed) std::reverse(order.begin(), order.end());
    if (options_.schedule == ScheduleKind::shuffled) {
        std::mt19937_64 generator(mixed(options_.schedule_seed, launches_, ~std::uint64_t{0}));
        shuffle(order.begin(), order.end(), generator);
    }
    return order;
}

std::uint64_t Executor::threads_run() const {
    std::uint64_t total = 0;
    for (const BlockRunner& runner : runners_) total += runner.threads_run();
    return total;
}

}  // namespace scotty::emulation::simt
