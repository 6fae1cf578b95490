#include "verify/bench/bench_occupancy.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "emulation/host/pipeline.h"
#include "reference/base/error.h"
#include "verify/bench/occupancy_counter.h"

namespace scotty::verify {

using reference::EarlyOut;
using reference::PipelineParameters;

TraversalCounts& row_of(std::vector<TraversalCounts>& rows, const std::string& name) {
    for (TraversalCounts& row : rows) {
        if (row.name == name) return row;
    }
    rows.emplace_back().name = name;
    return rows.back();
}

void TraversalCounts::add(const TraversalCounts& other) {
    rays += other.rays;
    dead += other.dead;
    visits += other.visits;
    blocks += other.blocks;
    warps += other.warps;
    fill.resize(std::max(fill.size(), other.fill.size()));
    for (std::size_t i = 0; i < other.fill.size(); ++i) fill[i] += other.fill[i];
    redundant += other.redundant;
    visits_uncut += other.visits_uncut;
    leaf_hits += other.leaf_hits;
    hits += other.hits;
    box_tests += other.box_tests;
    triangle_tests += other.triangle_tests;
    traffic.queues += other.traffic.queues;
    traffic.rays += other.traffic.rays;
    traffic.nodes += other.traffic.nodes;
    traffic.triangles += other.traffic.triangles;
    traffic.hits += other.traffic.hits;
}

std::uint32_t TraversalCounts::fill_quantile(double part) const {
    const double wanted = part * static_cast<double>(blocks);
    std::uint64_t seen = 0;
    for (std::size_t entries = 1; entries < fill.size(); ++entries) {
        seen += fill[entries];
        if (seen > 0 && static_cast<double>(seen) >= wanted) {
            return static_cast<std::uint32_t>(entries);
        }
    }
    return 0;
}

Occupancy count_occupancy(const reference::Scene& scene, const reference::WideBvh& bvh,
                          const PipelineParameters& parameters, std::size_t threads,
                          const std::function<void(const std::string&)>& progress) {
    if (parameters.queues == reference::QueueKind::pairs) {
        throw reference::Error::bad_input(
            "--queues", "occupancy counts the blocks of each node's queue; use --queues nodes");
    }
    const auto render = [&](EarlyOut early_out) {
        if (progress) progress(fmt::format("counting, early-out {}", to_string(early_out)));
        PipelineParameters p = parameters;
        p.early_out = early_out;
        p.hit_mode = reference::HitMode::buffer;
        p.arithmetic = reference::Arithmetic::exact;
        OccupancyCounter counter(bvh, p);
        emulation::Pipeline pipeline(scene, bvh, p, {threads}, &counter);
        pipeline.render();
        Occupancy counted = counter.result();
        counted.device_bytes = pipeline.device_bytes();
        return counted;
    };
    Occupancy out = render(parameters.early_out);
    const Occupancy uncut = parameters.early_out == EarlyOut::off ? out : render(EarlyOut::off);
    out.parameters = parameters;
    out.all.visits_uncut = uncut.all.visits;
    for (const auto& [rows, whole] :
         {std::pair{&out.kinds, &uncut.kinds}, std::pair{&out.levels, &uncut.levels}}) {
        for (const TraversalCounts& row : *whole) {
            row_of(*rows, row.name).visits_uncut = row.visits;
        }
    }
    return out;
}

}  // namespace scotty::verify
