#include "verify/sweep/configurations.h"

#include <fmt/format.h>

#include <functional>
#include <set>
#include <utility>

#include "reference/base/error.h"
#include "reference/contract/parameter_table.h"
#include "verify/sweep/covering_array.h"

namespace scotty::verify {

using reference::BlockOrder;
using reference::EarlyOut;
using reference::HitMode;
using reference::ParameterGroup;
using reference::PipelineParameters;
using reference::QueueKind;
using reference::ShadowQuery;

namespace {

/// Rays a batch of the extra run: odd, so that no batch ends where a block, row or image does.
constexpr std::uint32_t kOddBatch = 331;

/// One parameter: its values, as changes to a configuration.
struct Factor {
    std::vector<std::function<void(Configuration&)>> values;
    bool asked = false;
};

template <class T>
Factor factor(T PipelineParameters::*member, const std::vector<T>& asked, std::vector<T> usual) {
    Factor out;
    out.asked = !asked.empty();
    for (const T& value : out.asked ? asked : usual) {
        out.values.push_back([=](Configuration& c) { c.parameters.*member = value; });
    }
    return out;
}

Factor schedules_of(const std::vector<Schedule>& asked, std::vector<Schedule> usual) {
    Factor out;
    out.asked = !asked.empty();
    for (const Schedule& value : out.asked ? asked : usual) {
        out.values.emplace_back([=](Configuration& c) { c.schedule = value; });
    }
    return out;
}

std::vector<Factor> factors_of(const PipelineParameters& base, const ConfigurationFilter& filter) {
    std::vector<std::uint32_t> capacities{base.hit_capacity};
    if (!filter.all && base.hit_capacity != 1) capacities.push_back(1);  // has to grow
    std::vector<Schedule> schedules{{}};
    if (!filter.all) {
        using emulation::ScheduleKind;
        schedules = {{}, {ScheduleKind::linear, 0}, {ScheduleKind::shuffled, base.seed}};
    }
    using P = PipelineParameters;
    return {factor(&P::width, filter.widths, {8, 2, 4, 16}),
            factor(&P::rays_per_block, filter.rays_per_block, {64, 32, 256, 1024}),
            factor(&P::queue_levels, filter.queue_levels, {0, 2, 1, 3}),
            factor(&P::queues, filter.queues, {QueueKind::nodes, QueueKind::pairs}),
            factor(&P::early_out, filter.early_out,
                   {EarlyOut::level, EarlyOut::off, EarlyOut::immediate}),
            factor(&P::hit_mode, filter.hit_mode, {HitMode::buffer, HitMode::packed}),
            factor(&P::block_order, filter.block_order, {BlockOrder::linear, BlockOrder::strided}),
            factor(&P::shadow_query, filter.shadow_query, {ShadowQuery::any, ShadowQuery::closest}),
            factor(&P::hit_capacity, filter.hit_capacity, capacities),
            factor(&P::batch_rays, filter.batch_rays, {base.batch_rays}),
            factor(&P::samples_per_pass, filter.samples_per_pass, {base.samples_per_pass}),
            schedules_of(filter.schedule, schedules)};
}

}  // namespace

emulation::DeviceOptions Configuration::device(std::size_t threads) const {
    const bool one_by_one = schedule.kind != emulation::ScheduleKind::free;
    return {one_by_one ? 1 : threads, schedule.kind, schedule.seed};
}

std::string Configuration::label() const {
    const PipelineParameters& p = parameters;
    const std::string hits = p.hit_mode == HitMode::packed
                                 ? std::string("packed")
                                 : fmt::format("buffer of {}", p.hit_capacity);
    const std::string levels =
        p.queue_levels == 0 ? "" : fmt::format("{} queue levels, ", p.queue_levels);
    const char* queues = p.queues == QueueKind::pairs ? "queues of pairs, " : "";
    return fmt::format(
        "width {}, {} rays per block, {}{}early-out {}, {}, {}, shadow {}, {}, batches of {}",
        p.width, p.rays_per_block, levels, queues, to_string(p.early_out), hits,
        to_string(p.block_order), to_string(p.shadow_query), to_string(schedule), p.batch_rays);
}

std::string picture_options(const PipelineParameters& p) {
    return reference::options_of(p, {ParameterGroup::picture});
}

std::string pipeline_options(const PipelineParameters& p) {
    return reference::options_of(p, {ParameterGroup::tree, ParameterGroup::pipeline});
}

std::string Configuration::options() const {
    return fmt::format("{} --schedule {}", pipeline_options(parameters), to_string(schedule));
}

Configuration baseline_configuration(const PipelineParameters& base) {
    Configuration configuration{base, {}};
    configuration.parameters.width = 8;
    configuration.parameters.queue_levels = 0;
    configuration.parameters.queues = QueueKind::nodes;
    configuration.parameters.early_out = EarlyOut::off;
    configuration.parameters.hit_mode = HitMode::buffer;
    configuration.parameters.block_order = BlockOrder::linear;
    configuration.parameters.shadow_query = ShadowQuery::closest;
    configuration.parameters.samples_per_pass = 0;
    return configuration;
}

std::vector<Configuration> configurations(const PipelineParameters& base,
                                          const ConfigurationFilter& filter) {
    const std::vector<Factor> factors = factors_of(base, filter);
    std::vector<std::size_t> asked;
    std::vector<std::size_t> free;
    std::vector<std::size_t> asked_sizes;
    std::vector<std::size_t> free_sizes;
    for (std::size_t f = 0; f < factors.size(); ++f) {
        (factors[f].asked ? asked : free).push_back(f);
        (factors[f].asked ? asked_sizes : free_sizes).push_back(factors[f].values.size());
    }
    const auto free_rows =
        filter.all ? product_rows(free_sizes) : covering_rows(free_sizes, filter.strength);
    std::vector<Configuration> out;
    std::set<std::string> seen;
    const auto add = [&](Configuration configuration) {
        // One that differs only in what it does not use is no other configuration.
        if (configuration.parameters.hit_mode == HitMode::packed) {
            configuration.parameters.hit_capacity = base.hit_capacity;
        }
        reference::validate(configuration.parameters);
        if (seen.insert(configuration.options()).second) out.push_back(configuration);
    };
    for (const auto& asked_row : product_rows(asked_sizes)) {
        for (const auto& free_row : free_rows) {
            Configuration configuration{base, {}};
            for (std::size_t k = 0; k < asked.size(); ++k) {
                factors[asked[k]].values[asked_row[k]](configuration);
            }
            for (std::size_t k = 0; k < free.size(); ++k) {
                factors[free[k]].values[free_row[k]](configuration);
            }
            add(configuration);
        }
    }
    if (asked.empty()) {
        Configuration small{base, {}};
        small.parameters.batch_rays = kOddBatch;
        small.parameters.hit_capacity = 1;
        small.parameters.block_order = BlockOrder::strided;
        add(small);
    }
    return out;
}

}  // namespace scotty::verify
