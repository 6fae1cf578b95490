#include "verify/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "verify/base/json_number.h"
#include "verify/report/failure_groups.h"

namespace scotty::verify {

StageCounts& StageCounts::operator+=(const StageCounts& other) {
    identical += other.identical;
    reordered += other.reordered;
    within_bounds += other.within_bounds;
    differ += other.differ;
    return *this;
}

std::uint64_t SceneReport::rays() const {
    std::uint64_t sum = 0;
    for (const ConfigurationReport& configuration : configurations) sum += configuration.rays;
    return sum;
}

bool SceneReport::passed() const {
    return bvh_failures.empty() && hits.failures.empty() && hits.ours_wrong == 0 &&
           image.failures.empty() &&
           std::all_of(configurations.begin(), configurations.end(),
                       [](const ConfigurationReport& c) { return c.failures.empty(); });
}

bool Report::passed() const {
    return stopped.empty() && golden_failures.empty() && (!mutants || mutants->passed()) &&
           std::all_of(scenes.begin(), scenes.end(),
                       [](const SceneReport& scene) { return scene.passed(); }) &&
           std::all_of(images.begin(), images.end(),
                       [](const ImageCase& image) { return image.passed(); });
}

bool Report::judged_no_stage() const {
    return std::all_of(scenes.begin(), scenes.end(), [](const SceneReport& scene) {
        return std::all_of(scene.configurations.begin(), scene.configurations.end(),
                           [](const auto& one) { return one.counts.stages == 0; });
    });
}

std::vector<PlacedFailure> placed_failures(const SceneReport& scene) {
    std::vector<PlacedFailure> placed;
    const std::string baseline =
        scene.configurations.empty() ? "" : scene.configurations.front().replay;
    const auto add = [&](const std::string& configuration, const std::string& replay,
                         const std::vector<Failure>& failures) {
        for (const Failure& failure : failures) {
            const bool of_stage = failure.launch != reference::kNotApplicable;
            placed.push_back(
                {scene.scene, configuration, failure,
                 of_stage ? fmt::format("{} --stage '{}'", replay, failure.stage) : replay, ""});
        }
    };
    add("BVH", baseline, scene.bvh_failures);
    for (const ConfigurationReport& configuration : scene.configurations) {
        add(configuration.label, configuration.replay, configuration.failures);
    }
    add("oracles on the baseline", baseline, scene.hits.failures);
    add("oracles on the baseline", baseline, scene.image.failures);
    return placed;
}

std::vector<PlacedFailure> placed_failures(const Report& report) {
    std::vector<PlacedFailure> placed;
    for (const SceneReport& scene : report.scenes) {
        for (PlacedFailure& failure : placed_failures(scene)) placed.push_back(std::move(failure));
    }
    for (const Failure& failure : report.golden_failures) {
        placed.push_back({failure.stage, "golden files", failure, "scotty golden check", ""});
    }
    for (const ImageCase& image : report.images) {
        for (const Failure& failure : failures_of(image)) {
            placed.push_back({image.name, "golden image", failure, image.replay, image.approve});
        }
    }
    if (!report.mutants) return placed;
    for (const MutantResult& result : report.mutants->faults) {
        if (result.caught()) continue;
        Failure failure;
        failure.invariant = "planted-fault";
        failure.stage = result.found.stage;
        failure.sentence = result.why_not;
        placed.push_back({result.fault.name, result.fault.file, failure,
                          "scotty mutants " + result.fault.name, ""});
    }
    for (const HostileResult& result : report.mutants->hostile) {
        if (result.failure.empty()) continue;
        Failure failure;
        failure.invariant = "hostile-condition";
        failure.sentence = result.failure;
        placed.push_back({result.condition.name, result.condition.what, failure,
                          "scotty mutants " + result.condition.name, ""});
    }
    return placed;
}

namespace {

bool statistical(Gate gate) {
    return gate == Gate::global || gate == Gate::tile || gate == Gate::pixel;
}

/// The first gate that failed, else the one that came nearest to it.
const GateResult* leading_gate(const ImageVerdict& verdict) {
    if (const GateResult* failed = verdict.first_failure()) return failed;
    const GateResult* leading = nullptr;
    for (const GateResult& gate : verdict.gates) {
        if (!gate.ran || !statistical(gate.gate)) continue;
        if (leading == nullptr ||
            gate.p_value / gate.threshold < leading->p_value / leading->threshold) {
            leading = &gate;
        }
    }
    return leading;
}

/// A name that does not fit is cut, and says so.
std::string cut(const std::string& text, std::size_t columns) {
    return text.size() <= columns ? text : text.substr(0, columns - 1) + "~";
}

/// "all", or a percentage that is 100 % for nothing less than all.
std::string share(bool measured, std::uint64_t part, std::uint64_t whole) {
    if (!measured) return "-";
    if (part == whole) return "all";
    return fmt::format("{:.0f} %",
                       std::floor(100.0 * static_cast<double>(part) / static_cast<double>(whole)));
}

std::string image_table(const std::vector<ImageCase>& images) {
    if (images.empty()) return "";
    const auto row = [](const auto&... cells) {
        return fmt::format("{:<14} {:>7} {:>9} {:>8} {:>8} {:>8} {:>8}  {}\n", cells...);
    };
    std::string out =
        "\n" + row("golden image", "gate", "statistic", "p", "below", "FLIP", "relMSE", "verdict");
    for (const ImageCase& image : images) {
        const GateResult* gate = leading_gate(image.verdict);
        const auto in_short = [](double value) { return fmt::format("{:.2g}", value); };
        const auto of_gate = [&](double GateResult::*member) {
            const bool measured = gate != nullptr && statistical(gate->gate);
            return measured ? in_short(gate->*member) : std::string("-");
        };
        out += row(cut(image.name, 14), gate == nullptr ? "-" : name(gate->gate),
                   of_gate(&GateResult::statistic), of_gate(&GateResult::p_value),
                   of_gate(&GateResult::threshold), in_short(image.verdict.metrics.flip),
                   in_short(image.verdict.metrics.rel_mse), image.passed() ? "passed" : "FAILED");
        for (const std::string& waived : image.waived) {
            out += fmt::format("  {}: let pass: {}\n", image.name, waived);
        }
    }
    return out;
}

}  // namespace

namespace {

/// What was judged may have passed where not all was.
const char* verdict_word(const Report& report) {
    if (report.passed()) return "passed";
    return placed_failures(report).empty() ? "STOPPED" : "FAILED";
}

/// A line each, of what was asked for.
std::string schedules_and_checks(const Report& report) {
    std::string out;
    std::size_t schedules = 0;
    for (const SceneReport& scene : report.scenes) {
        for (const ConfigurationReport& c : scene.configurations) schedules += c.schedules;
    }
    if (schedules != 0) out += fmt::format("{} runs under other schedules\n", schedules);
    if (!report.checked) return out;
    std::uint64_t met = 0;
    std::string lines;
    for (const RelaxedRead& read : report.relaxed_reads) {
        met += read.met;
        lines += fmt::format("{}{} at {}", lines.empty() ? ": " : ", ", read.met, read.line);
    }
    return out + fmt::format("checked; relaxed reads that met an atomic of their launch: {}{}\n",
                             met, lines);
}

}  // namespace

std::string table(const Report& report) {
    const auto row = [](const auto&... cells) {
        return fmt::format("{:<12} {:>9} {:>4} {:>9} {:>5} {:>7} {:>5} {:>6} {:>7} {}\n", cells...);
    };
    std::string out = row("scene", "triangles", "runs", "rays", "brute", "Embree", "E.bad",
                          "pixels", "seconds", "verdict");
    std::uint64_t rays = 0;
    std::size_t configurations = 0;
    StageCounts stages;
    for (const SceneReport& scene : report.scenes) {
        const HitCheckResult& hits = scene.hits;
        out += row(cut(scene.scene, 12), scene.triangles, scene.configurations.size(), scene.rays(),
                   share(scene.oracles_ran, hits.brute_force_rays, hits.rays),
                   hits.embree_rays + hits.occlusion_rays, hits.embree_wrong,
                   share(scene.oracles_ran, scene.image.identical, scene.image.pixels),
                   fmt::format("{:.1f}", scene.seconds), scene.passed() ? "passed" : "FAILED");
        rays += scene.rays();
        configurations += scene.configurations.size();
        for (const ConfigurationReport& c : scene.configurations) stages += c.stages;
    }
    out += image_table(report.images);
    const std::string images =
        report.images.empty() ? "" : fmt::format(", {} golden images", report.images.size());
    out += fmt::format("\n{} scenes, {} runs, {} rays{}, {} threads, {:.1f} s: {}\n",
                       report.scenes.size(), configurations, rays, images, report.threads,
                       report.seconds, verdict_word(report));
    if (!report.stopped.empty()) out += fmt::format("not all was judged: {}\n", report.stopped);
    if (stages.all() != 0) {
        out += fmt::format(
            "{} against the emulator: {} stages, {} identical, {} reordered, {} within bounds, {} "
            "differ\n",
            report.backend, stages.all(), stages.identical, stages.reordered, stages.within_bounds,
            stages.differ);
    }
    if (report.coverage) out += to_text(*report.coverage) + "\n";
    out += schedules_and_checks(report);
    if (report.mutants) out += score(*report.mutants);
    const auto failures = placed_failures(report);
    if (failures.empty()) return out;
    out += "\nfirst failure: " + to_text(failures.front());
    out += to_text(failure_groups(failures));
    return out;
}

namespace {

nlohmann::json to_json(const PlacedFailure& placed) {
    const Failure& f = placed.failure;
    return {{"scene", placed.scene},
            {"configuration", placed.configuration},
            {"invariant", f.invariant},
            {"stage", f.stage},
            {"launch", json_id(f.launch)},
            {"level", json_id(f.level)},
            {"node", json_id(f.node)},
            {"block", json_id(f.block)},
            {"thread", json_id(f.thread)},
            {"ray", json_id(f.ray)},
            {"field", f.field},
            {"expected", f.expected},
            {"found", f.found},
            {"sentence", f.sentence},
            {"written_by", f.written_by},
            {"replay", placed.replay},
            {"approve", placed.approve}};
}

nlohmann::json to_json(const FailureGroup& group) {
    return {{"invariant", group.invariant},           {"stage", group.stage},
            {"count", group.members.size()},          {"first", group.members.front()},
            {"configurations", group.configurations}, {"scenes", group.scenes}};
}

nlohmann::json to_json(const ConfigurationReport& c) {
    return {{"configuration", c.label},
            {"passed", c.failures.empty()},
            {"failures", c.counts.failures},
            {"stages", c.counts.stages},
            {"against_emulator",
             {{"identical", c.stages.identical},
              {"reordered", c.stages.reordered},
              {"within_bounds", c.stages.within_bounds},
              {"differ", c.stages.differ}}},
            {"rays", c.rays},
            {"entries", c.counts.entries},
            {"pushes", c.counts.pushes},
            {"missed", c.counts.missed},
            {"culled", c.counts.culled},
            {"leaf_hits", c.counts.leaf_hits},
            {"retries", c.counts.retries},
            {"non_finite", c.counts.non_finite},
            {"seconds", c.seconds},
            {"schedules", c.schedules},
            {"replay", c.replay}};
}

nlohmann::json to_json(const SceneReport& scene) {
    nlohmann::json configurations = nlohmann::json::array();
    for (const ConfigurationReport& c : scene.configurations) configurations.push_back(to_json(c));
    return {{"scene", scene.scene},
            {"source", scene.source},
            {"passed", scene.passed()},
            {"triangles", scene.triangles},
            {"warnings", scene.warnings},
            {"rays", scene.rays()},
            {"oracles_ran", scene.oracles_ran},
            {"hits",
             {{"rays", scene.hits.rays},
              {"brute_force_rays", scene.hits.brute_force_rays},
              {"embree_rays", scene.hits.embree_rays},
              {"occlusion_rays", scene.hits.occlusion_rays},
              {"ties", scene.hits.ties},
              {"grazing", scene.hits.grazing},
              {"embree_wrong", scene.hits.embree_wrong},
              {"ours_wrong", scene.hits.ours_wrong}}},
            {"image",
             {{"pixels", scene.image.pixels},
              {"identical", scene.image.identical},
              {"excused", scene.image.excused}}},
            {"oracle_seconds", scene.oracle_seconds},
            {"seconds", scene.seconds},
            {"configurations", configurations}};
}

}  // namespace

nlohmann::json to_json(const Report& report) {
    nlohmann::json scenes = nlohmann::json::array();
    for (const SceneReport& scene : report.scenes) scenes.push_back(to_json(scene));
    nlohmann::json failures = nlohmann::json::array();
    const auto placed = placed_failures(report);
    for (const PlacedFailure& failure : placed) failures.push_back(to_json(failure));
    nlohmann::json groups = nlohmann::json::array();
    for (const FailureGroup& group : failure_groups(placed)) groups.push_back(to_json(group));
    nlohmann::json images = nlohmann::json::array();
    for (const ImageCase& image : report.images) images.push_back(to_json(image));
    nlohmann::json relaxed = nlohmann::json::array();
    for (const RelaxedRead& read : report.relaxed_reads) {
        relaxed.push_back({{"line", read.line}, {"met", read.met}});
    }
    const auto& p = report.parameters;
    return {{"passed", report.passed()},
            {"mutants", report.mutants ? to_json(*report.mutants) : nlohmann::json(nullptr)},
            {"command", report.command},
            {"threads", report.threads},
            {"backend", report.backend},
            {"image", {{"width", p.image_width}, {"height", p.image_height}}},
            {"spp", p.spp},
            {"bounces", p.bounces},
            {"light_samples", p.light_samples},
            {"seed", p.seed},
            {"seconds", report.seconds},
            {"failures", failures},
            {"failure_groups", groups},
            {"stopped", report.stopped},
            {"scenes", scenes},
            {"coverage", report.coverage ? to_json(*report.coverage) : nlohmann::json(nullptr)},
            {"checked", report.checked},
            {"relaxed_reads", relaxed},
            {"false_alarm", report.false_alarm},
            {"images", images}};
}

}  // namespace scotty::verify
