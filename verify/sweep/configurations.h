/// Which configurations of the pipeline a verification runs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "emulation/execution/schedule.h"
#include "reference/contract/pipeline_parameters.h"

namespace scotty::verify {

using emulation::Schedule;

/// The options that make this picture: "--size 45x37 --spp 2 --bounces 2 ...".
std::string picture_options(const reference::PipelineParameters& parameters);
/// Those that select this way to make it: "--width 8 --rays-per-block 64 ...".
std::string pipeline_options(const reference::PipelineParameters& parameters);

struct Configuration {
    reference::PipelineParameters parameters;
    Schedule schedule{};

    emulation::DeviceOptions device(std::size_t threads) const;
    /// "width 8, 64 rays per block, early-out level, buffer of 8, linear, shadow any, free".
    std::string label() const;
    /// The options that select exactly this one: pipeline_options() and the schedule.
    std::string options() const;
};

/// Values asked for. What is empty is not restricted.
struct ConfigurationFilter {
    std::vector<int> widths;
    std::vector<int> rays_per_block;
    std::vector<std::uint32_t> queue_levels;
    std::vector<reference::QueueKind> queues;
    std::vector<reference::EarlyOut> early_out;
    std::vector<reference::HitMode> hit_mode;
    std::vector<reference::BlockOrder> block_order;
    std::vector<reference::ShadowQuery> shadow_query;
    std::vector<std::uint32_t> hit_capacity;
    std::vector<std::uint32_t> batch_rays;
    std::vector<std::uint32_t> samples_per_pass;
    std::vector<Schedule> schedule;
    bool all = false;          ///< every combination of what is not restricted, too
    std::size_t strength = 2;  ///< or how many of these factors meet in all their values: 2 or 3

    bool restricts() const {
        return !(widths.empty() && rays_per_block.empty() && queue_levels.empty() &&
                 queues.empty() && early_out.empty() && hit_mode.empty() && block_order.empty() &&
                 shadow_query.empty() && hit_capacity.empty() && batch_rays.empty() &&
                 samples_per_pass.empty() && schedule.empty());
    }
};

/// What all others are compared with: nothing is culled, every hit is kept, plain order.
Configuration baseline_configuration(const reference::PipelineParameters& base);

/// All combinations of the values asked for; each with rows that cover every pair of values of the
/// parameters not restricted (or all combinations, with `all`), and, unless restricted, one run in
/// small odd batches. Image, seed and the like are `base`'s. Validated; no duplicates.
std::vector<Configuration> configurations(const reference::PipelineParameters& base,
                                          const ConfigurationFilter& filter);

}  // namespace scotty::verify
