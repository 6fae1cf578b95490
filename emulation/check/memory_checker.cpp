#include "emulation/check/memory_checker.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "emulation/check/source_line.h"
#include "reference/base/error.h"

namespace scotty::emulation::simt {

namespace {

constexpr std::size_t kMostFindings = 20;

constexpr bool is_plain(Access access) { return static_cast<unsigned>(access) < 2; }
/// The half of a Shadow that holds this kind.
constexpr std::size_t half(Access access) { return static_cast<std::size_t>(access) & 1u; }

/// Workers of concurrent blocks use one word's shadow at the same time. Stamp and place may then
/// come from two accesses, but of one kind and one launch, from two blocks, and the checker needs
/// no more.
Stamp load(const Stamp& stamp) { return __atomic_load_n(&stamp, __ATOMIC_RELAXED); }
void store(Shadow& shadow, std::size_t which, Stamp stamp, std::uint32_t place) {
    __atomic_store_n(&shadow.stamps[which], stamp, __ATOMIC_RELAXED);
    __atomic_store_n(&shadow.places[which], place, __ATOMIC_RELAXED);
}

/// Whether nothing orders an earlier access before this one.
template <bool shared>
bool unordered(Stamp earlier, Accessor who) {
    if (earlier < who.launch) return false;
    const Stamp differs = earlier ^ who.now;
    const bool other_block = differs >> kBlockShift != 0;
    if (shared) {
        if (other_block) return false;  // an earlier block used this memory
    } else if (other_block || (earlier & kSeveralBlocks) != 0) {
        return true;
    }
    if (static_cast<std::uint32_t>(differs) >> kPhaseShift != 0) return false;
    return (earlier & kSeveralThreads) != 0 || (differs & kThreadOfStamp) != 0;
}

/// Records an access beside earlier ones of its kind.
template <bool shared, Access access>
[[gnu::always_inline]] inline void note(Shadow& shadow, std::uint32_t place, Accessor who) {
    constexpr std::size_t which = half(access);
    const Stamp before = load(shadow.stamps[which]);
    Stamp now = who.now;
    // Writes need no flags: two unordered writes are a race already.
    if (access != Access::write && before >= who.launch) {
        const Stamp differs = before ^ now;
        if (!shared && (before & kSeveralBlocks) != 0) return;  // the checker needs no more
        if (differs >> kBlockShift != 0) {
            if (!shared) now |= kSeveralBlocks;
        } else if (static_cast<std::uint32_t>(differs) >> kPhaseShift == 0) {
            if ((before & kSeveralThreads) != 0 || (differs & kThreadOfStamp) == 0) return;
            __atomic_store_n(&shadow.stamps[which], before | kSeveralThreads, __ATOMIC_RELAXED);
            return;
        }
    }
    store(shadow, which, now, place);
}

/// Whether two kinds may not meet unordered.
constexpr bool conflict(Access one, Access other) {
    if (one == Access::write || other == Access::write) return true;
    return (one == Access::read && other == Access::atomic) ||
           (one == Access::atomic && other == Access::read);
}

/// Counts relaxed reads that an atomic of their launch met, by place, over the whole process.
struct RelaxedTally {
    std::mutex mutex;
    std::map<std::uint32_t, std::uint64_t> met;
};
RelaxedTally& relaxed_tally() {
    static RelaxedTally tally;
    return tally;
}

/// Counts a relaxed read or an atomic that may have met the other kind; either may come first.
template <bool shared, Access access>
void tally_relaxed(const Shadow& others, std::uint32_t place, Accessor who) {
    constexpr bool reads = access == Access::relaxed_read;
    constexpr std::size_t other = half(reads ? Access::atomic : Access::relaxed_read);
    if (!unordered<shared>(load(others.stamps[other]), who)) return;
    RelaxedTally& tally = relaxed_tally();
    const std::scoped_lock lock(tally.mutex);
    ++tally.met[reads ? place : others.places[other]];
}

}  // namespace

MemoryChecker::MemoryChecker()
    : memory_(take_checker_memory()),
      begin_(reinterpret_cast<std::uintptr_t>(memory_->device())),
      text_begin_(program_begin()),
      plain_(memory_->plain()),
      others_(memory_->others()),
      states_(memory_->states()) {}

MemoryChecker::~MemoryChecker() {
    forget_all();
    give_back(std::move(memory_));
}

void* MemoryChecker::allocate(std::size_t bytes) {
    const std::size_t room = (bytes + 255) / 256 * 256;
    if (room > kDeviceBytes || used_ + room + kGuard > kDeviceBytes) return nullptr;
    const std::size_t offset = used_;
    used_ += room + kGuard;
    std::memset(memory_->device() + offset, kPoisonByte, bytes);
    std::memset(states_ + offset / 4, kOwned, (bytes + 3) / 4);
    allocations_[offset] = {bytes, "device memory"};
    return memory_->device() + offset;
}

void MemoryChecker::forget_all() {
    std::memset(states_, kNobodys, (used_ + 3) / 4);
    allocations_.clear();
    downloads_.clear();
    used_ = kGuard;
}

void* MemoryChecker::allocate_or_throw(std::size_t bytes, const char* name) {
    void* const memory = allocate(std::max<std::size_t>(bytes, 1));
    if (memory == nullptr) {
        throw reference::Error::missing_environment(
            "--check: no room for " + std::to_string(bytes) + " bytes of " + name +
            "; the device under the checker has 4 GiB in all: trace fewer rays at once "
            "(--batch-rays)");
    }
    label(memory, name);
    return memory;
}

void MemoryChecker::discard(const void* memory, std::size_t bytes, bool each_slot_once) {
    const std::uintptr_t offset = reinterpret_cast<std::uintptr_t>(memory) - begin_;
    if (offset >= kDeviceBytes) return;
    std::memset(states_ + offset / 4, each_slot_once ? kOwned | kOnce : kOwned, (bytes + 3) / 4);
}

bool MemoryChecker::release(void* memory) {
    const std::uintptr_t offset = reinterpret_cast<std::uintptr_t>(memory) - begin_;
    if (offset >= kDeviceBytes) return false;
    if (const auto found = allocations_.find(offset); found != allocations_.end()) {
        std::memset(states_ + offset / 4, kFreed, (found->second.bytes + 3) / 4);
    }
    return true;
}

void MemoryChecker::label(const void* memory, const char* name) {
    const auto found = allocations_.find(reinterpret_cast<std::uintptr_t>(memory) - begin_);
    if (found != allocations_.end()) found->second.name = name;
}

void MemoryChecker::note_upload(const void* to, std::size_t bytes) {
    const std::uintptr_t offset = reinterpret_cast<std::uintptr_t>(to) - begin_;
    if (offset >= kDeviceBytes || bytes == 0) return;
    const std::size_t end = (offset + bytes + 3) / 4;
    std::memset(states_ + offset / 4, kOwned | kWritten, end - offset / 4);
    // Forget what a kernel wrote here.
    for (std::size_t word = offset / 4; word < end; ++word) {
        if (plain_[word].stamps[half(Access::write)] != 0) plain_[word] = {};
        if (others_[word].stamps[half(Access::atomic)] != 0) others_[word] = {};
    }
}

void MemoryChecker::note_download(const void* host, const void* device, std::size_t bytes) {
    const std::uintptr_t offset = reinterpret_cast<std::uintptr_t>(device) - begin_;
    if (offset >= kDeviceBytes || bytes == 0) return;
    downloads_.push_back({reinterpret_cast<std::uintptr_t>(host), offset, bytes});
}

std::optional<Writer> MemoryChecker::last_writer(const void* host) const {
    const auto at = reinterpret_cast<std::uintptr_t>(host);
    if (at - begin_ < kDeviceBytes) return writer_of((at - begin_) / 4);
    // The latest download counts, because host memory is reused.
    const auto download = std::find_if(
        downloads_.rbegin(), downloads_.rend(),
        [&](const Download& candidate) { return at - candidate.host < candidate.bytes; });
    if (download == downloads_.rend()) return std::nullopt;
    return writer_of((download->offset + (at - download->host)) / 4);
}

const MemoryChecker::LaunchOfBlocks* MemoryChecker::launch_of(Stamp stamp) const {
    const auto after = std::upper_bound(
        launches_.begin(), launches_.end(), stamp >> kBlockShift,
        [](Stamp block, const LaunchOfBlocks& launch) { return block < launch.first; });
    return after == launches_.begin() ? nullptr : &*std::prev(after);
}

std::optional<Writer> MemoryChecker::writer_of(std::size_t word) const {
    std::optional<Writer> last;
    std::uint32_t last_first = 0;
    const auto look = [&](const Shadow& shadow, Access access) {
        const Stamp stamp = shadow.stamps[half(access)];
        const LaunchOfBlocks* const launch = launch_of(stamp);
        if (launch == nullptr || launch->first <= last_first) return;
        last_first = launch->first;
        last = Writer{launch->kernel,
                      launch == &launches_.back(),
                      access == Access::atomic,
                      static_cast<std::uint32_t>(stamp >> kBlockShift) - launch->first,
                      static_cast<std::uint32_t>(stamp & kThreadOfStamp),
                      shadow.places[half(access)]};
    };
    look(plain_[word], Access::write);
    look(others_[word], Access::atomic);
    return last;
}

std::uint32_t MemoryChecker::begin_launch(const char* kernel, std::uint32_t blocks) {
    const std::uint32_t first = memory_->next_block;
    if (blocks > ~std::uint32_t{0} - first) {
        throw reference::Error::missing_environment(
            "--check: more than two billion blocks; check a smaller picture (--size) or fewer "
            "samples (--spp)");
    }
    memory_->next_block += blocks;
    launches_.push_back({first, kernel});
    downloads_.clear();
    reported_.clear();
    return first;
}

std::vector<MemoryFinding> MemoryChecker::take_findings() {
    const std::scoped_lock lock(findings_mutex_);
    return std::exchange(findings_, {});
}

template <bool shared, Access access, Access other>
void MemoryChecker::check_pair(const Shadow& shadow, std::uint32_t place, Accessor who,
                               std::uintptr_t offset, const SharedMemory* memory,
                               const Context& running) {
    if constexpr (conflict(access, other)) {
        const Stamp earlier = load(shadow.stamps[half(other)]);
        if (unordered<shared>(earlier, who)) [[unlikely]] {
            const Other one{other, earlier, shadow.places[half(other)]};
            report(MemoryFinding::Kind::race, access, place, running, &one, offset, memory);
        }
    }
}

template <bool shared, Access access>
void MemoryChecker::check_all(Shadow& plain, Shadow& others, std::uint32_t place, Accessor who,
                              std::uintptr_t offset, const SharedMemory* memory,
                              const Context& running) {
    check_pair<shared, access, Access::write>(plain, place, who, offset, memory, running);
    check_pair<shared, access, Access::read>(plain, place, who, offset, memory, running);
    check_pair<shared, access, Access::relaxed_read>(others, place, who, offset, memory, running);
    check_pair<shared, access, Access::atomic>(others, place, who, offset, memory, running);
    if constexpr (is_plain(access)) {
        note<shared, access>(plain, place, who);
    } else {
        tally_relaxed<shared, access>(others, place, who);
        note<shared, access>(others, place, who);
    }
}

template <Access access>
void MemoryChecker::check_others(std::size_t word, std::uint32_t place, const Context& running) {
    // From now on plain accesses, too, check both shadows.
    if (!is_plain(access) && (__atomic_load_n(states_ + word, __ATOMIC_RELAXED) & kOthers) == 0) {
        __atomic_fetch_or(states_ + word, kOthers, __ATOMIC_RELAXED);
    }
    check_all<false, access>(plain_[word], others_[word], place, Accessor(running), 4 * word,
                             nullptr, running);
}

template <Access access>
void MemoryChecker::check_device(std::uintptr_t offset, std::size_t bytes, std::uint32_t place,
                                 const Context& running) {
    constexpr std::uint8_t asked = access == Access::write ? kWritten | kOnce : kWritten;
    const Accessor who(running);
    const std::size_t end = std::min(offset + bytes + 3, kDeviceBytes) / 4;
    for (std::size_t word = offset / 4; word < end; ++word) {
        const std::uint8_t state = __atomic_load_n(states_ + word, __ATOMIC_RELAXED);
        if ((state & asked) != kWritten && !settle(access, word, place, running)) [[unlikely]]
            return;
        if (!is_plain(access) || (state & kOthers) != 0) {
            check_others<access>(word, place, running);
            continue;
        }
        Shadow& plain = plain_[word];
        check_pair<false, access, Access::write>(plain, place, who, 4 * word, nullptr, running);
        check_pair<false, access, Access::read>(plain, place, who, 4 * word, nullptr, running);
        note<false, access>(plain, place, who);
    }
}

bool MemoryChecker::settle(Access access, std::size_t word, std::uint32_t place,
                           const Context& running) {
    using Kind = MemoryFinding::Kind;
    const auto found = [&](Kind kind, const Other* other) {
        report(kind, access, place, running, other, 4 * word, nullptr);
        return false;
    };
    const std::uint8_t state = __atomic_load_n(states_ + word, __ATOMIC_RELAXED);
    if ((state & kFreed) != 0) return found(Kind::freed, nullptr);
    if (state == kNobodys) return found(Kind::outside, nullptr);
    if ((state & kWritten) != 0) {
        // This is a slot written a second time, or one that another worker has just written.
        if (access != Access::write || (state & kOnce) == 0) return true;
        const Shadow& plain = plain_[word];
        const Other other{Access::write, load(plain.stamps[half(Access::write)]),
                          plain.places[half(Access::write)]};
        // An unordered second write is a race, which says more.
        return unordered<false>(other.stamp, Accessor(running)) || found(Kind::twice, &other);
    }
    if (access != Access::write) return found(Kind::unwritten, nullptr);
    __atomic_fetch_or(states_ + word, kWritten, __ATOMIC_RELAXED);
    return true;
}

template <Access access>
void MemoryChecker::check_shared(std::uintptr_t offset, std::size_t bytes, std::uint32_t place,
                                 const Context& running) {
    const Accessor who(running);
    const SharedMemory& shared = *running.shared;
    SharedShadow* const shadows = running.shared_shadow;
    if (offset + bytes > shared.used()) [[unlikely]] {
        report(MemoryFinding::Kind::outside, access, place, running, nullptr, offset, &shared);
        return;
    }
    const auto is_own = [&](Stamp stamp) { return (stamp ^ who.now) >> kBlockShift == 0; };
    const std::size_t end = std::min(offset + bytes + 3, SharedMemory::kBytes) / 4;
    for (std::size_t word = offset / 4; word < end; ++word) {
        auto& [plain, others] = shadows[word];
        if (access != Access::write && !is_own(plain.stamps[half(Access::write)]) &&
            !is_own(others.stamps[half(Access::atomic)])) [[unlikely]] {
            report(MemoryFinding::Kind::unwritten, access, place, running, nullptr, 4 * word,
                   &shared);
        }
        check_all<true, access>(plain, others, place, who, 4 * word, &shared, running);
    }
}

// Instantiated for instrumentation.cpp.
template void MemoryChecker::check_device<Access::read>(std::uintptr_t, std::size_t, std::uint32_t,
                                                        const Context&);
template void MemoryChecker::check_device<Access::write>(std::uintptr_t, std::size_t, std::uint32_t,
                                                         const Context&);
template void MemoryChecker::check_device<Access::relaxed_read>(std::uintptr_t, std::size_t,
                                                                std::uint32_t, const Context&);
template void MemoryChecker::check_device<Access::atomic>(std::uintptr_t, std::size_t,
                                                          std::uint32_t, const Context&);
template void MemoryChecker::check_shared<Access::read>(std::uintptr_t, std::size_t, std::uint32_t,
                                                        const Context&);
template void MemoryChecker::check_shared<Access::write>(std::uintptr_t, std::size_t, std::uint32_t,
                                                         const Context&);
template void MemoryChecker::check_shared<Access::relaxed_read>(std::uintptr_t, std::size_t,
                                                                std::uint32_t, const Context&);
template void MemoryChecker::check_shared<Access::atomic>(std::uintptr_t, std::size_t,
                                                          std::uint32_t, const Context&);

void MemoryChecker::end_block(const Context& running) {
    const Stamp own = Accessor(running).now >> kBlockShift;
    running.shared->each_gap([&](std::size_t begin, std::size_t end) {
        for (std::size_t word = begin / 4; word < end / 4; ++word) {
            const auto& [plain, others] = running.shared_shadow[word];
            const auto look = [&](const Shadow& shadow, Access access) {
                const Stamp stamp = shadow.stamps[half(access)];
                if (stamp >> kBlockShift != own) return;
                Context writer = running;
                writer.thread = static_cast<std::uint32_t>(stamp & kThreadOfStamp);
                report(MemoryFinding::Kind::outside, access, shadow.places[half(access)], writer,
                       nullptr, 4 * word, running.shared);
            };
            look(plain, Access::write);
            look(others, Access::atomic);
        }
    });
}

void MemoryChecker::report_register(const Context& running, std::uint32_t owner,
                                    const void* place) {
    const std::scoped_lock lock(findings_mutex_);
    const std::uint32_t offset = offset_in_text(place);
    const std::uint64_t key = static_cast<std::uint64_t>(offset) << 34 |
                              static_cast<std::uint64_t>(MemoryFinding::Kind::foreign);
    if (findings_.size() >= kMostFindings || !reported_.insert(key).second) return;
    MemoryFinding finding;
    finding.kind = MemoryFinding::Kind::foreign;
    finding.block = running.block;
    finding.thread = running.thread;
    finding.place = offset;
    finding.other_thread = owner;
    findings_.push_back(std::move(finding));
}

void MemoryChecker::report_memory(Access access, const void* address, const void* place,
                                  const Context& running) {
    constexpr auto kind = MemoryFinding::Kind::no_register;
    const auto at = reinterpret_cast<std::uintptr_t>(address);
    const std::uintptr_t in_block = at - reinterpret_cast<std::uintptr_t>(running.shared->memory());
    if (at - begin_ < kDeviceBytes) {
        report(kind, access, offset_in_text(place), running, nullptr, at - begin_, nullptr);
    } else if (in_block < SharedMemory::kBytes) {
        report(kind, access, offset_in_text(place), running, nullptr, in_block, running.shared);
    }
}

void MemoryChecker::report(MemoryFinding::Kind kind, Access access, std::uint32_t place,
                           const Context& running, const Other* other, std::uintptr_t offset,
                           const SharedMemory* shared) {
    const std::scoped_lock lock(findings_mutex_);
    const std::uint64_t key =
        (static_cast<std::uint64_t>(place) << 32 | (other != nullptr ? other->place : 0u)) * 8 +
        static_cast<std::uint64_t>(kind);
    if (findings_.size() >= kMostFindings || !reported_.insert(key).second) return;
    if (shared != nullptr && kind == MemoryFinding::Kind::unwritten && shared->in_gap(offset)) {
        kind = MemoryFinding::Kind::outside;  // which says more
    }
    MemoryFinding finding;
    finding.kind = kind;
    finding.access = access;
    finding.block = running.block;
    finding.thread = running.thread;
    finding.place = place;
    if (other != nullptr) {
        const Stamp stamp = other->stamp;
        finding.other_access = other->access;
        finding.other_block =
            static_cast<std::uint32_t>(stamp >> kBlockShift) - running.first_block;
        finding.other_thread = static_cast<std::uint32_t>(stamp & kThreadOfStamp);
        finding.other_place = other->place;
        // With several accesses, the remembered one may be the running thread's own.
        if (finding.other_block == finding.block && (stamp & kSeveralBlocks) != 0) {
            finding.other_block = kSomeOther;
            finding.other_thread = kSomeOther;
        } else if (finding.other_block == finding.block && finding.other_thread == finding.thread &&
                   (stamp & kSeveralThreads) != 0) {
            finding.other_thread = kSomeOther;
        }
    }
    finding.memory =
        shared != nullptr ? "shared memory " + shared->name_at(offset) : name_of(offset);
    findings_.push_back(std::move(finding));
}

std::string MemoryChecker::name_of(std::uintptr_t offset) const {
    auto next = allocations_.upper_bound(offset);
    if (next == allocations_.begin()) {
        if (next == allocations_.end()) return "device memory that nobody has";
        return std::to_string(next->first - offset) + " bytes before " + next->second.name;
    }
    const auto& [begin, allocation] = *std::prev(next);
    const std::size_t inside = offset - begin;
    if (inside < allocation.bytes) {
        return allocation.name + ", byte " + std::to_string(inside) + " of " +
               std::to_string(allocation.bytes);
    }
    const std::size_t behind = inside - allocation.bytes;
    if (next != allocations_.end() && next->first - offset < behind) {
        return std::to_string(next->first - offset) + " bytes before " + next->second.name;
    }
    return std::to_string(behind) + " bytes behind the end of " + allocation.name + " (" +
           std::to_string(allocation.bytes) + " bytes)";
}

std::vector<RelaxedMeetings> relaxed_meetings() {
    RelaxedTally& tally = relaxed_tally();
    const std::scoped_lock lock(tally.mutex);
    std::vector<std::uint32_t> places;
    places.reserve(tally.met.size());
    for (const auto& [place, met] : tally.met) places.push_back(place);
    const std::vector<std::string> lines = source_lines(places);
    // A function inlined in several kernels has several places.
    std::map<std::string, std::uint64_t> by_line;
    for (std::size_t i = 0; i < places.size(); ++i) by_line[lines[i]] += tally.met[places[i]];
    std::vector<RelaxedMeetings> out;
    out.reserve(by_line.size());
    for (const auto& [line, met] : by_line) out.push_back({line, met});
    return out;
}

}  // namespace scotty::emulation::simt
