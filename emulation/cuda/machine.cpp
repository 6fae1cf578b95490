#include "emulation/cuda/machine.h"

#include <ucontext.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

#include "emulation/check/source_line.h"

namespace scotty::emulation::cuda {

thread_local constinit Thread* current_thread = nullptr;

namespace {

constexpr std::uint32_t kPollsInATurn = 64;
constexpr std::uint32_t kAccessesInATurn = 200000;
/// More threads than this are not on the machine at the same time.
constexpr std::size_t kMostResident = 16384;
/// After so many turns in a row of threads that poll, with no change of memory between, nothing
/// will ever change.
constexpr std::uint64_t kMostIdleTurns = 50000;
constexpr std::uint32_t kMostThreads = 1024;
constexpr std::size_t kMostShared = std::size_t{227} << 10;

std::string text_of(const char* name) {
    const char* const value = std::getenv(name);
    return value == nullptr ? "" : value;
}

std::string dim_text(const Dim& dim) {
    return std::to_string(dim.x) + " x " + std::to_string(dim.y) + " x " + std::to_string(dim.z);
}

sigjmp_buf* way_out = nullptr;
const void* failed_at = nullptr;  ///< the instruction, where the system tells

/// Only code without instrumentation comes here: every other access was looked at before.
void on_bad_address(int signal, siginfo_t*, void* state) {
    failed_at = nullptr;
#if defined(__x86_64__)
    const auto* const context = static_cast<const ucontext_t*>(state);
    // NOLINTNEXTLINE(performance-no-int-to-ptr): the system gives it as a number
    failed_at = reinterpret_cast<const void*>(context->uc_mcontext.gregs[REG_RIP]);
#else
    static_cast<void>(state);
#endif
    if (current_thread != nullptr && way_out != nullptr) ::siglongjmp(*way_out, signal);
    std::signal(signal, SIG_DFL);
    ::raise(signal);
}

void catch_bad_addresses() {
    static std::byte stack[65536];
    stack_t alternate{};
    alternate.ss_sp = stack;
    alternate.ss_size = sizeof stack;
    ::sigaltstack(&alternate, nullptr);
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE}) {
        struct sigaction action {};
        action.sa_sigaction = on_bad_address;
        action.sa_flags = SA_NODEFER | SA_ONSTACK | SA_SIGINFO;
        ::sigaction(signal, &action, nullptr);
    }
}

}  // namespace

Dim block_of(std::uint32_t index, const Dim& grid) {
    return {index % grid.x, index / grid.x % grid.y, index / grid.x / grid.y};
}

Machine& Machine::get() {
    static auto* const machine = new Machine;  // never destroyed: it reports at exit
    return *machine;
}

Machine::Machine() : text_begin_(simt::program_begin()) {
    const std::string schedule = text_of("SCOTTY_CHECK_SCHEDULE");
    schedule_ = parse_schedule(schedule.empty() ? "linear" : schedule);
    report_file_ = text_of("SCOTTY_CHECK_REPORT");
    strict_ = !text_of("SCOTTY_CHECK_STRICT").empty();
    catch_bad_addresses();
    std::atexit([] { Machine::get().finish(); });
}

int Machine::take_error() {
    const int code = error_;
    if (!sticky_) error_ = kNoError;
    return code;
}

void Machine::launch(const LaunchInfo& info, void (*run)(void*), void* arguments) {
    if (sticky_) return;
    const auto threads = std::uint64_t{info.block.x} * info.block.y * info.block.z;
    const auto blocks = std::uint64_t{info.grid.x} * info.grid.y * info.grid.z;
    const char* why = nullptr;
    if (threads == 0 || threads > kMostThreads || info.block.z > 64) {
        why = "a block has 1 to 1024 threads, 64 in z";
    } else if (blocks == 0 || blocks > 0x7fffffffu || info.grid.y > 65535 || info.grid.z > 65535) {
        why = "a grid has 1 to 2147483647 blocks, 65535 in y and z";
    } else if (info.dynamic_shared > kMostShared) {
        why = "a block has 227 KiB of shared memory at most";
    }
    if (why != nullptr) {
        Finding finding;
        finding.kind = FindingKind::launch;
        finding.kernel = info.kernel;
        finding.what = "a grid of " + dim_text(info.grid) + " blocks of " + dim_text(info.block) +
                       " threads with " + std::to_string(info.dynamic_shared) +
                       " bytes of dynamic shared memory: " + why;
        finding.one.place = offset_in_text(info.place);
        finding.one.in_kernel = false;
        finding.one.known = true;
        findings_.add(finding);
        set_error(kInvalidConfiguration);
        return;
    }
    info_ = info;
    run_ = run;
    arguments_ = arguments;
    ++launch_;
    channels_.clear();
    order_ = block_order(schedule_, launch_, static_cast<std::uint32_t>(blocks));
    next_block_ = 0;
    aborted_ = false;
    idle_turns_ = 0;
    way_out = &way_out_;
    const int signal = sigsetjmp(way_out_, 0);
    if (signal != 0) {
        Thread& thread = *current_thread;
        current_thread = nullptr;
        Finding finding;
        finding.kind = signal == SIGFPE ? FindingKind::trap : FindingKind::bounds;
        finding.kernel = info_.kernel;
        finding.what = signal == SIGFPE ? "a division by zero"
                                        : "memory that is not there, or a stack that is full, is "
                                          "used after the place below";
        const bool known = failed_at != nullptr;
        const std::uint32_t place =
            known ? offset_in_text(static_cast<const char*>(failed_at) + 1) : thread.last_place;
        finding.one = actor(thread, place, "fails");
        findings_.add(finding);
        set_error(kIllegalAddress);
        sticky_ = true;
        aborted_ = true;
    } else {
        run_grid();
    }
    way_out = nullptr;
    while (!resident_.empty()) {
        end_block(resident_.front().release());
        resident_.pop_front();
    }
}

