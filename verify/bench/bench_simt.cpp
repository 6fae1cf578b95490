#include "verify/bench/bench_simt.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "emulation/host/pipeline.h"
#include "reference/base/error.h"
#include "reference/contract/wide_bvh.h"
#include "reference/truth/tracers.h"
#include "verify/backends/simt/simt_pipeline.h"
#include "verify/base/same_bits.h"

namespace scotty::verify {

using reference::Image;
using reference::LaunchRecord;

namespace {

template <class Pipeline>
TimedRender timed_render(Pipeline& pipeline, Image& image) {
    pipeline.clear_launches();
    const auto start = std::chrono::steady_clock::now();
    image = pipeline.render();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    return {taken.count(), pipeline.launches()};
}

Spread spread_of_renders(const std::vector<TimedRender>& renders) {
    std::vector<double> seconds;
    seconds.reserve(renders.size());
    for (const TimedRender& render : renders) seconds.push_back(render.seconds);
    return verify::spread_of(std::move(seconds));
}

const TimedRender& middle(std::vector<TimedRender>& renders) {
    std::sort(renders.begin(), renders.end(),
              [](const TimedRender& a, const TimedRender& b) { return a.seconds < b.seconds; });
    return renders[(renders.size() - 1) / 2];
}

}  // namespace

RendersByTurns render_by_turns(const reference::Scene& scene, const BenchSettings& settings) {
    reference::validate(settings.parameters);
    std::optional<tbb::global_control> limit;
    if (settings.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, settings.threads);
    }
    const reference::WideBvh bvh =
        build_wide_bvh(scene, bvh_parameters(settings.parameters, settings.threads));
    emulation::Pipeline emulator(scene, bvh, settings.parameters, {settings.threads});
    const auto simt = simt::make_simt_pipeline(scene, bvh, settings.parameters, {settings.threads},
                                               nullptr, {.timings = true});
    RendersByTurns out;
    Image a;
    Image b;
    for (int round = -settings.warm_ups; round < settings.repeats; ++round) {
        if (settings.progress) {
            settings.progress("rendering, round " + std::to_string(round + settings.warm_ups + 1));
        }
        TimedRender first = timed_render(emulator, a);
        TimedRender second = timed_render(*simt, b);
        if (!same_pixels(a, b)) {
            throw reference::Error::internal(
                "bench: the pictures of emulator and simt differ, so that their times say nothing; "
                "scotty verify --backend simt says where");
        }
        if (round < 0) continue;
        out.emulator.push_back(std::move(first));
        out.simt.push_back(std::move(second));
    }
    return out;
}

SimtBenchReport bench_simt(const reference::Scene& scene, const BenchSettings& settings) {
    RendersByTurns renders = render_by_turns(scene, settings);
    const TimedRender& ours = middle(renders.emulator);
    const TimedRender& theirs = middle(renders.simt);
    SimtBenchReport report;
    static_cast<BenchSubject&>(report) = subject_of(scene, settings);
    report.render = {"whole render", ours.seconds, theirs.seconds};
    report.emulator = spread_of_renders(renders.emulator);
    report.simt = spread_of_renders(renders.simt);
    std::map<std::string, SimtBenchPart> parts;
    for (const LaunchRecord& launch : ours.launches) {
        parts[to_string(launch.kind)].emulator_seconds += launch.seconds;
    }
    for (const LaunchRecord& launch : theirs.launches) {
        parts[to_string(launch.kind)].simt_seconds += launch.seconds;
    }
    for (auto& [name, part] : parts) {
        part.name = name;
        report.stages.push_back(part);
    }
    std::sort(report.stages.begin(), report.stages.end(),
              [](const auto& x, const auto& y) { return x.simt_seconds > y.simt_seconds; });
    const reference::WideBvh bvh =
        build_wide_bvh(scene, bvh_parameters(settings.parameters, settings.threads));
    report.parts = parts_of(theirs.launches, bvh, settings.parameters);
    report.rays = trace_by_turns(scene, bvh, reference::EmbreeTracer(scene), settings, "simt");
    report.occupancy =
        count_occupancy(scene, bvh, settings.parameters, settings.threads, settings.progress);
    return report;
}

std::string table(const SimtBenchReport& report) {
    std::string out = heading(report) + fmt::format("{:<20} {:>12} {:>12} {:>8}\n", "",
                                                    "emulator ms", "simt ms", "ratio");
    const auto row = [&](const SimtBenchPart& part) {
        out += fmt::format("{:<20} {:>12.2f} {:>12.2f} {:>8.2f}\n", part.name,
                           1e3 * part.emulator_seconds, 1e3 * part.simt_seconds, part.ratio());
    };
    for (const SimtBenchPart& part : report.stages) row(part);
    row(report.render);
    out += fmt::format("\nwhole render: emulator {}, simt {}\n\n",
                       readable_seconds(report.emulator), readable_seconds(report.simt));
    return out + table(report.rays) + table(report.parts) + "\n" + table(report.occupancy);
}

nlohmann::json to_json(const SimtBenchReport& report) {
    const auto to_json_part = [](const SimtBenchPart& part) {
        return nlohmann::json{{"name", part.name},
                              {"emulator_seconds", part.emulator_seconds},
                              {"simt_seconds", part.simt_seconds},
                              {"ratio", part.ratio()}};
    };
    nlohmann::json stages = nlohmann::json::array();
    for (const SimtBenchPart& part : report.stages) stages.push_back(to_json_part(part));
    nlohmann::json out = subject_json(report);
    out.update(to_json(report.rays));
    out.update(to_json(report.parts));
    out.update({{"occupancy", to_json(report.occupancy)},
                {"emulator_render_spread", to_json(report.emulator)},
                {"simt_render_spread", to_json(report.simt)},
                {"ratio_to_emulator", report.render.ratio()},
                {"render", to_json_part(report.render)},
                {"stages", stages}});
    return out;
}

}  // namespace scotty::verify
