/// Hashes of the contract's tables and of what schedules come to, as text.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdint>
#include <string>
#include <vector>

#include "emulation/execution/schedule.h"
#include "emulation/execution/thread_order.h"
#include "reference/contract/buffers.h"
#include "reference/contract/parameter_table.h"
#include "reference/contract/stages.h"
#include "verify/golden/hash_book.h"

namespace scotty::verify {

namespace {

std::string_view name_of(const reference::BufferInfo* info) {
    return info == nullptr ? std::string_view("none") : info->name;
}

std::string parameters_as_text() {
    std::string text;
    for (const reference::ParameterInfo& info : reference::kParameters) {
        text += fmt::format("{} {} {} {} {} {} {} {} {}\n", info.name, info.option, info.title,
                            info.help, static_cast<int>(info.group), valid_values(info),
                            info.zero_is_all, info.added_later, text_of(info, {}));
    }
    return text;
}

std::string buffers_as_text() {
    std::string text;
    for (const reference::BufferInfo* info : reference::kBuffers) {
        text += fmt::format(
            "{} {} {} {} {} {} {} {} {} {} {} {} {} {}\n", info->name, static_cast<int>(info->row),
            static_cast<int>(info->content), static_cast<int>(info->order), name_of(info->lengths),
            name_of(info->offsets), name_of(info->written_as), info->depends_on_timing,
            info->tolerance.relative, info->tolerance.share, info->tolerance.only, info->meaning,
            static_cast<int>(info->type), info->element_bytes);
        for (const reference::Field& field : info->fields) {
            text += fmt::format("  {} {} {} {}\n", field.name, field.is_float,
                                field.may_be_infinite, field.blank);
        }
    }
    return text;
}

std::string stages_as_text() {
    std::string text;
    const auto list = [&](const char* what, const auto& buffers) {
        text += fmt::format("  {}:", what);
        for (const auto& one : buffers) {
            text += fmt::format(" {} {}", name_of(one.buffer), static_cast<int>(one.when));
        }
        text += '\n';
    };
    for (const reference::StageInfo& stage : reference::kStages) {
        text += fmt::format("{} {} {} {} {}\n", static_cast<int>(stage.kind), stage.name,
                            stage.label, static_cast<int>(stage.thread), stage.of_traversal);
        list("inputs", stage.inputs);
        list("outputs", stage.outputs);
        list("lowers", stage.lowers);
        list("needs", stage.needs);
        for (const auto& need : stage.needs) text += std::to_string(static_cast<int>(need.source));
        for (const char* invariant : stage.invariants) text += fmt::format("  {}\n", invariant);
    }
    return text;
}

/// A schedule that is named is the same one everywhere and from now on: reports and replays name
/// it.
std::string schedules_as_text() {
    using namespace emulation;
    std::string text;
    std::vector<Schedule> all = seeded_schedules(8);
    all.push_back({ScheduleKind::shuffled, 0xfedcba9876543210u});
    for (const Schedule& schedule : all) {
        text += to_string(schedule) + '\n';
        for (const std::uint64_t launch : {1u, 2u, 3u, 4u, 1000u}) {
            for (const std::uint32_t blocks : {0u, 1u, 2u, 7u, 16u, 17u}) {
                text += fmt::format("{}\n", fmt::join(block_order(schedule, launch, blocks), " "));
            }
            simt::ThreadOrder order;
            const std::uint64_t seed = simt::mixed(schedule.seed, launch, 5);
            text += fmt::format("{:x}\n", seed);
            for (const std::uint32_t warps : {1u, 7u, 32u}) {
                order.start_block(schedule.kind, seed, warps);
                order.start_phase();
                const auto* const end = order.warp_order.begin() + warps;
                text += fmt::format("{} {}\n", fmt::join(order.warp_order.begin(), end, " "),
                                    fmt::join(order.lane_order, " "));
            }
        }
    }
    return text;
}

}  // namespace

Hashes table_hashes() {
    static const Hashes tables{{"table of parameters", hash_of_text(parameters_as_text())},
                               {"table of buffers", hash_of_text(buffers_as_text())},
                               {"table of stages", hash_of_text(stages_as_text())},
                               {"table of schedules", hash_of_text(schedules_as_text())},
                               {"table of numerics", hash_of_numerics()}};
    return tables;
}

}  // namespace scotty::verify