void Machine::run_grid() {
    while (!aborted_ && (next_block_ < order_.size() || !resident_.empty())) {
        // A block that can run comes first, and a new one where the others only poll.
        const bool room = resident_threads_ < kMostResident;
        if (next_block_ < order_.size() && room) {
            resident_.emplace_front(begin_block(order_[next_block_++]));
        } else if (waits_for_ever()) {
            report_endless();
            return;
        }
        for (std::size_t i = 0; i < resident_.size() && !aborted_;) {
            Block& block = *resident_[i];
            if (run_block(block)) {
                end_block(resident_[i].release());
                resident_.erase(resident_.begin() + static_cast<std::ptrdiff_t>(i));
            } else {
                ++i;
            }
        }
    }
}

Block* Machine::begin_block(std::uint32_t index) {
    if (free_blocks_.empty()) free_blocks_.push_back(std::make_unique<Block>());
    Block* const block = free_blocks_.back().release();
    free_blocks_.pop_back();
    const std::size_t threads = std::size_t{info_.block.x} * info_.block.y * info_.block.z;
    block->index = index;
    block->at = block_of(index, info_.grid);
    block->base = 1;
    block->abandoned = false;
    block->asks_active = false;
    block->has_left = false;
    block->pass = 0;
    block->objects.clear();
    block->shared_used = 0;
    block->threads.assign(threads, {});
    for (std::uint32_t i = 0; i < threads; ++i) {
        Thread& thread = block->threads[i];
        thread.block = block;
        thread.index = i;
        thread.at = block_of(i, info_.block);
        thread.stack = stacks_.take();
        if (thread.stack == nullptr) {
            std::fputs("scotty: error: no address space for the stacks of the threads\n", stderr);
            std::_Exit(3);
        }
        begin_on(*thread.stack, &Machine::thread_entry);
    }
    resident_threads_ += threads;
    return block;
}

void Machine::end_block(Block* block) {
    for (Thread& thread : block->threads) {
        if (thread.stack != nullptr) stacks_.give_back(thread.stack);
    }
    resident_threads_ -= block->threads.size();
    for (Cell& cell : block->cells) {
        if (cell.more != nullptr) clear(cell);
    }
    free_blocks_.emplace_back(block);
}

void Machine::thread_entry() {
    Machine& machine = get();
    try {
        machine.run_(machine.arguments_);
    } catch (const std::exception& error) {
        machine.end_thread(FindingKind::trap, std::string("an exception: ") + error.what(),
                           current_thread->last_place, kLaunchFailure);
    }
    Thread& thread = *current_thread;
    thread.block->has_left = true;
    thread.state = thread.left_said ? ThreadState::left_early : ThreadState::left_at_end;
    ++machine.changes_;
    machine.close_writes(thread);
    machine.stop();
    std::abort();  // nobody switches to a thread that has left
}

void Machine::resume(Thread& thread) {
    current_thread = &thread;
    thread.polls = 0;
    thread.accesses = 0;
    scotty_cuda::show_place(thread.at, thread.block->at);
    switch_stacks(scheduler_, *thread.stack);
    current_thread = nullptr;
}

void Machine::stop() { switch_stacks(*current_thread->stack, scheduler_); }

void Machine::give_way() {
    Thread& thread = *current_thread;
    close_writes(thread);
    thread.waits_for_others = true;
    stop();
    thread.waits_for_others = false;
}

