// Every load and store of a CUDA thread: whose memory is it, who has written it, who else is there.
#include <fcntl.h>
#include <link.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <utility>

#include "emulation/cuda/machine.h"

namespace scotty::emulation::cuda {

namespace {

constexpr std::size_t kMostShared = std::size_t{227} << 10;
/// Between two shared objects, so that a step beyond one does not land in the next.
constexpr std::size_t kSharedGap = 64;
constexpr int kPoison = 0xcd;

bool writes(Access access) {
    return access == Access::write || access == Access::volatile_write ||
           access == Access::flag_write || access == Access::atomic;
}

const char* verb(Access access) {
    switch (access) {
        case Access::write:
            return "writes it";
        case Access::volatile_read:
            return "reads it (volatile)";
        case Access::volatile_write:
        case Access::flag_write:
            return "writes it (volatile)";
        case Access::atomic:
            return "changes it atomically";
        case Access::atomic_load:
            return "reads it atomically";
        default:
            return "reads it";
    }
}

enum class HostMemory : std::uint8_t { none, read_only, writable };

/// Constants, which kernels may read: memory of the program and its libraries that nobody can
/// change.
bool is_constant(const void* address) {
    struct Query {
        std::uintptr_t at;
        bool found;
    } query{reinterpret_cast<std::uintptr_t>(address), false};
    ::dl_iterate_phdr(
        [](dl_phdr_info* info, std::size_t, void* data) {
            auto& asked = *static_cast<Query*>(data);
            for (int i = 0; i < info->dlpi_phnum; ++i) {
                const auto& segment = info->dlpi_phdr[i];
                const bool fixed = (segment.p_type == PT_LOAD && (segment.p_flags & PF_W) == 0) ||
                                   segment.p_type == PT_GNU_RELRO;
                const std::uintptr_t begin = info->dlpi_addr + segment.p_vaddr;
                if (fixed && asked.at - begin < segment.p_memsz) asked.found = true;
            }
            return asked.found ? 1 : 0;
        },
        &query);
    return query.found;
}

bool is_mapped(const void* address) {
    static int pipe_ends[2] = {-1, -1};
    if (pipe_ends[0] < 0 && ::pipe(pipe_ends) != 0) return false;
    // The system looks whether it can read there, and says so without a signal.
    if (::write(pipe_ends[1], address, 1) != 1) return false;
    char taken = 0;
    return ::read(pipe_ends[0], &taken, 1) == 1;
}

HostMemory host_memory(const void* address) {
    if (is_constant(address)) return HostMemory::read_only;
    return is_mapped(address) ? HostMemory::writable : HostMemory::none;
}

}  // namespace

void Machine::access(Access access, const void* address, std::size_t bytes, const void* place,
                     bool block_scope, bool aligned) {
    Thread& thread = *current_thread;
    if (thread.stack->holds(address) || scotty_cuda::is_builtin(address)) return;  // its own
    if (!thread.is_heard) return;
    const auto* const at = static_cast<const std::byte*>(address);
    if (!thread.open_writes.empty()) close_writes(thread);
    const std::uint32_t offset = offset_in_text(place);
    thread.last_place = offset;
    if (access == Access::volatile_write &&
        (thread.fenced != nullptr || thread.fenced_block != nullptr)) {
        access = Access::flag_write;
    }
    if (access == Access::volatile_read || access == Access::flag_write) ++thread.polls;
    ++thread.accesses;
    may_poll(thread);  // before anything is looked at: others run here
    if (writes(access) && access != Access::atomic) ++changes_;  // atomics say so themselves
    if (thread.block->holds_shared(at)) {
        Region* const region = shared_region(*thread.block, at);
        if (region != nullptr && at + bytes <= region->begin + region->bytes) {
            check(*region, access, at, bytes, offset, block_scope, aligned);
        } else {
            report_memory(FindingKind::bounds, region,
                          region == nullptr
                              ? std::string("shared memory before the first object")
                              : memory_text(*region, static_cast<std::size_t>(at - region->begin)),
                          access, offset);
        }
    } else if (Region* const region = memory_.find(at); region != nullptr) {
        if (region->freed) {
            report_memory(FindingKind::freed, region,
                          memory_text(*region, static_cast<std::size_t>(at - region->begin)),
                          access, offset);
        } else if (at + bytes > region->begin + region->bytes) {
            report_memory(FindingKind::bounds, region,
                          memory_text(*region, static_cast<std::size_t>(at - region->begin)) +
                              ", across its end",
                          access, offset);
        } else {
            check(*region, access, at, bytes, offset, block_scope, aligned);
        }
    } else {
        check_elsewhere(access, at, bytes, offset);
    }
    if (access == Access::volatile_read || access == Access::flag_write) {
        const auto found = channels_.find(at);
        if (access == Access::volatile_read && found != channels_.end()) {
            SharedClocks heard = found->second.device;
            const auto own = found->second.by_block.find(thread.block->index);
            if (own != found->second.by_block.end()) heard = join(heard, own->second);
            thread.read = join(thread.read, heard);
            thread.knows_more = true;
        } else if (access == Access::flag_write) {
            Channel& channel = channels_[at];
            channel = {};
            channel.device = thread.fenced;
            if (thread.fenced_block != nullptr) {
                channel.by_block[thread.block->index] = thread.fenced_block;
            }
        }
    }
}

Region* Machine::shared_region(Block& block, const std::byte* at) {
    Region* below = nullptr;
    for (SharedObject& object : block.objects) {
        if (object.region.begin <= at) below = &object.region;  // they ascend
    }
    return below;
}

void Machine::check(Region& region, Access access, const std::byte* at, std::size_t bytes,
                    std::uint32_t place, bool block_scope, bool aligned) {
    Thread& thread = *current_thread;
    const auto first = static_cast<std::size_t>(at - region.begin);
    if (region.kind == RegionKind::constant) {
        if (writes(access)) {
            report_memory(FindingKind::constant_write, &region, memory_text(region, first), access,
                          place);
        }
        return;
    }
    const bool whole = (bytes & (bytes - 1)) == 0 && bytes <= 16;
    // The compiler asks no more than 8 of any type.
    const std::size_t multiple = std::min<std::size_t>(bytes, 8);
    if (aligned && whole && reinterpret_cast<std::uintptr_t>(at) % multiple != 0) {
        report_memory(FindingKind::misaligned, &region,
                      memory_text(region, first) + ", " + std::to_string(bytes) +
                          " bytes at an address that is no multiple of " + std::to_string(multiple),
                      access, place);
    }
    if (region.unwritten != nullptr) {
        if (access != Access::write && access != Access::volatile_write &&
            access != Access::flag_write) {
            std::size_t missing = 0;
            for (std::size_t byte = first; byte < first + bytes; ++byte) {
                missing += region.is_unwritten(byte) ? 1 : 0;
            }
            // A record that is copied whole may have gaps that nobody writes.
            if (missing != 0 && (whole || missing == bytes)) {
                thread.unsure_reads.push_back(
                    {at, memory_finding(FindingKind::unwritten, &region, memory_text(region, first),
                                        access, place)});
            }
        }
        if (writes(access)) region.set_written(first, bytes);
    }
    Touch touch;
    touch.access = access;
    touch.block_scope = block_scope;
    touch.launch = launch_;
    touch.place = place;
    touch.stack = thread.stack_of_calls;
    touch.blocks = static_cast<std::uint32_t>(order_.size());
    bool reported = false;
    for (std::size_t byte = first; byte < first + bytes;) {
        const std::size_t word = byte / 4;
        const std::size_t end = std::min(first + bytes, word * 4 + 4);
        const unsigned mask = ((1u << (end - byte)) - 1u) << (byte - word * 4);
        Record other;
        if (find_race(region.cells[word], mask, touch, thread, other) && !reported) {
            reported = true;
            report_race(region, byte, access, other, place, at, bytes);
        }
        byte = end;
    }
}

void Machine::report_race(const Region& region, std::size_t byte, Access access,
                          const Record& other, std::uint32_t place, const std::byte* at,
                          std::size_t bytes) {
    Thread& thread = *current_thread;
    Finding finding;
    const bool both_write = access == Access::write && other.access == Access::write;
    finding.kind = both_write && bytes <= sizeof(OpenWrite::before) ? FindingKind::same_value_race
                                                                    : FindingKind::race;
    finding.kernel = info_.kernel;
    finding.what = memory_text(region, byte);
    if (access == Access::atomic && other.access == Access::atomic) {
        finding.what += ", atomically but in a scope that does not reach the other block";
    }
    finding.one = actor(thread, place, verb(access));
    finding.other = actor(other);
    finding.allocated = region.place;
    const bool open = finding.kind == FindingKind::same_value_race;
    const std::size_t position = findings_.add(std::move(finding));
    if (!open) return;
    OpenWrite write;
    write.address = at;
    write.bytes = static_cast<std::uint32_t>(bytes);
    std::memcpy(write.before.data(), at, bytes);
    write.finding = position;
    thread.open_writes.push_back(write);
}

void Machine::close_writes(Thread& thread) {
    for (const OpenWrite& write : thread.open_writes) {
        if (std::memcmp(write.address, write.before.data(), write.bytes) != 0) {
            findings_.make_race(write.finding);
        }
    }
    thread.open_writes.clear();
}

void Machine::check_elsewhere(Access access, const std::byte* at, std::size_t bytes,
                              std::uint32_t place) {
    if (memory_.in_arena(at)) {
        const Region* const below = memory_.nearest(at);
        std::string where = "device memory that nobody has allocated";
        if (below != nullptr) {
            where = memory_text(*below, static_cast<std::size_t>(at - below->begin)) + ": " +
                    std::to_string(at - (below->begin + below->bytes)) + " bytes behind its end";
            if (const Region* above = memory_.next(at);
                above != nullptr && above->begin - at < at - (below->begin + below->bytes)) {
                where = std::to_string(above->begin - at) + " bytes before the begin of " +
                        memory_text(*above, 0);
                report_memory(FindingKind::bounds, above, where, access, place);
                return;
            }
        }
        report_memory(FindingKind::bounds, below, where, access, place);
        return;
    }
    if (stacks_.holds(at)) {
        report_memory(FindingKind::bounds, nullptr, "local memory of another thread", access,
                      place);
        return;
    }
    // A step beyond a variable: what lies there belongs to somebody else.
    const Region* const below = memory_.nearest(at);
    if (below != nullptr && below->kind != RegionKind::device && !memory_.in_arena(below->begin) &&
        static_cast<std::size_t>(at - below->begin) < below->bytes + 256) {
        report_memory(FindingKind::bounds, below,
                      memory_text(*below, static_cast<std::size_t>(at - below->begin)), access,
                      place);
        return;
    }
    switch (host_memory(at)) {
        case HostMemory::read_only:
            if (writes(access)) {
                end_thread(FindingKind::constant_write, "a constant of the program is written",
                           place, kIllegalAddress);
            }
            return;
        case HostMemory::writable:
            report_memory(FindingKind::host_memory, nullptr, "memory of the host", access, place);
            return;
        case HostMemory::none:
            end_thread(FindingKind::bounds,
                       at < reinterpret_cast<const std::byte*>(4096)
                           ? std::string("a null pointer is followed")
                           : std::string("memory that is not there"),
                       place, kIllegalAddress);
    }
    static_cast<void>(bytes);
}

Finding Machine::memory_finding(FindingKind kind, const Region* region, const std::string& what,
                                Access access, std::uint32_t place) const {
    Finding finding;
    finding.kind = kind;
    finding.kernel = info_.kernel;
    finding.what = what;
    finding.one = actor(*current_thread, place, verb(access));
    if (region != nullptr) {
        finding.allocated = region->place;
        if (kind == FindingKind::freed && region->freed_place != 0) {
            finding.other.known = true;
            finding.other.in_kernel = false;
            finding.other.does = "frees it";
            finding.other.place = region->freed_place;
        }
    }
    return finding;
}

void Machine::report_memory(FindingKind kind, const Region* region, const std::string& what,
                            Access access, std::uint32_t place) {
    findings_.add(memory_finding(kind, region, what, access, place));
}

void Machine::report_unsure_reads(Thread& thread) {
    for (UnsureRead& read : thread.unsure_reads) findings_.add(std::move(read.finding));
    thread.unsure_reads.clear();
}

void Machine::record_copied(Access access, const void* record, std::size_t bytes,
                            std::size_t alignment) {
    Thread& thread = *current_thread;
    const auto* const begin = static_cast<const std::byte*>(record);
    findings_.calls().mark_copy(thread.stack_of_calls);
    const bool is_aligned = reinterpret_cast<std::uintptr_t>(begin) % alignment == 0;
    if (is_aligned && thread.unsure_reads.empty()) return;
    const Region* const region = thread.block->holds_shared(begin)
                                     ? shared_region(*thread.block, begin)
                                     : memory_.find(begin);
    if (region == nullptr) return;
    const auto first = static_cast<std::size_t>(begin - region->begin);
    if (!is_aligned) {
        report_memory(FindingKind::misaligned, region,
                      memory_text(*region, first) + ", " + std::to_string(bytes) +
                          " bytes at an address that is no multiple of " +
                          std::to_string(alignment),
                      access, thread.last_place);
    }
    std::size_t missing = 0;
    for (std::size_t byte = first; byte < first + bytes; ++byte) {
        missing += region->is_unwritten(byte) ? 1 : 0;
    }
    if (missing == bytes) return;
    std::erase_if(thread.unsure_reads, [&](const UnsureRead& read) {
        return read.at >= begin && read.at < begin + bytes;
    });
}

std::string Machine::memory_text(const Region& region, std::size_t byte) const {
    static constexpr const char* kNames[] = {"device memory",
                                             "pinned memory",
                                             "managed memory",
                                             "device variable",
                                             "constant",
                                             "shared",
                                             "memory of the kernel's malloc"};
    std::string text = kNames[static_cast<std::size_t>(region.kind)];
    if (!region.name.empty()) text += " " + region.name;
    return text + ", byte " + std::to_string(byte) + " of " + std::to_string(region.bytes);
}

Actor Machine::actor(const Thread& thread, std::uint32_t place, const char* does) const {
    Actor one;
    one.known = true;
    one.does = does;
    one.block = thread.block->at;
    one.thread = thread.at;
    one.place = place;
    one.stack = thread.stack_of_calls;
    return one;
}

Actor Machine::actor(const Record& record) const {
    Actor one;
    one.known = true;
    one.does = verb(record.access);
    one.block = block_of(record.block, info_.grid);
    std::uint32_t lane = 0;
    while ((record.lanes >> lane & 1u) == 0) ++lane;
    one.thread = block_of(record.warp * kWarp + lane, info_.block);
    one.place = record.place;
    one.stack = record.stack;
    return one;
}

void* Machine::shared_object(const void* site, const char* name, std::size_t bytes,
                             std::size_t alignment) {
    Block& block = *current_thread->block;
    for (SharedObject& object : block.objects) {
        if (object.site == site) return object.region.begin;
    }
    const std::size_t room = kMostShared + 4096;
    if (block.shared.size() != room) {
        block.shared.resize(room);
        block.cells.resize(room / 4);
        block.unwritten.resize(room / 8);
    }
    const std::size_t place = std::max<std::size_t>(alignment, 16);
    std::size_t offset = block.shared_used == 0 ? kSharedGap : block.shared_used + kSharedGap;
    const auto base = reinterpret_cast<std::uintptr_t>(block.shared.data());
    offset = (base + offset + place - 1) / place * place - base;
    if (offset + bytes + kSharedGap > room) {
        end_thread(FindingKind::launch,
                   "shared memory of more than 227 KiB, with " + std::string(name),
                   current_thread->last_place, kInvalidConfiguration);
    }
    block.shared_used = offset + bytes;
    const std::size_t first = offset / 16 * 16;
    std::memset(block.shared.data() + offset, kPoison, bytes);
    for (std::size_t word = first / 4; word < (offset + bytes + kSharedGap) / 4; ++word) {
        clear(block.cells[word]);
    }
    SharedObject object;
    object.site = site;
    object.region.begin = block.shared.data() + offset;
    object.region.bytes = bytes;
    object.region.kind = RegionKind::shared;
    object.region.name = name;
    object.region.cells = block.cells.data() + offset / 4;
    object.region.unwritten = block.unwritten.data() + offset / 8;
    std::memset(object.region.unwritten, 0xff, (bytes + 7) / 8);
    block.objects.push_back(std::move(object));
    return block.shared.data() + offset;
}

void* Machine::dynamic_shared() {
    static const char site = 0;
    return shared_object(&site, "memory of dynamic size", info_.dynamic_shared, 256);
}

void Machine::register_variable(void* variable, std::size_t bytes, const char* name, Space space) {
    memory_.add_variable(variable, bytes, name,
                         space == Space::constant  ? RegionKind::constant
                         : space == Space::managed ? RegionKind::managed
                                                   : RegionKind::variable);
}

void Machine::host_wrote(Region& region, const void* at, std::size_t bytes) {
    const auto first = static_cast<std::size_t>(static_cast<const std::byte*>(at) - region.begin);
    region.set_written(first, std::min(bytes, region.bytes - first));
}

void Machine::host_access(const void* at, bool writes_it, const void* place) {
    const Region* const region = memory_.find(at);
    if (region != nullptr && region->kind != RegionKind::device &&
        region->kind != RegionKind::heap && !region->freed) {
        return;
    }
    Finding finding;
    finding.kind =
        region != nullptr && region->freed ? FindingKind::freed : FindingKind::device_memory;
    finding.what =
        region == nullptr
            ? "device memory that nobody has allocated"
            : memory_text(*region, static_cast<std::size_t>(static_cast<const std::byte*>(at) -
                                                            region->begin));
    finding.one.known = true;
    finding.one.in_kernel = false;
    finding.one.does = writes_it ? "writes it" : "reads it";
    finding.one.place = offset_in_text(place);
    if (region != nullptr) finding.allocated = region->place;
    findings_.add(finding);
}

void Machine::report_call(FindingKind kind, const std::string& what, const void* place) {
    Finding finding;
    finding.kind = kind;
    finding.what = what;
    finding.one.known = true;
    finding.one.in_kernel = false;
    finding.one.place = offset_in_text(place);
    findings_.add(finding);
}

void Machine::enter_function(const void* caller, const void* entry) {
    Thread& thread = *current_thread;
    Machine& machine = get();
    thread.stack_of_calls = machine.findings_.calls().enter(
        thread.stack_of_calls, machine.offset_in_text(caller), machine.offset_in_text(entry));
}

void Machine::leave_function() {
    Thread& thread = *current_thread;
    if (!thread.unsure_reads.empty()) get().report_unsure_reads(thread);
    thread.stack_of_calls = get().findings_.calls().parent(thread.stack_of_calls);
}

}  // namespace scotty::emulation::cuda
