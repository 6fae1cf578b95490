#include "verify/report/report_file.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "reference/base/error.h"
#include "verify/capture/capture_format.h"

namespace scotty::verify {

namespace fs = std::filesystem;
using nlohmann::json;
using reference::Error;

// By their names; every one has to be there. nlohmann-json finds these functions beside the types.
// HitCheckResult::excused is left: only the run that found it needs it.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Failure, invariant, stage, launch, level, node, block, thread,
                                   ray, field, expected, found, sentence, written_by)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(StageCounts, identical, reordered, within_bounds, differ)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(InvariantCounts, stages, entries, pushes, missed, culled,
                                   leaf_hits, non_finite, failures, retries)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ConfigurationReport, label, unit, stages, counts, rays,
                                   schedules, seconds, failures, replay)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(HitCheckResult, traversals, rays, brute_force_rays, embree_rays,
                                   occlusion_rays, ties, grazing, embree_wrong, ours_wrong,
                                   failures)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ImageCheckResult, pixels, identical, excused, failures)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SceneReport, scene, source, triangles, warnings, configurations,
                                   bvh_failures, oracles_ran, hits, image, oracle_seconds, seconds)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(MeasuredImage, width, height, mean, variance, samples,
                                   paths_per_sample)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(GateResult, gate, ran, passed, statistic, p_value, threshold, x,
                                   y, width, height, channel, text, waiver)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ImageMetrics, flip, rel_mse, psnr, max_ulps)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(WorstPixel, x, y, z, ulps, image, golden)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ImageVerdict, gates, metrics, worst)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ImageCase, name, unit, image, golden, verdict, exact, waived, z,
                                   replay, approve)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(RelaxedRead, line, met)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CoverageFactor, name, values)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Coverage, cases, pairs, all_pairs, triples, all_triples, hashes,
                                   factors)

namespace {

constexpr const char* kPartFormat = "cuda-scotty-report-part";
constexpr int kPartVersion = 1;
/// JSON has no word for numbers that are not finite; these stand in, and are nobody's text.
constexpr const char* kNaN = "\x01NaN";
constexpr const char* kInfinity = "\x01Infinity";
constexpr const char* kMinusInfinity = "\x01-Infinity";

void name_numbers(json& value) {
    if (value.is_structured()) {
        for (json& inner : value) name_numbers(inner);
    } else if (value.is_number_float() && !std::isfinite(value.get<double>())) {
        const double number = value.get<double>();
        value = std::isnan(number) ? kNaN : number > 0.0 ? kInfinity : kMinusInfinity;
    }
}

void read_named_numbers(json& value) {
    if (value.is_structured()) {
        for (json& inner : value) read_named_numbers(inner);
    } else if (value.is_string()) {
        constexpr double kInf = std::numeric_limits<double>::infinity();
        if (value == kNaN) value = std::numeric_limits<double>::quiet_NaN();
        if (value == kInfinity) value = kInf;
        if (value == kMinusInfinity) value = -kInf;
    }
}

}  // namespace

json part_json(const ReportPart& part) {
    const Report& report = part.report;
    json out = {{"format", kPartFormat},
                {"version", kPartVersion},
                {"shard", {part.shard.index + 1, part.shard.count}},
                {"units", part.units},
                {"sweep", part.sweep},
                {"parameters", to_json(report.parameters)},
                {"threads", report.threads},
                {"backend", report.backend},
                {"command", report.command},
                {"scenes", report.scenes},
                {"images", report.images},
                {"golden_failures", report.golden_failures},
                {"unjudged_units", report.unjudged_units},
                {"checked", report.checked},
                {"relaxed_reads", report.relaxed_reads},
                {"false_alarm", report.false_alarm},
                {"seconds", report.seconds}};
    if (report.coverage) out["coverage"] = *report.coverage;
    name_numbers(out);
    return out;
}

bool is_part(const json& object) {
    return object.is_object() && object.contains("format") && object["format"] == kPartFormat;
}

ReportPart read_part(const fs::path& path, json object) {
    expect_format(path, object, kPartFormat, kPartVersion);
    read_named_numbers(object);
    try {
        ReportPart part;
        const auto shard = object.at("shard").get<std::pair<std::size_t, std::size_t>>();
        if (shard.first < 1 || shard.first > shard.second) {
            throw Error::bad_input(path.string(), "'shard': expected I of N");
        }
        part.shard = {shard.first - 1, shard.second};
        part.units = object.at("units");
        part.sweep = object.at("sweep");
        Report& report = part.report;
        report.parameters = parse_parameters(path.string(), object.at("parameters"));
        report.threads = object.at("threads");
        report.backend = object.at("backend");
        report.command = object.at("command");
        report.scenes = object.at("scenes").get<std::vector<SceneReport>>();
        if (object.contains("coverage")) report.coverage = object["coverage"].get<Coverage>();
        report.images = object.at("images").get<std::vector<ImageCase>>();
        report.golden_failures = object.at("golden_failures").get<std::vector<Failure>>();
        report.unjudged_units = object.at("unjudged_units").get<std::vector<std::size_t>>();
        report.checked = object.at("checked");
        report.relaxed_reads = object.at("relaxed_reads").get<std::vector<RelaxedRead>>();
        report.false_alarm = object.at("false_alarm");
        report.seconds = object.at("seconds");
        return part;
    } catch (const json::exception& error) {
        throw Error::bad_input(path.string(), error.what());
    }
}

}  // namespace scotty::verify
