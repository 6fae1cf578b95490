#include "emulation/simt/check/memory_checker.h"

#include <algorithm>
#include <cstring>
#include <string>
#include <utility>

#include "emulation/simt/check/source_line.h"
#include "reference/error.h"

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

/// Relaxed reads that an atomic of their launch met, by place: of the whole process.
struct RelaxedTally {
    std::mutex mutex;
    std::map<std::uint32_t, std::uint64_t> met;
};
RelaxedTally& relaxed_tally() {
    static RelaxedTally tally;
    return tally;
}

/// The one of the two may have come first.
void tally_relaxed(const Shadow& shadow, Access access, std::uint32_t place, const Accessor& who,
                   bool shared) {
    const bool reads = access == Access::relaxed_read;
    const Stamp other = load(shadow.of[index(reads ? Access::atomic : Access::relaxed_read)]);
    if (!unordered(other, who, shared)) return;
    RelaxedTally& tally = relaxed_tally();
    const std::scoped_lock lock(tally.mutex);
    ++tally.met[reads ? place : other.place];
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

void MemoryChecker::forget_all() {
    std::memset(states_, nobodys, (used_ + 3) / 4);
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
    std::memset(states_ + offset / 4, each_slot_once ? unwritten_once : unwritten, (bytes + 3) / 4);
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
    if (at - begin_ < kDeviceBytes) return writer_of((at - begin_) / 4);
    // The latest: memory of the host is used again.
    const auto download = std::find_if(
        downloads_.rbegin(), downloads_.rend(),
        [&](const Download& candidate) { return at - candidate.host < candidate.bytes; });
    if (download == downloads_.rend()) return std::nullopt;
    return writer_of((download->offset + (at - download->host)) / 4);
}

std::optional<Writer> MemoryChecker::writer_of(std::size_t word) const {
    const Shadow& shadow = shadows_[word];
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
        if (__atomic_load_n(states_ + word, __ATOMIC_RELAXED) != written &&
            !settle(access, word, place, who)) [[unlikely]] {
            return;
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
        if (access == Access::relaxed_read || access == Access::atomic) {
            tally_relaxed(shadow, access, place, who, false);
        }
        if (access == Access::write) {
            // Two writes by two threads, and one of them is not the last: that is a race already.
            store(shadow.of[index(access)], {who.launch, who.block, place, when_of(who)});
        } else {
            note(shadow.of[index(access)], place, who, false);
        }
    }
}

bool MemoryChecker::settle(Access access, std::size_t word, std::uint32_t place,
                           const Accessor& who) {
    using Kind = MemoryFinding::Kind;
    const auto found = [&](Kind kind, const Stamp* other) {
        report(kind, access, place, who, other, Access::write, 4 * word, nullptr);
        return false;
    };
    const std::uint8_t state = __atomic_load_n(states_ + word, __ATOMIC_RELAXED);
    switch (state) {
        case nobodys:
            return found(Kind::outside, nullptr);
        case freed:
            return found(Kind::freed, nullptr);
        case written_once: {
            if (access != Access::write) return true;
            const Stamp other = load(shadows_[word].of[index(Access::write)]);
            // Unordered, it is a race, which says more.
            return unordered(other, who, false) || found(Kind::twice, &other);
        }
        default:
            break;
    }
    if (access != Access::write) return found(Kind::unwritten, nullptr);
    const std::uint8_t now = state == unwritten_once ? written_once : written;
    __atomic_store_n(states_ + word, now, __ATOMIC_RELAXED);
    return true;
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
        if (access == Access::relaxed_read || access == Access::atomic) {
            tally_relaxed(shadow, access, place, who, true);
        }
        if (access == Access::write) {
            shadow.of[index(access)] = {who.launch, who.block, place, when_of(who)};
        } else {
            note(shadow.of[index(access)], place, who, true);
        }
    }
}

void MemoryChecker::report_register(const Accessor& who, std::uint32_t owner, const void* place) {
    const std::scoped_lock lock(findings_mutex_);
    const std::uint32_t offset = offset_in_text(place);
    const std::uint64_t key = static_cast<std::uint64_t>(offset) << 34 |
                              static_cast<std::uint64_t>(MemoryFinding::Kind::foreign);
    if (findings_.size() >= kMostFindings || !reported_.insert(key).second) return;
    MemoryFinding finding;
    finding.kind = MemoryFinding::Kind::foreign;
    finding.block = who.block;
    finding.thread = who.thread;
    finding.place = offset;
    finding.other_thread = owner;
    findings_.push_back(std::move(finding));
}

void MemoryChecker::report(MemoryFinding::Kind kind, Access access, std::uint32_t place,
                           const Accessor& who, const Stamp* other, Access other_access,
                           std::uintptr_t offset, const SharedMemory* shared) {
    const std::scoped_lock lock(findings_mutex_);
    const std::uint64_t key =
        (static_cast<std::uint64_t>(place) << 32 | (other != nullptr ? other->place : 0u)) * 8 +
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
    for (const auto& [line, met] : by_line) out.push_back({line, met});
    return out;
}

}  // namespace scotty::emulation::simt
