// Barriers, warp operations, atomics and fences: who waits for whom, and who knows what then.
#include <algorithm>
#include <bit>
#include <cstdio>
#include <utility>

#include "emulation/cuda/machine.h"
#include "emulation/execution/launch_error.h"

namespace scotty::emulation::cuda {

namespace {

bool waits_in(const Thread& thread, scotty_cuda::WarpOperation operation, std::uint32_t mask) {
    return thread.state == ThreadState::at_warp_operation && thread.operation == operation &&
           thread.mask == mask;
}

std::uint64_t combine(scotty_cuda::WarpOperation operation, std::uint64_t one,
                      std::uint64_t other) {
    using Op = scotty_cuda::WarpOperation;
    const auto signed_of = [](std::uint64_t value) { return static_cast<std::int64_t>(value); };
    switch (operation) {
        case Op::add:
            return one + other;
        case Op::min_signed:
            return signed_of(one) < signed_of(other) ? one : other;
        case Op::max_signed:
            return signed_of(one) > signed_of(other) ? one : other;
        case Op::min_unsigned:
            return std::min(one, other);
        case Op::max_unsigned:
            return std::max(one, other);
        case Op::bit_and:
            return one & other;
        case Op::bit_or:
            return one | other;
        default:
            return one ^ other;
    }
}

/// The lane that a shuffle reads; its own where that is outside its group.
std::uint32_t source_lane(const Thread& thread) {
    using Op = scotty_cuda::WarpOperation;
    const std::uint32_t lane = thread.lane();
    const std::uint32_t first = lane & ~(thread.width - 1);
    const std::uint32_t last = first + thread.width - 1;
    switch (thread.operation) {
        case Op::shuffle:
            return first + (thread.parameter & (thread.width - 1));
        case Op::shuffle_up:
            return lane < first + thread.parameter ? lane : lane - thread.parameter;
        case Op::shuffle_down:
            return lane + thread.parameter > last ? lane : lane + thread.parameter;
        default:
            return (lane ^ thread.parameter) > last ? lane : lane ^ thread.parameter;
    }
}

}  // namespace

int Machine::barrier(Barrier kind, int predicate, const void* place) {
    Thread& thread = *current_thread;
    close_writes(thread);
    thread.state = ThreadState::at_barrier;
    thread.barrier = static_cast<std::uint8_t>(kind);
    thread.value_of_barrier = predicate != 0 ? 1 : 0;
    thread.place = offset_in_text(place);
    stop();
    return static_cast<int>(thread.result_of_barrier);
}

std::uint64_t Machine::warp(scotty_cuda::WarpOperation operation, std::uint32_t mask,
                            std::uint64_t value, std::uint32_t parameter, std::uint32_t width,
                            int* flag, const void* place) {
    Thread& thread = *current_thread;
    close_writes(thread);
    thread.operation = operation;
    thread.mask = mask;
    thread.value = value;
    thread.parameter = parameter;
    thread.width = width;
    thread.place = offset_in_text(place);
    if (operation == scotty_cuda::WarpOperation::active) thread.block->asks_active = true;
    if (operation != scotty_cuda::WarpOperation::active && (mask >> thread.lane() & 1u) == 0) {
        char bits[16];
        std::snprintf(bits, sizeof bits, "0x%08x", mask);
        Finding finding;
        finding.kind = FindingKind::divergence;
        finding.kernel = info_.kernel;
        finding.what =
            std::string("a warp operation is called by a lane that is not in its mask, ") + bits;
        finding.one = actor(thread, thread.place, "calls it");
        findings_.add(finding);
        thread.mask = mask | 1u << thread.lane();
    }
    thread.state = ThreadState::at_warp_operation;
    stop();
    if (flag != nullptr) *flag = thread.result_flag ? 1 : 0;
    return thread.result;
}

bool Machine::release_warp(Block& block, std::uint32_t warp) {
    const std::uint32_t base = warp * kWarp;
    const auto lanes =
        std::min<std::uint32_t>(kWarp, static_cast<std::uint32_t>(block.threads.size()) - base);
    bool released = false;
    for (std::uint32_t first = 0; first < lanes; ++first) {
        const Thread& thread = block.threads[base + first];
        if (thread.state != ThreadState::at_warp_operation ||
            thread.operation == scotty_cuda::WarpOperation::active) {
            continue;
        }
        std::uint32_t there = 0;
        bool complete_group = true;
        for (std::uint32_t lane = 0; lane < lanes; ++lane) {
            if ((thread.mask >> lane & 1u) == 0) continue;
            const Thread& other = block.threads[base + lane];
            if (other.has_left()) continue;
            if (waits_in(other, thread.operation, thread.mask)) {
                there |= 1u << lane;
            } else {
                complete_group = false;
                break;
            }
        }
        if (!complete_group) continue;
        complete(block, warp, there, thread.mask);
        released = true;
    }
    return released;
}

void Machine::complete(Block& block, std::uint32_t warp, std::uint32_t lanes, std::uint32_t) {
    using Op = scotty_cuda::WarpOperation;
    Thread* const threads = block.threads.data() + std::size_t{warp} * kWarp;
    const auto each = [&](const auto& body) {
        for (std::uint32_t bits = lanes; bits != 0; bits &= bits - 1) {
            body(threads[std::countr_zero(bits)]);
        }
    };
    const Op operation = threads[std::countr_zero(lanes)].operation;
    std::uint32_t yes = 0;
    std::uint64_t total = threads[std::countr_zero(lanes)].value;
    bool all_equal = true;
    bool is_first = true;
    each([&](const Thread& thread) {
        if (thread.value != 0) yes |= 1u << thread.lane();
        all_equal &= thread.value == threads[std::countr_zero(lanes)].value;
        if (!std::exchange(is_first, false)) total = combine(operation, total, thread.value);
    });
    each([&](Thread& thread) {
        switch (operation) {
            case Op::sync:
                break;
            case Op::shuffle:
            case Op::shuffle_up:
            case Op::shuffle_down:
            case Op::shuffle_xor: {
                const std::uint32_t from = source_lane(thread);
                const bool there = (lanes >> from & 1u) != 0;
                thread.result = there ? threads[from].value : thread.value;
                thread.result_flag = from != thread.lane();
                break;
            }
            case Op::ballot:
                thread.result = yes;
                break;
            case Op::any:
                thread.result = yes != 0 ? 1 : 0;
                break;
            case Op::all:
                thread.result = yes == lanes ? 1 : 0;
                break;
            case Op::match_any: {
                std::uint32_t same = 0;
                each([&](const Thread& other) {
                    if (other.value == thread.value) same |= 1u << other.lane();
                });
                thread.result = same;
                break;
            }
            case Op::match_all:
                thread.result = all_equal ? lanes : 0;
                thread.result_flag = all_equal;
                break;
            case Op::active:
                thread.result = lanes;
                break;
            default:
                thread.result = total;
                break;
        }
    });
    if (operation == Op::sync) join_lanes(block, warp, lanes);
    each([](Thread& thread) { thread.state = ThreadState::ready; });
}

bool Machine::release_active(Block& block) {
    if (!std::exchange(block.asks_active, false)) return false;
    bool released = false;
    for (std::size_t i = 0; i < block.threads.size(); ++i) {
        const Thread& thread = block.threads[i];
        if (!waits_in(thread, scotty_cuda::WarpOperation::active, thread.mask)) continue;
        std::uint32_t lanes = 0;
        const std::size_t base = i / kWarp * kWarp;
        for (std::size_t other = base; other < std::min(base + kWarp, block.threads.size());
             ++other) {
            const Thread& there = block.threads[other];
            if (waits_in(there, scotty_cuda::WarpOperation::active, there.mask) &&
                there.place == thread.place) {
                lanes |= 1u << (other - base);
            }
        }
        complete(block, static_cast<std::uint32_t>(i / kWarp), lanes, lanes);
        released = true;
    }
    return released;
}

bool Machine::release_barrier(Block& block) {
    const Thread* first = nullptr;
    bool all_there = true;
    bool one_place = true;
    bool knows_more = false;
    std::uint32_t latest = 0;
    std::uint32_t count = 0;
    std::uint32_t waiting = 0;
    for (const Thread& thread : block.threads) {
        if (thread.has_left()) continue;
        if (thread.state != ThreadState::at_barrier) {
            all_there = false;
            continue;
        }
        if (first == nullptr) first = &thread;
        one_place &= thread.place == first->place && thread.barrier == first->barrier;
        latest = std::max(latest, thread.clock);
        knows_more |= thread.knows_more;
        ++waiting;
        count += thread.value_of_barrier;
    }
    if (first == nullptr && all_there) return false;  // all have left
    if (!all_there) {
        report_parted(block, "threads wait for each other at different places");
        block.abandoned = true;
        set_error(kLaunchFailure);
        return false;
    }
    if (!one_place) report_parted(block, "threads of one block wait at different barriers");
    if (block.has_left) report_leavers(block);
    if (knows_more) join_block(block);
    block.base = latest + 1;
    for (Thread& thread : block.threads) {
        if (thread.has_left()) continue;
        thread.clock = block.base;
        thread.state = ThreadState::ready;
        switch (static_cast<Barrier>(thread.barrier)) {
            case Barrier::all:
                thread.result_of_barrier = count == waiting ? 1 : 0;
                break;
            case Barrier::any:
                thread.result_of_barrier = count != 0 ? 1 : 0;
                break;
            default:
                thread.result_of_barrier = count;
                break;
        }
    }
    ++changes_;
    return true;
}

void Machine::report_parted(Block& block, const std::string& what) {
    // One thread of each place, against the first.
    std::map<std::pair<int, std::uint32_t>, std::vector<std::uint32_t>> groups;
    for (const Thread& thread : block.threads) {
        groups[{static_cast<int>(thread.state), thread.has_left() ? 0 : thread.place}].push_back(
            thread.index);
    }
    std::string who;
    for (const auto& [where, threads] : groups) {
        static constexpr const char* kDoes[] = {"run", "wait at a barrier",
                                                "wait in a warp operation", "have returned",
                                                "have reached the kernel's end"};
        who += (who.empty() ? ": threads " : "; threads ") + simt::thread_list(threads) + " " +
               kDoes[where.first];
    }
    const auto first =
        std::find_if(groups.begin(), groups.end(), [](const auto& g) { return g.first.first < 3; });
    const auto other = std::find_if(groups.begin(), groups.end(), [&](const auto& g) {
        return g.first != first->first && g.first.first < 3;
    });
    Finding finding;
    finding.kind = FindingKind::divergence;
    finding.kernel = info_.kernel;
    finding.what = what + who;
    const Thread& one = block.threads[first->second.front()];
    finding.one = actor(one, one.place, "waits");
    if (other != groups.end()) {
        const Thread& two = block.threads[other->second.front()];
        finding.other = actor(two, two.place, "waits");
    }
    findings_.add(finding);
}

void Machine::report_leavers(Block& block) {
    std::vector<std::uint32_t> left;
    const Thread* waits = nullptr;
    for (const Thread& thread : block.threads) {
        if (thread.state == ThreadState::left_at_end ||
            (strict_ && thread.state == ThreadState::left_early)) {
            left.push_back(thread.index);
        } else if (thread.state == ThreadState::at_barrier && waits == nullptr) {
            waits = &thread;
        }
    }
    if (left.empty() || waits == nullptr) return;
    Finding finding;
    finding.kind = FindingKind::divergence;
    finding.kernel = info_.kernel;
    finding.what = "threads " + simt::thread_list(left) +
                   " have left the kernel without this barrier, at which others wait";
    finding.one = actor(*waits, waits->place, "waits");
    findings_.add(finding);
}

void Machine::join_block(Block& block) {
    SharedClocks acquired;
    SharedClocks fenced;
    SharedClocks fenced_block;
    for (const Thread& thread : block.threads) {
        acquired = join(join(acquired, thread.acquired), thread.read);
        fenced = join(fenced, thread.fenced);
        fenced_block = join(fenced_block, thread.fenced_block);
    }
    for (Thread& thread : block.threads) {
        thread.knows_more = true;
        thread.acquired = acquired;
        thread.read = nullptr;
        thread.fenced = fenced;
        thread.fenced_block = fenced_block;
    }
}

void Machine::join_lanes(Block& block, std::uint32_t warp, std::uint32_t lanes) {
    Thread* const threads = block.threads.data() + std::size_t{warp} * kWarp;
    std::array<std::uint32_t, kWarp> known{};
    std::uint32_t latest = 0;
    SharedClocks acquired;
    SharedClocks fenced;
    SharedClocks fenced_block;
    for (std::uint32_t bits = lanes; bits != 0; bits &= bits - 1) {
        const Thread& thread = threads[std::countr_zero(bits)];
        latest = std::max(latest, thread.clock);
        for (std::uint32_t lane = 0; lane < kWarp; ++lane) {
            known[lane] = std::max(known[lane], thread.known[lane]);
        }
        known[thread.lane()] = std::max(known[thread.lane()], thread.clock + 1);
        acquired = join(join(acquired, thread.acquired), thread.read);
        fenced = join(fenced, thread.fenced);
        fenced_block = join(fenced_block, thread.fenced_block);
    }
    for (std::uint32_t bits = lanes; bits != 0; bits &= bits - 1) {
        Thread& thread = threads[std::countr_zero(bits)];
        thread.clock = latest + 1;
        thread.known = known;
        thread.knows_more |= acquired != nullptr || fenced != nullptr || fenced_block != nullptr;
        thread.acquired = acquired;
        thread.read = nullptr;
        thread.fenced = fenced;
        thread.fenced_block = fenced_block;
    }
}

SharedClocks Machine::knowledge(const Thread& thread) const {
    auto clocks = thread.acquired == nullptr ? std::make_shared<Clocks>()
                                             : std::make_shared<Clocks>(*thread.acquired);
    const Block& block = *thread.block;
    clocks->know_block(block.index, block.base);
    clocks->know_thread(block.index, thread.index, thread.clock + 1);
    for (std::uint32_t lane = 0; lane < kWarp; ++lane) {
        if (thread.known[lane] > block.base) {
            clocks->know_thread(block.index, thread.warp() * kWarp + lane, thread.known[lane]);
        }
    }
    return clocks;
}

void Machine::fence(Scope scope, Order order) {
    Thread& thread = *current_thread;
    close_writes(thread);
    if (scope == Scope::thread) return;
    thread.knows_more = true;
    if (order != Order::release && thread.read != nullptr) {
        thread.acquired = join(thread.acquired, thread.read);
        thread.read = nullptr;
    }
    if (order == Order::acquire) return;
    (scope == Scope::block ? thread.fenced_block : thread.fenced) = knowledge(thread);
    ++thread.clock;
}

void Machine::atomic_begins(void* at, std::size_t bytes, bool reads, bool writes, Scope scope,
                            Order order, const void* place) {
    Thread& thread = *current_thread;
    const bool block_scope = scope == Scope::block;
    if (order == Order::release || order == Order::acquire_release) fence(scope, Order::release);
    access(writes ? Access::atomic : Access::atomic_load, at, bytes, place, block_scope);
    const auto found = channels_.find(at);
    if (reads && found != channels_.end()) {
        thread.knows_more = true;
        SharedClocks heard = found->second.device;
        const auto own = found->second.by_block.find(thread.block->index);
        if (own != found->second.by_block.end()) heard = join(heard, own->second);
        // A read and write in one is taken as the acquire that programs mean by it.
        const bool acquires = writes || order == Order::acquire || order == Order::acquire_release;
        SharedClocks& into = acquires ? thread.acquired : thread.read;
        into = join(into, heard);
    }
    if (!writes) return;
    if (!reads && found != channels_.end()) channels_.erase(found);
    const SharedClocks& device = thread.fenced;
    if (device == nullptr && thread.fenced_block == nullptr) return;
    Channel& channel = channels_[at];
    if (device != nullptr && !block_scope) channel.device = join(channel.device, device);
    SharedClocks for_block = thread.fenced_block;
    if (block_scope) for_block = join(for_block, device);
    if (for_block != nullptr) {
        SharedClocks& own = channel.by_block[thread.block->index];
        own = join(own, for_block);
    }
}

void Machine::atomic_ends(bool changed) {
    Thread& thread = *current_thread;
    if (changed) ++changes_;
    ++thread.polls;
    may_poll(thread);
}

}  // namespace scotty::emulation::cuda
