#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "reference/base/error.h"
#include "verify/report/report_file.h"

namespace scotty::verify {

using reference::Error;

namespace {

/// What several shards have found, once.
void add_new(std::vector<Failure>& to, const std::vector<Failure>& from) {
    for (const Failure& failure : from) {
        const bool known = std::any_of(to.begin(), to.end(), [&](const Failure& other) {
            return to_string(other) == to_string(failure);
        });
        if (!known) to.push_back(failure);
    }
}

/// A scene of which one shard ran the baseline and any number ran other configurations.
void add_scene(Report& report, const SceneReport& scene) {
    const auto same =
        std::find_if(report.scenes.begin(), report.scenes.end(),
                     [&](const SceneReport& other) { return other.source == scene.source; });
    if (same == report.scenes.end()) {
        report.scenes.push_back(scene);
        return;
    }
    same->configurations.insert(same->configurations.end(), scene.configurations.begin(),
                                scene.configurations.end());
    add_new(same->bvh_failures, scene.bvh_failures);
    if (scene.oracles_ran) {
        same->oracles_ran = true;
        same->hits += scene.hits;
        same->image += scene.image;
        same->oracle_seconds += scene.oracle_seconds;
        same->triangles = std::max(same->triangles, scene.triangles);
    }
    same->seconds += scene.seconds;
}

void sort_units(Report& report) {
    const auto by_unit = [](const auto& a, const auto& b) { return a.unit < b.unit; };
    for (SceneReport& scene : report.scenes) {
        std::sort(scene.configurations.begin(), scene.configurations.end(), by_unit);
    }
    std::sort(report.images.begin(), report.images.end(), by_unit);
    std::sort(report.scenes.begin(), report.scenes.end(),
              [](const SceneReport& a, const SceneReport& b) {
                  const auto first = [](const SceneReport& scene) {
                      return scene.configurations.empty() ? std::size_t{0}
                                                          : scene.configurations.front().unit;
                  };
                  return first(a) < first(b);
              });
}

void check_same_sweep(const std::vector<ReportPart>& parts, const std::vector<std::string>& names) {
    for (std::size_t i = 1; i < parts.size(); ++i) {
        if (parts[i].sweep == parts.front().sweep && parts[i].units == parts.front().units)
            continue;
        throw Error::bad_input(names[i],
                               fmt::format("is of another sweep than {}; all parts must come from "
                                           "the same command, but for --shard and --json",
                                           names.front()));
    }
}

/// Nothing was left out between the shards, and nothing done twice.
void check_units(const Report& report, std::size_t units) {
    std::set<std::size_t> done;
    const auto add = [&](std::size_t unit) {
        if (!done.insert(unit).second) {
            throw Error::bad_input(fmt::format("unit {}", unit), "was run by two shards");
        }
    };
    for (const SceneReport& scene : report.scenes) {
        for (const ConfigurationReport& one : scene.configurations) add(one.unit);
    }
    for (const ImageCase& image : report.images) add(image.unit);
    for (const std::size_t unit : report.unjudged_units) add(unit);
    for (std::size_t unit = 0; unit < units; ++unit) {
        if (done.contains(unit)) continue;
        throw Error::bad_input(fmt::format("unit {} of {}", unit, units), "was run by no shard");
    }
}

}  // namespace

void check_shards(const std::vector<Shard>& shards, const std::vector<std::string>& names) {
    std::vector<std::string> of_shard(shards.front().count);
    for (std::size_t i = 0; i < shards.size(); ++i) {
        if (shards[i].count != of_shard.size()) {
            throw Error::bad_input(
                names[i], fmt::format("is one of {} shards, {} is one of {}", shards[i].count,
                                      names.front(), of_shard.size()));
        }
        std::string& known = of_shard[shards[i].index];
        if (!known.empty()) {
            throw Error::bad_input(names[i],
                                   fmt::format("is shard {}/{}, and so is {}", shards[i].index + 1,
                                               of_shard.size(), known));
        }
        known = names[i];
    }
    for (std::size_t index = 0; index < of_shard.size(); ++index) {
        if (!of_shard[index].empty()) continue;
        throw Error::bad_input(fmt::format("shard {}/{}", index + 1, of_shard.size()),
                               "is missing: no file of it was given");
    }
}

Report join(const std::vector<ReportPart>& parts, const std::vector<std::string>& names) {
    std::vector<Shard> shards;
    shards.reserve(parts.size());
    for (const ReportPart& part : parts) shards.push_back(part.shard);
    check_same_sweep(parts, names);
    check_shards(shards, names);
    Report report = parts.front().report;
    report.scenes.clear();
    report.images.clear();
    report.golden_failures.clear();
    report.unjudged_units.clear();
    report.relaxed_reads.clear();
    report.seconds = 0.0;
    for (const ReportPart& part : parts) {
        for (const SceneReport& scene : part.report.scenes) add_scene(report, scene);
        report.images.insert(report.images.end(), part.report.images.begin(),
                             part.report.images.end());
        add_new(report.golden_failures, part.report.golden_failures);
        report.unjudged_units.insert(report.unjudged_units.end(),
                                     part.report.unjudged_units.begin(),
                                     part.report.unjudged_units.end());
        for (const RelaxedRead& read : part.report.relaxed_reads) {
            const auto same =
                std::find_if(report.relaxed_reads.begin(), report.relaxed_reads.end(),
                             [&](const RelaxedRead& other) { return other.line == read.line; });
            if (same == report.relaxed_reads.end()) {
                report.relaxed_reads.push_back(read);
            } else {
                same->met += read.met;
            }
        }
        report.seconds += part.report.seconds;
    }
    sort_units(report);
    check_units(report, parts.front().units);
    const std::string pattern = parts.front().sweep.value("stage", "");
    if (!pattern.empty() && report.judged_no_stage()) {
        throw Error::bad_input("--stage", "no stage's name matches '" + pattern + "'");
    }
    return report;
}

}  // namespace scotty::verify
