#include "verify/bench_simt.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "reference/error.h"
#include "reference/wide_bvh.h"
#include "verify/same_bits.h"
#include "verify/simt/simt_pipeline.h"

namespace scotty::verify {

using reference::Image;
using reference::LaunchRecord;

namespace {

/// Renders of one of the two: how long, and its launches.
struct Timed {
    double seconds = 0.0;
    std::vector<LaunchRecord> launches;
};

template <class Pipeline>
Timed timed_render(Pipeline& pipeline, Image& image) {
    pipeline.clear_launches();
    const auto start = std::chrono::steady_clock::now();
    image = pipeline.render();
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    return {taken.count(), pipeline.launches()};
}

const Timed& middle(std::vector<Timed>& renders) {
    std::sort(renders.begin(), renders.end(),
              [](const Timed& a, const Timed& b) { return a.seconds < b.seconds; });
    return renders[(renders.size() - 1) / 2];
}

void expect_same(const Image& a, const Image& b) {
    if (same_pixels(a, b)) return;
    throw reference::Error::internal(
        "bench simt: the two pictures differ, so that their times say nothing; "
        "scotty verify --backend simt says where");
}

}  // namespace

SimtBenchReport bench_simt(const reference::Scene& scene, const BenchSettings& settings) {
    reference::validate(settings.parameters);
    std::optional<tbb::global_control> limit;
    if (settings.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, settings.threads);
    }
    const reference::WideBvh bvh = build_wide_bvh(
        scene, {settings.parameters.width, settings.parameters.max_leaf_size, settings.threads});
    emulation::Pipeline emulator(scene, bvh, settings.parameters, {settings.threads});
    const auto simt = simt::make_simt_pipeline(scene, bvh, settings.parameters, {settings.threads},
                                               nullptr, {.timings = true});
    std::vector<Timed> ours;
    std::vector<Timed> theirs;
    Image a;
    Image b;
    for (int round = -settings.warm_ups; round < settings.repeats; ++round) {
        if (settings.progress) {
            settings.progress("rendering, round " + std::to_string(round + settings.warm_ups + 1));
        }
        Timed first = timed_render(emulator, a);
        Timed second = timed_render(*simt, b);
        expect_same(a, b);
        if (round < 0) continue;
        ours.push_back(std::move(first));
        theirs.push_back(std::move(second));
    }
    SimtBenchReport report;
    report.scene = scene.name;
    report.triangles = scene.triangles.size();
    report.parameters = settings.parameters;
    report.threads = settings.threads != 0
                         ? settings.threads
                         : static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    report.repeats = settings.repeats;
    report.render = {"whole render", middle(ours).seconds, middle(theirs).seconds};
    std::map<std::string, SimtBenchPart> parts;
    for (const LaunchRecord& launch : middle(ours).launches) {
        parts[to_string(launch.kind)].emulator_seconds += launch.seconds;
    }
    for (const LaunchRecord& launch : middle(theirs).launches) {
        parts[to_string(launch.kind)].simt_seconds += launch.seconds;
    }
    for (auto& [name, part] : parts) {
        part.name = name;
        report.stages.push_back(part);
    }
    std::sort(report.stages.begin(), report.stages.end(),
              [](const auto& x, const auto& y) { return x.simt_seconds > y.simt_seconds; });
    return report;
}

std::string table(const SimtBenchReport& report) {
    const auto& p = report.parameters;
    std::string out = fmt::format(
        "{} ({} triangles), {}x{} pixels, {} spp, width {}, {} rays a block, early-out {}, {}; "
        "{} threads, median of {}\n\n{:<20} {:>12} {:>12} {:>8}\n",
        report.scene, report.triangles, p.image_width, p.image_height, p.spp, p.width,
        p.rays_per_block, to_string(p.early_out), to_string(p.hit_mode), report.threads,
        report.repeats, "", "emulator ms", "simt ms", "ratio");
    const auto row = [&](const SimtBenchPart& part) {
        out += fmt::format("{:<20} {:>12.2f} {:>12.2f} {:>8.2f}\n", part.name,
                           1e3 * part.emulator_seconds, 1e3 * part.simt_seconds, part.ratio());
    };
    for (const SimtBenchPart& part : report.stages) row(part);
    row(report.render);
    return out;
}

nlohmann::json to_json(const SimtBenchReport& report) {
    const auto to_json_part = [](const SimtBenchPart& part) {
        return nlohmann::json{{"name", part.name},
                              {"emulator_seconds", part.emulator_seconds},
                              {"simt_seconds", part.simt_seconds},
                              {"ratio", part.ratio()}};
    };
    const auto& p = report.parameters;
    nlohmann::json stages = nlohmann::json::array();
    for (const SimtBenchPart& part : report.stages) stages.push_back(to_json_part(part));
    return {{"scene", report.scene},
            {"triangles", report.triangles},
            {"image", {{"width", p.image_width}, {"height", p.image_height}}},
            {"spp", p.spp},
            {"width", p.width},
            {"rays_per_block", p.rays_per_block},
            {"early_out", to_string(p.early_out)},
            {"hit_mode", to_string(p.hit_mode)},
            {"threads", report.threads},
            {"repeats", report.repeats},
            {"ratio_to_emulator", report.render.ratio()},
            {"render", to_json_part(report.render)},
            {"stages", stages}};
}

}  // namespace scotty::verify
