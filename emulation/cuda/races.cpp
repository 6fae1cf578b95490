#include "emulation/cuda/races.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace scotty::emulation::cuda {

namespace {

/// More records of readers than this become one of a block, and then one of the grid.
constexpr std::size_t kMostRecords = 40;

bool plain(Access access) { return access == Access::read || access == Access::write; }
bool writes_plainly(Access access) {
    return access == Access::write || access == Access::volatile_write;
}

/// Whether the two may not meet unordered.
bool conflict(const Record& earlier, const Touch& touch, std::uint32_t block) {
    const Access one = earlier.access;
    const Access other = touch.access;
    if (writes_plainly(one) || writes_plainly(other)) return true;
    const auto changes = [](Access access) {
        return access == Access::atomic || access == Access::flag_write;
    };
    if (!changes(one) && !changes(other)) return false;
    if (plain(one) || plain(other)) return true;
    return earlier.block != block && (earlier.block_scope || touch.block_scope);
}

/// Whether everything that the record stands for happened before what the thread does now.
bool ordered(const Record& earlier, const Thread& thread, const Touch& touch) {
    const Block& block = *thread.block;
    const Clocks* const acquired = thread.acquired.get();
    if (earlier.level == Level::grid) {
        if (earlier.clock >= block.base) return false;
        for (std::uint32_t other = 0; other < touch.blocks; ++other) {
            if (other == block.index) continue;
            if (acquired == nullptr || earlier.clock >= acquired->of_block(other)) return false;
        }
        return true;
    }
    const bool own = earlier.block == block.index;
    if (own && earlier.clock < block.base) return true;
    if (acquired != nullptr && earlier.clock < acquired->of_block(earlier.block)) return true;
    if (earlier.level == Level::block) return false;
    const bool own_warp = own && earlier.warp == thread.warp();
    for (std::uint32_t lanes = earlier.lanes; lanes != 0; lanes &= lanes - 1) {
        const auto lane = static_cast<std::uint32_t>(std::countr_zero(lanes));
        const bool self = own_warp && lane == thread.lane();
        if (self || (own_warp && earlier.clock < thread.known[lane])) continue;
        if (acquired == nullptr) return false;
        const std::uint32_t other = earlier.warp * kWarp + lane;
        if (earlier.clock >= acquired->of_thread(earlier.block, other)) return false;
    }
    return true;
}

/// Whether whoever conflicts with the earlier one, unordered, conflicts with this one, too.
bool covers(const Touch& touch, unsigned bytes, const Record& earlier) {
    if ((earlier.bytes & ~bytes) != 0) return false;
    if (touch.access == Access::write) return true;
    return touch.access == earlier.access && (!earlier.block_scope || touch.block_scope);
}

/// Joins all readers of a block, or of the grid, into one record each.
void join_readers(std::vector<Record>& records, bool whole_grid) {
    std::vector<Record> joined;
    for (Record& record : records) {
        const auto same = std::find_if(joined.begin(), joined.end(), [&](const Record& other) {
            return other.access == record.access && other.bytes == record.bytes &&
                   other.block_scope == record.block_scope &&
                   (whole_grid || other.block == record.block);
        });
        if (same == joined.end() || writes_plainly(record.access)) {
            joined.push_back(record);
            continue;
        }
        same->level = whole_grid ? Level::grid : Level::block;
        same->clock = std::max(same->clock, record.clock);
    }
    records = std::move(joined);
}

}  // namespace

bool find_race(Cell& cell, unsigned bytes, const Touch& touch, const Thread& thread,
               Record& other) {
    bool found = false;
    bool noted = false;
    const std::uint32_t lane = 1u << thread.lane();
    // Returns whether the record stays.
    const auto look = [&](Record& record) {
        if (record.launch != touch.launch) return false;  // launches follow one another
        if ((record.bytes & bytes) == 0) return true;
        const bool same_warp = record.level == Level::lanes &&
                               record.block == thread.block->index && record.warp == thread.warp();
        const bool same = same_warp && record.clock == thread.clock &&
                          record.access == touch.access && record.block_scope == touch.block_scope;
        if (same && record.lanes == lane && (bytes & ~record.bytes) == 0) {
            noted = true;
            return true;
        }
        if (!found && conflict(record, touch, thread.block->index) &&
            !ordered(record, thread, touch)) {
            found = true;
            other = record;
        }
        if (same && record.bytes == bytes && !noted) {
            record.lanes |= lane;
            noted = true;
            return true;
        }
        return !(covers(touch, bytes, record) && ordered(record, thread, touch));
    };
    for (Record& record : cell.first) {
        if (record.access != Access::none && !look(record)) record.access = Access::none;
    }
    if (cell.more != nullptr) {
        auto& more = *cell.more;
        for (std::size_t i = 0; i < more.size();) {
            if (look(more[i])) {
                ++i;
            } else {
                more[i] = more.back();
                more.pop_back();
            }
        }
    }
    if (noted) return found;
    Record now;
    now.access = touch.access;
    now.bytes = bytes & 0xfu;
    now.block_scope = touch.block_scope;
    now.warp = static_cast<std::uint8_t>(thread.warp());
    now.launch = touch.launch;
    now.block = thread.block->index;
    now.lanes = lane;
    now.clock = thread.clock;
    now.place = touch.place;
    now.stack = touch.stack;
    for (Record& record : cell.first) {
        if (record.access != Access::none) continue;
        record = now;
        return found;
    }
    if (cell.more == nullptr) cell.more = new std::vector<Record>;
    if (cell.more->size() >= kMostRecords) join_readers(*cell.more, false);
    if (cell.more->size() >= kMostRecords) join_readers(*cell.more, true);
    if (cell.more->size() >= kMostRecords) {
        cell.more->front() = now;  // so many writers of one word have raced already
    } else {
        cell.more->push_back(now);
    }
    return found;
}

void clear(Cell& cell) {
    cell.first[0] = {};
    cell.first[1] = {};
    delete cell.more;
    cell.more = nullptr;
}

}  // namespace scotty::emulation::cuda
