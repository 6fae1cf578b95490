/// The figures of `scotty bench emulator` as a table and as JSON.
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include <nlohmann/json.hpp>

#include "verify/bench.h"

namespace scotty::verify {
namespace {

double share(double seconds, double of) { return of > 0.0 ? 100.0 * seconds / of : 0.0; }

std::string rays_row(const BenchRays& kind) {
    return fmt::format("{:<10} {:>12} {:>14.3f} {:>14.3f} {:>9.3f}\n", kind.kind, kind.rays,
                       kind.emulator_rate() * 1e-6, kind.embree_rate() * 1e-6, kind.ratio());
}

std::string part_row(const BenchPart& part, double of) {
    return fmt::format("{:<20} {:>10.2f} {:>6.1f} {:>9} {:>10} {:>12}\n", part.name,
                       part.seconds * 1e3, share(part.seconds, of), part.launches, part.blocks,
                       part.items);
}

nlohmann::json to_json(const BenchRays& kind) {
    return {{"kind", kind.kind},
            {"rays", kind.rays},
            {"emulator_seconds", kind.emulator_seconds},
            {"embree_seconds", kind.embree_seconds},
            {"emulator_rays_per_second", kind.emulator_rate()},
            {"embree_rays_per_second", kind.embree_rate()},
            {"ratio", kind.ratio()}};
}

nlohmann::json to_json(const std::vector<BenchPart>& parts) {
    nlohmann::json out = nlohmann::json::array();
    for (const BenchPart& part : parts) {
        out.push_back({{"name", part.name},
                       {"seconds", part.seconds},
                       {"launches", part.launches},
                       {"blocks", part.blocks},
                       {"items", part.items}});
    }
    return out;
}

}  // namespace

BenchSubject subject_of(const reference::Scene& scene, const BenchSettings& settings) {
    const std::size_t threads =
        settings.threads != 0 ? settings.threads
                              : static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    return {scene.name, scene.triangles.size(), settings.parameters, threads, settings.repeats};
}

std::string heading(const BenchSubject& subject) {
    const auto& p = subject.parameters;
    return fmt::format(
        "{} ({} triangles), {}x{} pixels, {} spp, {} bounces, {} light samples\n"
        "width {}, {} rays a block, queue levels {}, early-out {}, {}, {}, shadow {}; {} threads, "
        "median of {}\n\n",
        subject.scene, subject.triangles, p.image_width, p.image_height, p.spp, p.bounces,
        p.light_samples, p.width, p.rays_per_block,
        p.queue_levels == 0 ? "all" : std::to_string(p.queue_levels), to_string(p.early_out),
        to_string(p.hit_mode), to_string(p.block_order), to_string(p.shadow_query), subject.threads,
        subject.repeats);
}

nlohmann::json subject_json(const BenchSubject& subject) {
    const auto& p = subject.parameters;
    return {{"scene", subject.scene},
            {"triangles", subject.triangles},
            {"image", {{"width", p.image_width}, {"height", p.image_height}}},
            {"spp", p.spp},
            {"bounces", p.bounces},
            {"light_samples", p.light_samples},
            {"seed", p.seed},
            {"width", p.width},
            {"rays_per_block", p.rays_per_block},
            {"queue_levels", p.queue_levels},
            {"early_out", to_string(p.early_out)},
            {"hit_mode", to_string(p.hit_mode)},
            {"block_order", to_string(p.block_order)},
            {"shadow_query", to_string(p.shadow_query)},
            {"threads", subject.threads},
            {"repeats", subject.repeats}};
}

std::string table(const BenchReport& report) {
    std::string out = heading(report);
    out += fmt::format("{:<10} {:>12} {:>14} {:>14} {:>9}\n", "rays", "count", "emulator M/s",
                       "Embree M/s", "ratio");
    for (const BenchRays& kind : report.kinds) out += rays_row(kind);
    out += rays_row(report.all);
    out += fmt::format(
        "\nwhole render: emulator {:.3f} s, Embree in a plain loop {:.3f} s; {:.1f} "
        "MiB in device buffers\n\n",
        report.render_seconds, report.embree_render_seconds,
        static_cast<double>(report.device_bytes) / (1024.0 * 1024.0));
    out += fmt::format("{:<20} {:>10} {:>6} {:>9} {:>10} {:>12}\n", "stage", "ms", "%", "launches",
                       "blocks", "items");
    for (const BenchPart& part : report.stages) out += part_row(part, report.render_seconds);
    out += fmt::format("\n{:<20} {:>10} {:>6} {:>9} {:>10} {:>12}\n", "intersections of", "ms", "%",
                       "launches", "blocks", "entries");
    for (const BenchPart& part : report.levels) out += part_row(part, report.render_seconds);
    return out;
}

nlohmann::json to_json(const BenchReport& report) {
    nlohmann::json kinds = nlohmann::json::array();
    for (const BenchRays& kind : report.kinds) kinds.push_back(to_json(kind));
    nlohmann::json out = subject_json(report);
    out.update({{"ratio_to_embree", report.all.ratio()},
                {"all_rays", to_json(report.all)},
                {"rays", kinds},
                {"render_seconds", report.render_seconds},
                {"embree_render_seconds", report.embree_render_seconds},
                {"device_bytes", report.device_bytes},
                {"stages", to_json(report.stages)},
                {"levels", to_json(report.levels)}});
    return out;
}

}  // namespace scotty::verify
