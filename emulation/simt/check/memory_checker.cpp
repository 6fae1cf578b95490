#include "emulation/simt/check/memory_checker.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "emulation/simt/check/source_line.h"

namespace scotty::emulation::simt {

namespace {

constexpr std::uint32_t kThreadMask = 0x3ff;
constexpr std::uint32_t kSeveralThreads = 1u << 10;
constexpr std::uint32_t kSeveralBlocks = 1u << 11;
constexpr std::uint32_t kPhaseShift = 12;
constexpr std::size_t kMostFindings = 20;

/// Workers of blocks that run at once look at one word's shadow at once. Halves may then be of two
/// accesses; of one kind and one launch, from two blocks, which is all that is asked of them.
Stamp load(const Stamp& stamp) {
    Stamp out;
    const auto* from = reinterpret_cast<const std::uint64_t*>(&stamp);
    const std::uint64_t halves[2] = {__atomic_load_n(from, __ATOMIC_RELAXED),
                                     __atomic_load_n(from + 1, __ATOMIC_RELAXED)};
    std::memcpy(&out, halves, sizeof out);
    return out;
}
void store(Stamp& stamp, const Stamp& value) {
    auto* to = reinterpret_cast<std::uint64_t*>(&stamp);
    std::uint64_t halves[2];
    std::memcpy(halves, &value, sizeof value);
    __atomic_store_n(to, halves[0], __ATOMIC_RELAXED);
    __atomic_store_n(to + 1, halves[1], __ATOMIC_RELAXED);
}

std::uint32_t when_of(const Accessor& who) {
    return (who.phase << kPhaseShift) | (who.thread & kThreadMask);
}

/// Whether nothing orders an earlier access before this one.
bool unordered(const Stamp& earlier, const Accessor& who, bool shared) {
    if (earlier.launch != who.launch) return false;
    if (shared) {
        if (earlier.block != who.block) return false;  // another block's memory, which was here
    } else if (earlier.block != who.block || (earlier.when & kSeveralBlocks) != 0) {
        return true;
    }
    if ((earlier.when ^ when_of(who)) >> kPhaseShift != 0) return false;
    return (earlier.when & kSeveralThreads) != 0 || (earlier.when & kThreadMask) != who.thread;
}

/// Notes an access beside those of its kind before.
void note(Stamp& stamp, std::uint32_t place, const Accessor& who, bool shared) {
    const std::uint32_t when = when_of(who);
    Stamp now{who.launch, who.block, place, when};
    const Stamp before = load(stamp);
    if (before.launch == who.launch) {
        if (before.block == who.block) {
            now.when |= before.when & kSeveralBlocks;
            if ((before.when ^ when) >> kPhaseShift == 0) {
                const bool same = (before.when & kThreadMask) == who.thread;
                if (same || (before.when & kSeveralThreads) != 0) return;
                now = before;
                now.when |= kSeveralThreads;
            }
        } else if (!shared) {
            now.when |= kSeveralBlocks;
        }
    }
    store(stamp, now);
}

/// Kinds that may not meet each kind unordered.
struct Conflicts {
    Access with[3];
    int count;
};
constexpr Conflicts kConflicts[4] = {
    {{Access::write, Access::atomic}, 2},                // read
    {{Access::write, Access::read, Access::atomic}, 3},  // write
    {{Access::write, Access::read}, 2},                  // atomic
    {{Access::write}, 1},                                // relaxed read
};
constexpr std::size_t index(Access access) { return static_cast<std::size_t>(access); }

const char* verb(Access access) {
    switch (access) {
        case Access::read:
            return "reads it";
        case Access::write:
            return "writes it";
        case Access::atomic:
            return "changes it atomically";
        case Access::relaxed_read:
            return "reads it while others may write";
    }
    return "";
}

std::string who_text(std::uint32_t thread, std::uint32_t block) {
    return "thread " + std::to_string(thread) + " of block " + std::to_string(block);
}

}  // namespace

MemoryChecker::MemoryChecker()
    : memory_(kDeviceBytes, "the device's memory"),
      shadow_memory_(kDeviceBytes / 4 * sizeof(Shadow), "what is known of each word"),
      state_memory_(kDeviceBytes / 4, "which words are written"),
      begin_(reinterpret_cast<std::uintptr_t>(memory_.data())),
      text_begin_(program_begin()),
      shadows_(reinterpret_cast<Shadow*>(shadow_memory_.data())),
      states_(reinterpret_cast<std::uint8_t*>(state_memory_.data())) {}

void* MemoryChecker::allocate(std::size_t bytes) {
    const std::size_t room = (bytes + 255) / 256 * 256;
    if (room > kDeviceBytes || used_ + room + kGuard > kDeviceBytes) return nullptr;
    const std::size_t offset = used_;
    used_ += room + kGuard;
    std::memset(memory_.data() + offset, kPoisonByte, bytes);
    std::memset(states_ + offset / 4, unwritten, (bytes + 3) / 4);
    allocations_[offset] = {bytes, "device memory"};
    return memory_.data() + offset;
}

bool MemoryChecker::release(void* memory) {
    const std::uintptr_t offset = reinterpret_cast<std::uintptr_t>(memory) - begin_;
    if (offset >= kDeviceBytes) return false;
    if (const auto found = allocations_.find(offset); found != allocations_.end()) {
        std::memset(states_ + offset / 4, freed, (found->second.bytes + 3) / 4);
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
    std::memset(states_ + offset / 4, written, (offset + bytes + 3) / 4 - offset / 4);
    // What a kernel wrote here is gone.
    for (std::size_t word = offset / 4; word < (offset + bytes + 3) / 4; ++word) {
        if (shadows_[word].of[index(Access::write)].launch != 0) shadows_[word] = {};
        if (shadows_[word].of[index(Access::atomic)].launch != 0) shadows_[word] = {};
    }
}

void MemoryChecker::note_download(const void* host, const void* device, std::size_t bytes) {
    const std::uintptr_t offset = reinterpret_cast<std::uintptr_t>(device) - begin_;
    if (offset >= kDeviceBytes || bytes == 0) return;
    downloads_.push_back({reinterpret_cast<std::uintptr_t>(host), offset, bytes});
}

std::optional<Writer> MemoryChecker::last_writer(const void* host) const {
    const auto at = reinterpret_cast<std::uintptr_t>(host);
    // The latest: memory of the host is used again.
    const auto download = std::find_if(
        downloads_.rbegin(), downloads_.rend(),
        [&](const Download& candidate) { return at - candidate.host < candidate.bytes; });
    if (download == downloads_.rend()) return std::nullopt;
    const Shadow& shadow = shadows_[(download->offset + (at - download->host)) / 4];
    const Stamp& plain = shadow.of[index(Access::write)];
    const Stamp& atomic = shadow.of[index(Access::atomic)];
    const bool atomically = atomic.launch > plain.launch;
    const Stamp& last = atomically ? atomic : plain;
    if (last.launch == 0) return std::nullopt;
    return Writer{kernels_[last.launch - 1],
                  last.launch == kernels_.size(),
                  atomically,
                  last.block,
                  last.when & kThreadMask,
                  last.place};
}

std::uint32_t MemoryChecker::begin_launch(const char* kernel) {
    kernels_.emplace_back(kernel);
    downloads_.clear();
    reported_.clear();
    return static_cast<std::uint32_t>(kernels_.size());
}

std::vector<MemoryFinding> MemoryChecker::take_findings() {
    const std::scoped_lock lock(findings_mutex_);
    return std::exchange(findings_, {});
}

void MemoryChecker::check_device(Access access, std::uintptr_t offset, std::size_t bytes,
                                 std::uint32_t place, const Accessor& who) {
    const std::size_t end = std::min(offset + bytes + 3, kDeviceBytes) / 4;
    for (std::size_t word = offset / 4; word < end; ++word) {
        const std::uint8_t state = __atomic_load_n(states_ + word, __ATOMIC_RELAXED);
        if (state != written) [[unlikely]] {
            using Kind = MemoryFinding::Kind;
            const Kind kind = state == nobodys ? Kind::outside
                              : state == freed ? Kind::freed
                                               : Kind::unwritten;
            if (kind == Kind::unwritten && access == Access::write) {
                __atomic_store_n(states_ + word, written, __ATOMIC_RELAXED);
            } else {
                report(kind, access, place, who, nullptr, access, 4 * word, nullptr);
                return;
            }
        }
        Shadow& shadow = shadows_[word];
        const Conflicts& conflicts = kConflicts[index(access)];
        for (int i = 0; i < conflicts.count; ++i) {
            const Stamp other = load(shadow.of[index(conflicts.with[i])]);
            if (unordered(other, who, false)) [[unlikely]] {
                report(MemoryFinding::Kind::race, access, place, who, &other, conflicts.with[i],
                       4 * word, nullptr);
            }
        }
        if (access == Access::write) {
            // Two writes by two threads, and one of them is not the last: that is a race already.
            store(shadow.of[index(access)], {who.launch, who.block, place, when_of(who)});
        } else {
            note(shadow.of[index(access)], place, who, false);
        }
    }
}

void MemoryChecker::check_shared(Access access, std::uintptr_t offset, std::size_t bytes,
                                 std::uint32_t place, const Accessor& who,
                                 const SharedMemory& shared, Shadow* shadows) {
    const std::size_t end = std::min(offset + bytes + 3, SharedMemory::kBytes) / 4;
    if (offset + bytes > shared.used()) {
        report(MemoryFinding::Kind::outside, access, place, who, nullptr, access, offset, &shared);
        return;
    }
    const auto is_own = [&](const Stamp& s) {
        return s.launch == who.launch && s.block == who.block;
    };
    for (std::size_t word = offset / 4; word < end; ++word) {
        Shadow& shadow = shadows[word];
        if (access != Access::write && !is_own(shadow.of[index(Access::write)]) &&
            !is_own(shadow.of[index(Access::atomic)])) [[unlikely]] {
            report(MemoryFinding::Kind::unwritten, access, place, who, nullptr, access, 4 * word,
                   &shared);
        }
        const Conflicts& conflicts = kConflicts[index(access)];
        for (int i = 0; i < conflicts.count; ++i) {
            const Stamp& other = shadow.of[index(conflicts.with[i])];
            if (unordered(other, who, true)) [[unlikely]] {
                report(MemoryFinding::Kind::race, access, place, who, &other, conflicts.with[i],
                       4 * word, &shared);
            }
        }
        if (access == Access::write) {
            shadow.of[index(access)] = {who.launch, who.block, place, when_of(who)};
        } else {
            note(shadow.of[index(access)], place, who, true);
        }
    }
}

void MemoryChecker::report(MemoryFinding::Kind kind, Access access, std::uint32_t place,
                           const Accessor& who, const Stamp* other, Access other_access,
                           std::uintptr_t offset, const SharedMemory* shared) {
    const std::scoped_lock lock(findings_mutex_);
    const std::uint64_t key =
        (static_cast<std::uint64_t>(place) << 32 | (other != nullptr ? other->place : 0u)) * 4 +
        static_cast<std::uint64_t>(kind);
    if (findings_.size() >= kMostFindings || !reported_.insert(key).second) return;
    MemoryFinding finding;
    finding.kind = kind;
    finding.access = access;
    finding.block = who.block;
    finding.thread = who.thread;
    finding.place = place;
    if (other != nullptr) {
        finding.other_access = other_access;
        finding.other_block = other->block;
        finding.other_thread = other->when & kThreadMask;
        finding.other_place = other->place;
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

std::string to_text(const MemoryFinding& finding) {
    const std::vector<std::string> lines = source_lines({finding.place, finding.other_place});
    std::string one =
        who_text(finding.thread, finding.block) + " " + verb(finding.access) + " at " + lines[0];
    switch (finding.kind) {
        case MemoryFinding::Kind::race:
            return "data race on " + finding.memory + ": " +
                   who_text(finding.other_thread, finding.other_block) + " " +
                   verb(finding.other_access) + " at " + lines[1] + ", " + one +
                   (finding.block == finding.other_block ? ", and no barrier is between" : "");
        case MemoryFinding::Kind::unwritten:
            return "nobody has written " + finding.memory + ": " + one;
        case MemoryFinding::Kind::outside:
            return "out of bounds, " + finding.memory + ": " + one;
        case MemoryFinding::Kind::freed:
            return "freed memory, " + finding.memory + ": " + one;
    }
    return one;
}

}  // namespace scotty::emulation::simt
