#include "emulation/execution/schedule.h"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <random>
#include <utility>

#include "reference/base/error.h"

namespace scotty::emulation {

namespace {

constexpr std::pair<ScheduleKind, const char*> kWords[] = {
    {ScheduleKind::free, "free"},
    {ScheduleKind::linear, "linear"},
    {ScheduleKind::reversed, "reversed"},
    {ScheduleKind::strided, "strided"},
    {ScheduleKind::adversarial, "adversarial"}};
constexpr const char* kShuffle = "shuffle:";

/// Goes column by column through the smallest square that holds all.
std::vector<std::uint32_t> strided_order(std::uint32_t count) {
    std::uint64_t side = 0;
    while (side * side < count) ++side;
    std::vector<std::uint32_t> order;
    order.reserve(count);
    for (std::uint64_t column = 0; column < side; ++column) {
        for (std::uint64_t block = column; block < count; block += side) {
            order.push_back(static_cast<std::uint32_t>(block));
        }
    }
    return order;
}

std::vector<std::uint32_t> adversarial_order(std::uint64_t launch,
                                             std::vector<std::uint32_t> order) {
    const std::vector<std::uint32_t> ascending = order;
    const std::size_t count = order.size();
    switch (launch % 4) {
        case 1:
            std::rotate(order.begin(), order.begin() + (count > 0 ? 1 : 0), order.end());
            break;
        case 2:
            for (std::size_t i = 0; i < count; ++i) {
                order[i] = ascending[i % 2 == 0 ? count - 1 - i / 2 : i / 2];
            }
            break;
        case 3:
            std::stable_partition(order.begin(), order.end(),
                                  [](std::uint32_t block) { return block % 2 == 1; });
            break;
        default:
            std::rotate(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count / 2),
                        order.end());
            break;
    }
    return order;
}

}  // namespace

std::string to_string(const Schedule& schedule) {
    for (const auto& [kind, word] : kWords) {
        if (schedule.kind == kind) return word;
    }
    return kShuffle + std::to_string(schedule.seed);
}

Schedule parse_schedule(const std::string& word) {
    for (const auto& [kind, valid] : kWords) {
        if (word == valid) return {kind, 0};
    }
    if (word.starts_with(kShuffle)) {
        const char* const first = word.data() + std::char_traits<char>::length(kShuffle);
        const char* const last = word.data() + word.size();
        Schedule schedule{ScheduleKind::shuffled, 0};
        const auto [end, error] = std::from_chars(first, last, schedule.seed);
        if (error == std::errc() && end == last) return schedule;
    }
    throw reference::Error::bad_input(
        "--schedule",
        "expected one of free, linear, reversed, strided, adversarial, shuffle:SEED (a number), "
        "found '" +
            word + "'");
}

std::vector<Schedule> seeded_schedules(std::size_t count) {
    std::vector<Schedule> schedules{{ScheduleKind::linear, 0},
                                    {ScheduleKind::reversed, 0},
                                    {ScheduleKind::strided, 0},
                                    {ScheduleKind::adversarial, 0}};
    if (count < schedules.size()) schedules.resize(count);
    for (std::uint64_t seed = 1; schedules.size() < count; ++seed) {
        schedules.push_back({ScheduleKind::shuffled, seed});
    }
    return schedules;
}

std::vector<std::uint32_t> block_order(const Schedule& schedule, std::uint64_t launch,
                                       std::uint32_t count) {
    std::vector<std::uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    switch (schedule.kind) {
        case ScheduleKind::reversed:
            std::reverse(order.begin(), order.end());
            break;
        case ScheduleKind::strided:
            return strided_order(count);
        case ScheduleKind::adversarial:
            return adversarial_order(launch, std::move(order));
        case ScheduleKind::shuffled: {
            std::mt19937_64 generator(schedule.seed + 0x9e3779b97f4a7c15ull * launch);
            // Not std::shuffle: its order is the library's choice, and a seed must replay anywhere.
            for (std::size_t left = order.size(); left > 1; --left) {
                std::swap(order[left - 1], order[generator() % left]);
            }
            break;
        }
        default:
            break;
    }
    return order;
}

}  // namespace scotty::emulation
