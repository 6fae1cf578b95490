#include "verify/bench_check.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "emulation/pipeline.h"
#include "reference/error.h"
#include "reference/wide_bvh.h"
#include "verify/same_bits.h"
#include "verify/simt/simt_pipeline.h"

namespace scotty::verify {

namespace {

constexpr std::pair<const char*, double> kLimits[] = {{"emulator", 10.0}, {"simt", 20.0}};

template <class Pipeline>
double timed(Pipeline& pipeline, reference::Image& image) {
    const auto start = std::chrono::steady_clock::now();
    image = pipeline.render();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), ::pclose);
    std::string text;
    if (pipe == nullptr) return text;
    char piece[4096];
    while (const std::size_t got = std::fread(piece, 1, sizeof piece, pipe.get())) {
        text.append(piece, got);
    }
    return text;
}

void append(nlohmann::json& to, const nlohmann::json& from) {
    for (const auto& [name, limit] : kLimits) {
        for (const auto& seconds : from.at(name)) to[name].push_back(seconds);
    }
}

double middle(const nlohmann::json& seconds) { return median(seconds.get<std::vector<double>>()); }

}  // namespace

bool CheckBenchReport::passed() const {
    return std::all_of(parts.begin(), parts.end(), [](const auto& part) { return part.within(); });
}

nlohmann::json render_seconds(const reference::Scene& scene, const BenchSettings& settings) {
    reference::validate(settings.parameters);
    std::optional<tbb::global_control> limit;
    if (settings.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, settings.threads);
    }
    const auto& p = settings.parameters;
    const reference::WideBvh bvh =
        build_wide_bvh(scene, {p.width, p.max_leaf_size, settings.threads});
    emulation::Pipeline emulator(scene, bvh, p, {settings.threads});
    const auto simt = simt::make_simt_pipeline(scene, bvh, p, {settings.threads});
    nlohmann::json seconds{{"emulator", nlohmann::json::array()},
                           {"simt", nlohmann::json::array()}};
    reference::Image a;
    reference::Image b;
    for (int round = -settings.warm_ups; round < settings.repeats; ++round) {
        const double first = timed(emulator, a);
        const double second = timed(*simt, b);
        if (!same_pixels(a, b)) {
            throw reference::Error::internal(
                "bench check: the pictures of emulator and simt differ; "
                "scotty verify --backend simt says where");
        }
        if (round < 0) continue;
        seconds["emulator"].push_back(first);
        seconds["simt"].push_back(second);
    }
    return seconds;
}

CheckBenchReport bench_check(const reference::Scene& scene, const BenchSettings& settings,
                             const std::string& command) {
    BenchSettings once = settings;
    once.repeats = 1;
    once.warm_ups = 1;
    nlohmann::json plain;
    nlohmann::json checked;
    for (int round = 0; round < settings.repeats; ++round) {
        if (settings.progress) settings.progress("round " + std::to_string(round + 1));
        append(plain, render_seconds(scene, once));
        const std::string said = output_of(command);
        const auto parsed = nlohmann::json::parse(said, nullptr, false);
        if (!parsed.is_object()) {
            throw reference::Error::missing_environment(
                "bench check: no figures from " + command +
                "; scotty-checked is built beside scotty, but not by a sanitizer preset");
        }
        append(checked, parsed);
    }
    CheckBenchReport report;
    report.scene = scene.name;
    report.triangles = scene.triangles.size();
    report.parameters = settings.parameters;
    report.threads = settings.threads != 0
                         ? settings.threads
                         : static_cast<std::size_t>(tbb::this_task_arena::max_concurrency());
    report.repeats = settings.repeats;
    for (const auto& [name, limit] : kLimits) {
        report.parts.push_back({name, limit, middle(plain[name]), middle(checked[name])});
    }
    return report;
}

std::string table(const CheckBenchReport& report) {
    const auto& p = report.parameters;
    std::string out = fmt::format(
        "{} ({} triangles), {}x{} pixels, {} spp, width {}, {} rays a block, early-out {}, {}; "
        "{} threads, median of {}\n\n{:<10} {:>12} {:>12} {:>8} {:>8}\n",
        report.scene, report.triangles, p.image_width, p.image_height, p.spp, p.width,
        p.rays_per_block, to_string(p.early_out), to_string(p.hit_mode), report.threads,
        report.repeats, "", "plain ms", "checked ms", "ratio", "limit");
    for (const CheckBenchPart& part : report.parts) {
        out += fmt::format("{:<10} {:>12.2f} {:>12.2f} {:>8.2f} {:>8.0f}{}\n", part.name,
                           1e3 * part.plain, 1e3 * part.checked, part.ratio(), part.limit,
                           part.within() ? "" : "  OVER THE LIMIT");
    }
    return out;
}

nlohmann::json to_json(const CheckBenchReport& report) {
    const auto& p = report.parameters;
    nlohmann::json parts = nlohmann::json::array();
    for (const CheckBenchPart& part : report.parts) {
        parts.push_back({{"name", part.name},
                         {"plain_seconds", part.plain},
                         {"checked_seconds", part.checked},
                         {"ratio", part.ratio()},
                         {"limit", part.limit},
                         {"within", part.within()}});
    }
    return {{"passed", report.passed()},
            {"scene", report.scene},
            {"triangles", report.triangles},
            {"image", {{"width", p.image_width}, {"height", p.image_height}}},
            {"spp", p.spp},
            {"width", p.width},
            {"rays_per_block", p.rays_per_block},
            {"early_out", to_string(p.early_out)},
            {"hit_mode", to_string(p.hit_mode)},
            {"threads", report.threads},
            {"repeats", report.repeats},
            {"tiers", parts}};
}

}  // namespace scotty::verify
