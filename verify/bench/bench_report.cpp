/// The figures of `scotty bench emulator`, `cuda` and `embree` as a table and as JSON.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "verify/bench/bench.h"

namespace scotty::verify {

std::string table(const BenchReport& report) {
    const MeasuredRenders& renders = report.renders;
    std::string out = heading(report) + table(report.rays);
    out += fmt::format("\nwhole render: {} {}, Embree in a plain loop {}\n", renders.backend,
                       readable_seconds(renders.seconds), readable_seconds(report.embree_render));
    out += fmt::format("launches of a render: {}{}; {} in device buffers\n",
                       readable_seconds(renders.launch_seconds),
                       renders.backend == "cuda" ? " by device events" : "",
                       readable_bytes(renders.device_bytes));
    return out + table(report.parts) + "\n" + table(report.occupancy);
}

nlohmann::json to_json(const BenchReport& report) {
    const MeasuredRenders& renders = report.renders;
    nlohmann::json out = subject_json(report);
    out.update(to_json(report.rays));
    out.update(to_json(report.parts));
    out.update({{"backend", renders.backend},
                {"render_seconds", renders.seconds.median},
                {"render_spread", to_json(renders.seconds)},
                {"render_repeats", renders.all_seconds},
                {"launches_spread", to_json(renders.launch_seconds)},
                {"embree_render_seconds", report.embree_render.median},
                {"embree_render_spread", to_json(report.embree_render)},
                {"device_bytes", renders.device_bytes},
                {"occupancy", to_json(report.occupancy)}});
    return out;
}

std::string table(const EmbreeBenchReport& report) {
    return heading(report) + table(report.rays) +
           fmt::format("\nwhole render in a plain loop: {}\n", readable_seconds(report.render));
}

nlohmann::json to_json(const EmbreeBenchReport& report) {
    nlohmann::json out = subject_json(report);
    out.update(to_json(report.rays));
    out.update({{"embree_render_seconds", report.render.median},
                {"embree_render_spread", to_json(report.render)}});
    return out;
}

}  // namespace scotty::verify
