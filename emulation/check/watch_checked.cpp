#include "emulation/check/watch_checked.h"

// Only programs that check contain this: it is compiled with SCOTTY_CHECKED, not instrumented.
#include <utility>

#include "emulation/execution/launch_error.h"
#include "emulation/execution/thread_order.h"

namespace scotty::emulation {

using simt::context;

namespace {

std::string& launch_name() {
    static thread_local std::string name = "kernel";
    return name;
}
simt::MemoryChecker*& latest_checker() {
    static thread_local simt::MemoryChecker* checker = nullptr;
    return checker;
}
/// The order of the block that runs on this worker.
thread_local Turns turns;

}  // namespace

Watch::Watch() : checker_(std::make_unique<simt::MemoryChecker>()) { simt::catch_bad_addresses(); }
Watch::~Watch() {
    if (latest_checker() == checker_.get()) latest_checker() = nullptr;
}

simt::MemoryChecker* Watch::latest() { return latest_checker(); }

Watch::InBlock::InBlock(Watch& watch, std::uint32_t index, std::uint32_t threads) {
    Worker& worker = watch.workers_.local();
    worker.shared.reset();
    context = {};
    context.block = index;
    context.block_size = threads;
    context.checker = watch.checker_.get();
    context.first_block = watch.first_block_;
    context.shared = &worker.shared;
    context.shared_shadow = worker.shadow.data();
    turns = watch.turns_;
}

Watch::InBlock::~InBlock() {
    if (context.checker != nullptr) context.checker->end_block(context);
    context = {};
}

void Watch::name_launch(reference::StageKind kind, const reference::StagePlace& place,
                        std::size_t launch) {
    launch_name() = std::string(to_string(kind)) + " of launch " + std::to_string(launch) + " " +
                    place.name(kind);
}

void Watch::run_launch(std::uint32_t blocks, std::uint32_t threads, const Schedule& schedule,
                       std::uint64_t launch, const std::function<void()>& run) {
    kernel_ = launch_name();
    threads_ = threads;
    first_block_ = checker_->begin_launch(kernel_.c_str(), blocks);
    latest_checker() = checker_.get();
    turns_ = {schedule, launch};
    simt::throw_findings_of(*checker_, kernel_, threads, run);
}

void Watch::fail_block(const std::string& why) const {
    throw simt::LaunchError(kernel_, context.block, threads_, {}, why);
}

bool Watch::is_ascending() {
    return turns.schedule.kind == ScheduleKind::free || turns.schedule.kind == ScheduleKind::linear;
}

std::uint32_t Watch::turn(std::uint32_t i, std::uint32_t active) {
    switch (turns.schedule.kind) {
        case ScheduleKind::reversed:
        case ScheduleKind::adversarial:
            return active - 1 - i;
        case ScheduleKind::strided: {
            const std::uint32_t even = (active + 1) / 2;
            return i < even ? 2 * i : 2 * (i - even) + 1;
        }
        case ScheduleKind::shuffled: {
            // Every phase starts elsewhere and goes either way round, which is cheap.
            const std::uint64_t drawn =
                simt::mixed(turns.schedule.seed, turns.launch,
                            std::uint64_t{context.block} << 20 ^ context.phase);
            const auto start = static_cast<std::uint32_t>((drawn >> 1) % active);
            const std::uint32_t at = i + start < active ? i + start : i + start - active;
            return (drawn & 1u) != 0 ? active - 1 - at : at;
        }
        default:
            return i;
    }
}

void Watch::begin_registers() {
    context.on_registers = std::exchange(context.checker, nullptr);
    context.thread = simt::kSomeOther;
}
void Watch::end_registers() { context.checker = std::exchange(context.on_registers, nullptr); }

void Watch::foreign_register(std::uint32_t owner) {
    simt::MemoryChecker* const checker =
        context.checker != nullptr ? context.checker : context.on_registers;
    if (checker == nullptr) return;
    checker->report_register(context, owner, __builtin_return_address(0));
}

}  // namespace scotty::emulation
