/// The cases of a covering array, each against the baseline of its own picture.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <exception>
#include <map>
#include <new>
#include <utility>

#include "reference/base/error.h"
#include "scenes/scenes.h"
#include "verify/sweep/verify.h"

namespace scotty::verify {

namespace {

/// What brute force, Embree and the images have said about all cases together.
void add(SceneReport& sum, const SceneReport& one) {
    sum.hits += one.hits;
    sum.image += one.image;
    sum.oracles_ran = sum.oracles_ran || one.oracles_ran;
    sum.oracle_seconds += one.oracle_seconds;
    sum.triangles = std::max(sum.triangles, one.triangles);
}

/// The baseline's run, the case's and the oracles as one: whatever failed is shown again by the
/// case's command, which runs all three.
ConfigurationReport folded(SceneReport report, const Case& one) {
    ConfigurationReport out = std::move(report.configurations.back());
    out.label = one.label + "; " + out.label;
    std::vector<Failure> failures = std::move(report.bvh_failures);
    const auto append = [&](std::vector<Failure>& more, const char* of) {
        for (Failure& failure : more) {
            failure.sentence += of;
            failures.push_back(std::move(failure));
        }
    };
    if (report.configurations.size() > 1) {
        ConfigurationReport& baseline = report.configurations.front();
        append(baseline.failures, ", in the baseline of this picture");
        out.counts += baseline.counts;
        out.stages += baseline.stages;
        out.rays += baseline.rays;
        out.schedules += baseline.schedules;
        out.seconds += baseline.seconds;
    }
    append(out.failures, "");
    append(report.hits.failures, ", in the baseline of this picture");
    append(report.image.failures, ", in the baseline of this picture");
    out.seconds += report.oracle_seconds;
    out.failures = std::move(failures);
    return out;
}

}  // namespace

SceneReport refused_scene(const std::string& scene, const std::string& why) {
    SceneReport report;
    report.scene = scene;
    report.source = scene;
    Failure failure;
    failure.invariant = "error";
    failure.stage = "scene";
    failure.sentence = why;
    ConfigurationReport& only = report.configurations.emplace_back();
    only.failures.push_back(std::move(failure));
    only.counts.failures = 1;
    return report;
}

SceneReport verify_cases(const std::vector<Case>& cases, const VerifySettings& settings) {
    const auto start = std::chrono::steady_clock::now();
    SceneReport report;
    report.scene = "cases";
    report.source = "cases";
    std::map<std::string, reference::Scene> scenes;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const std::size_t unit = settings.first_unit + i;
        if (settings.has_unit && !settings.has_unit(unit)) continue;
        const Case& one = cases[i];
        if (settings.progress) settings.progress(one.label, i, cases.size());
        VerifySettings alone = settings;
        alone.parameters = one.configuration.parameters;
        alone.only.emplace({one.configuration});
        alone.has_unit = nullptr;
        alone.progress = nullptr;
        if (!report.passed()) alone.on_first_failure = nullptr;  // the first one was announced
        SceneReport found;
        // The cases' own scenes and pictures are valid.
        const auto refuse = [&](const char* why) {
            found = refused_scene("cases", why);
            if (alone.on_first_failure) alone.on_first_failure(placed_failures(found).front());
        };
        try {
            auto scene = scenes.find(one.scene);
            if (scene == scenes.end()) {
                scene = scenes.emplace(one.scene, scenes::load_scene(one.scene)).first;
            }
            found = verify_scene(scene->second, alone);
        } catch (const reference::Error& error) {
            if (error.kind() == reference::ErrorKind::missing_environment) throw;
            refuse(error.what());
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& error) {
            refuse(error.what());
        }
        if (found.left_out != 0 && found.passed()) {  // a signal ended it
            report.left_out = cases.size() - i;
            break;
        }
        add(report, found);
        report.configurations.push_back(folded(std::move(found), one));
        report.configurations.back().unit = unit;
        if (!settings.fail_fast || report.passed()) continue;
        report.left_out = cases.size() - i - 1;
        break;
    }
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report;
}

}  // namespace scotty::verify