void Machine::may_poll(Thread& thread) {
    if (thread.polls >= kPollsInATurn || thread.accesses >= kAccessesInATurn) give_way();
}

bool Machine::run_block(Block& block) {
    const auto warps = static_cast<std::uint32_t>((block.threads.size() + kWarp - 1) / kWarp);
    const std::uint64_t seed =
        simt::mixed(schedule_.seed, launch_, std::uint64_t{block.index} << 20 ^ block.pass++);
    thread_order_.start_block(schedule_.kind, seed, warps);
    for (;;) {
        thread_order_.start_phase();
        const Turns turns = run_ready_threads(block, warps);
        if (aborted_) return true;
        if (turns.ready != 0) {
            if (turns.polls) return false;
            continue;
        }
        if (release_active(block)) continue;
        if (release_barrier(block)) continue;
        return true;  // all have left, or wait for each other
    }
}

Machine::Turns Machine::run_ready_threads(Block& block, std::uint32_t warps) {
    Turns turns;
    for (std::uint32_t i = 0; i < warps; ++i) {
        const std::uint32_t base = thread_order_.warp_order[i] * kWarp;
        std::uint32_t ready = 0;
        do {
            ready = 0;
            bool all_poll = true;
            block.waits_in_warp = false;
            for (const std::uint8_t lane : thread_order_.lane_order) {
                const std::uint32_t index = base + lane;
                if (index >= block.threads.size()) continue;
                Thread& thread = block.threads[index];
                if (thread.state == ThreadState::ready) {
                    resume(thread);
                    if (aborted_) return turns;
                    if (thread.waits_for_others) {
                        // A turn of plain accesses is as long as many of polls.
                        idle_turns_ += thread.accesses >= kAccessesInATurn ? 2000 : 1;
                    } else {
                        all_poll = false;
                    }
                }
                if (thread.state == ThreadState::ready) ++ready;
                if (thread.state == ThreadState::at_warp_operation) block.waits_in_warp = true;
            }
            turns.polls &= all_poll;
        } while (block.waits_in_warp && release_warp(block, base / kWarp));
        turns.ready += ready;
    }
    return turns;
}

bool Machine::waits_for_ever() {
    if (changes_ != changes_seen_) idle_turns_ = 0;
    changes_seen_ = changes_;
    return idle_turns_ > kMostIdleTurns;
}

void Machine::report_endless() {
    for (const auto& block : resident_) {
        for (const Thread& thread : block->threads) {
            if (thread.state != ThreadState::ready) continue;
            Finding finding;
            finding.kind = FindingKind::endless;
            finding.kernel = info_.kernel;
            finding.what = next_block_ < order_.size()
                               ? "threads wait in a loop for a block that has no room to run yet"
                               : "threads wait in a loop for what nobody will do";
            finding.one = actor(thread, thread.last_place, "polls memory");
            for (const Thread& other : block->threads) {
                if (other.has_left() || other.state == ThreadState::ready) continue;
                finding.other = actor(other, other.place, "waits");
                break;
            }
            findings_.add(finding);
        }
    }
    set_error(kLaunchTimeout);
    sticky_ = true;
    aborted_ = true;
}

void Machine::end_thread(FindingKind kind, const std::string& why, std::uint32_t place, int code) {
    Finding finding;
    finding.kind = kind;
    finding.kernel = info_.kernel;
    finding.what = why;
    finding.one = actor(*current_thread, place, "fails");
    report_unsure_reads(*current_thread);
    findings_.add(finding);
    set_error(code);
    sticky_ = true;
    aborted_ = true;
    stop();
    std::abort();
}

void Machine::leave(int) { current_thread->left_said = true; }

void Machine::finish() {
    if (std::exchange(finished_, true)) return;
    for (const auto& [begin, region] : memory_.regions()) {
        if (region->freed || !region->leak_of_interest) continue;
        Finding finding;
        finding.kind = FindingKind::leak;
        finding.what = std::to_string(region->bytes) + " bytes are never freed";
        finding.one.known = true;
        finding.one.in_kernel = false;
        finding.one.place = region->place;
        findings_.add(finding);
    }
    std::fflush(stdout);
    if (report_file_.empty()) {
        if (findings_.size() == 0) return;
        std::fputs(findings_.to_text().c_str(), stderr);
        if (!findings_.passes()) std::_Exit(1);
        return;
    }
    std::FILE* const file = std::fopen(report_file_.c_str(), "w");
    if (file == nullptr) return;
    const std::string text = findings_.to_json();
    std::fwrite(text.data(), 1, text.size(), file);
    std::fclose(file);
}

}  // namespace scotty::emulation::cuda
