/// The counts of bench_occupancy.h as tables and as JSON.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "verify/backends/machine.h"
#include "verify/bench/bench_occupancy.h"

namespace scotty::verify {

using reference::EarlyOut;
using reference::PipelineParameters;

namespace {

double per(std::uint64_t amount, std::uint64_t of) {
    return of == 0 ? 0.0 : static_cast<double>(amount) / static_cast<double>(of);
}

/// Part of the lanes of blocks, and of the warps that have entries, that hold one.
double block_lanes(const TraversalCounts& counts, const PipelineParameters& parameters) {
    return per(counts.lanes(),
               counts.blocks * static_cast<std::uint64_t>(parameters.rays_per_block));
}
double warp_lanes(const TraversalCounts& counts) { return per(counts.lanes(), 32 * counts.warps); }

/// Part of the visits with early-out off that the early-out saved.
double saved(const TraversalCounts& counts) {
    return counts.visits_uncut == 0 ? 0.0 : 1.0 - per(counts.visits, counts.visits_uncut);
}

std::string kind_row(const TraversalCounts& counts) {
    return fmt::format(
        "{:<10} {:>10} {:>8.2f} {:>7.1f} {:>7.1f} {:>8.2f} {:>7.1f} {:>8.1f} {:>8.1f} {:>8.0f}\n",
        counts.name, counts.rays, per(counts.visits, counts.rays),
        100.0 * per(counts.redundant, counts.visits), 100.0 * saved(counts),
        per(counts.leaf_hits, counts.rays),
        100.0 * per(counts.leaf_hits - counts.hits, counts.leaf_hits),
        per(counts.box_tests, counts.rays), per(counts.triangle_tests, counts.rays),
        per(counts.traffic.total(), counts.rays));
}

std::string level_row(const TraversalCounts& counts, const PipelineParameters& parameters) {
    return fmt::format(
        "{:<10} {:>10} {:>8.1f} {:>5} {:>5} {:>5} {:>8.1f} {:>7.1f} {:>11} {:>7.1f} {:>7.1f}\n",
        counts.name, counts.blocks, per(counts.lanes(), counts.blocks), counts.fill_quantile(0.1),
        counts.fill_quantile(0.5), counts.fill_quantile(0.9),
        100.0 * block_lanes(counts, parameters), 100.0 * warp_lanes(counts), counts.visits,
        100.0 * per(counts.redundant, counts.visits), 100.0 * saved(counts));
}

nlohmann::json row_json(const TraversalCounts& counts, const PipelineParameters& parameters) {
    return {{"name", counts.name},
            {"rays", counts.rays},
            {"dead_visits", counts.dead},
            {"visits", counts.visits},
            {"visits_redundant", counts.redundant},
            {"visits_with_early_out_off", counts.visits_uncut},
            {"visits_saved", saved(counts)},
            {"leaf_hits", counts.leaf_hits},
            {"hits", counts.hits},
            {"box_tests", counts.box_tests},
            {"triangle_tests", counts.triangle_tests},
            {"blocks", counts.blocks},
            {"warps", counts.warps},
            {"blocks_by_rays", counts.fill},
            {"rays_per_block",
             {{"mean", per(counts.lanes(), counts.blocks)},
              {"tenth", counts.fill_quantile(0.1)},
              {"median", counts.fill_quantile(0.5)},
              {"nine_tenths", counts.fill_quantile(0.9)}}},
            {"active_lanes",
             {{"of_blocks", block_lanes(counts, parameters)}, {"of_warps", warp_lanes(counts)}}},
            {"traffic_bytes",
             {{"queues", counts.traffic.queues},
              {"rays", counts.traffic.rays},
              {"nodes", counts.traffic.nodes},
              {"triangles", counts.traffic.triangles},
              {"hits", counts.traffic.hits},
              {"all", counts.traffic.total()}}}};
}

}  // namespace

std::string table(const Occupancy& occupancy) {
    std::string out = fmt::format("{:<10} {:>10} {:>8} {:>7} {:>7} {:>8} {:>7} {:>8} {:>8} {:>8}\n",
                                  "counted", "rays", "visits", "redun-", "saved", "leaf", "not",
                                  "boxes", "triang.", "bytes");
    out += fmt::format("{:<10} {:>10} {:>8} {:>7} {:>7} {:>8} {:>7} {:>8} {:>8} {:>8}\n", "", "",
                       "a ray", "dant %", "%", "hits/ray", "final %", "a ray", "a ray", "a ray");
    for (const TraversalCounts& kind : occupancy.kinds) out += kind_row(kind);
    out += kind_row(occupancy.all);
    out += fmt::format("\n{:<10} {:>10} {:>8} {:>5} {:>5} {:>5} {:>8} {:>7} {:>11} {:>7} {:>7}\n",
                       "counted", "blocks", "rays in", "10 %", "half", "90 %", "lanes %", "lanes %",
                       "visits", "redun-", "saved");
    out += fmt::format("{:<10} {:>10} {:>8} {:>5} {:>5} {:>5} {:>8} {:>7} {:>11} {:>7} {:>7}\n", "",
                       "", "a block", "have", "have", "have", "of block", "of warp", "", "dant %",
                       "%");
    for (const TraversalCounts& level : occupancy.levels)
        out += level_row(level, occupancy.parameters);
    out += level_row(occupancy.all, occupancy.parameters);
    out += fmt::format(
        "\n{} rays in flight, {:.0f} bytes of buffers each; BVH {}, of it triangles {}\n",
        occupancy.rays_in_flight, per(occupancy.device_bytes, occupancy.rays_in_flight),
        readable_bytes(occupancy.bvh_bytes), readable_bytes(occupancy.triangle_bytes));
    return out;
}

nlohmann::json to_json(const Occupancy& occupancy) {
    const auto rows_json = [&](const std::vector<TraversalCounts>& rows) {
        nlohmann::json out = nlohmann::json::array();
        for (const TraversalCounts& row : rows) out.push_back(row_json(row, occupancy.parameters));
        return out;
    };
    return {{"rays", rows_json(occupancy.kinds)},
            {"levels", rows_json(occupancy.levels)},
            {"all", row_json(occupancy.all, occupancy.parameters)},
            {"rays_in_flight", occupancy.rays_in_flight},
            {"device_bytes_per_ray", per(occupancy.device_bytes, occupancy.rays_in_flight)},
            {"bvh_bytes", occupancy.bvh_bytes},
            {"triangle_bytes", occupancy.triangle_bytes},
            {"depends_on_schedule", occupancy.parameters.early_out == EarlyOut::immediate}};
}

}  // namespace scotty::verify
