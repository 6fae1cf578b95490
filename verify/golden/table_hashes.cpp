/// Hashes of the contract's tables and of what schedules come to, as text.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "emulation/execution/launch_error.h"
#include "emulation/execution/schedule.h"
#include "emulation/execution/shared_memory.h"
#include "emulation/execution/thread_order.h"
#include "reference/base/error.h"
#include "reference/contract/batch_plan.h"
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
    for (const char* word : {"", "line", "linear", "shuffle:", "shuffle:1x", "shuffle:12"}) {
        try {
            text += to_string(parse_schedule(word)) + '\n';
        } catch (const reference::Error& error) {
            text += std::string(error.what()) + '\n';
        }
    }
    return text;
}

/// Where the executor puts what a block declares, how it names places in it, and what it says of
/// threads that do not meet.
std::string executor_as_text() {
    using namespace emulation::simt;
    std::string text;
    const auto memory = std::make_unique<SharedMemory>();
    const char places[SharedMemory::kMostObjects + 1] = {};
    const auto declare = [&](const void* place, std::size_t bytes, std::size_t alignment) {
        try {
            const void* const at = memory->object(place, "object", bytes, alignment);
            text += fmt::format("{} of {}: {}\n", bytes, alignment,
                                static_cast<const std::byte*>(at) - memory->memory());
        } catch (const reference::Error& error) {
            text += std::string(error.what()) + '\n';
        }
    };
    for (int again = 0; again < 2; ++again) {
        memory->reset();
        text += fmt::format("dynamic {}\n", memory->dynamic() != nullptr);
        declare(&places[0], 5, 4);
        if (again != 0) declare(&kDynamicShared, 100, 16);
        declare(&places[1], 12, 128);
        declare(&places[2], 1, 1);
        declare(&places[0], 5, 4);
        text += fmt::format("dynamic {}\n", memory->dynamic() != nullptr);
        for (std::size_t at = 0; at < memory->used() + 4; ++at) {
            text += fmt::format("{}{}\n", memory->name_at(at),
                                at < memory->used() && memory->in_gap(at) ? ", a gap" : "");
        }
        memory->each_gap([&](std::size_t begin, std::size_t end) {
            text += fmt::format("{} to {}\n", begin, end);
        });
        declare(&places[3], SharedMemory::kMostDeclared, 4);
        for (std::size_t i = 3; i <= SharedMemory::kMostObjects; ++i) declare(&places[i], 8, 8);
        memory->reset();
        declare(&places[3], SharedMemory::kMostDeclared + 1, 4);
        declare(&places[3], SharedMemory::kMostDeclared, 4);
    }
    const Site barrier{"a.h", 12, SiteKind::barrier};
    const Site collective{"b.h", 34, SiteKind::collective};
    const Site left{"c.h", 56, SiteKind::exit};
    for (const std::vector<std::uint32_t>& threads :
         {std::vector<std::uint32_t>{3}, {0, 1}, {0, 1, 2, 7, 9, 10, 31}}) {
        for (const Site* site : {&barrier, &collective}) {
            text += to_text(ThreadGroup{site, nullptr, threads}) + '\n';
        }
        text += to_text(ThreadGroup{&kLeft, nullptr, threads}) + '\n';
        text += to_text(ThreadGroup{&kLeft, &left, threads}) + '\n';
    }
    const LaunchError error("a kernel", 7, 64, {}, "why");
    return text + fmt::format("{} {} {}\n", error.what(), error.kernel, error.block);
}

/// How renders of all sizes are cut into batches: nobody renders a million samples to see it.
std::string batches_as_text() {
    std::string text;
    reference::PipelineParameters p;
    for (const std::uint32_t size : {1u, 45u, 4096u}) {
        p.image_width = size;
        p.image_height = size == 1 ? 1 : size / 3;
        for (const std::uint32_t spp : {1u, 2u, 47u, 65537u, 1u << 20}) {
            p.spp = spp;
            for (const std::uint32_t pass : {0u, 1u, 5u, 65536u, 70000u}) {
                p.samples_per_pass = pass;
                for (const std::uint32_t rays : {64u, 1000u, 262144u, 1u << 24}) {
                    p.batch_rays = rays;
                    const reference::BatchPlan plan(p);
                    text += fmt::format("{}:", plan.size());
                    for (const std::uint64_t batch :
                         {std::uint64_t{0}, std::uint64_t{1}, plan.size() / 2, plan.size() - 1}) {
                        if (batch >= plan.size()) continue;
                        const reference::BatchView view = plan[batch];
                        text += fmt::format(" {}+{} {}+{}", view.first_pixel, view.pixels,
                                            view.first_sample, view.samples);
                    }
                    text += '\n';
                }
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
                               {"table of the executor", hash_of_text(executor_as_text())},
                               {"table of batches", hash_of_text(batches_as_text())},
                               {"table of numerics", hash_of_numerics()}};
    return tables;
}

}  // namespace scotty::verify
