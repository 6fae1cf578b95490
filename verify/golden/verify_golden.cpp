#include "verify/golden/verify_golden.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>

#include "reference/base/error.h"
#include "verify/golden/golden_judge.h"
#include "verify/images/image_noise.h"

namespace scotty::verify {

namespace {

Failure golden_failure(const std::string& invariant, const std::string& place,
                       const std::string& sentence) {
    Failure failure;
    failure.invariant = invariant;
    failure.stage = place;
    failure.sentence = sentence;
    return failure;
}

std::vector<GoldenCase> cases_of(const GoldenSettings& settings) {
    std::vector<GoldenCase> cases = golden_cases();
    std::erase_if(cases, [&](const GoldenCase& one) {
        return std::find(settings.scenes.begin(), settings.scenes.end(), one.scene) ==
               settings.scenes.end();
    });
    return cases;
}

ImageCase image_case(GoldenVerdict verdict) {
    ImageCase out;
    out.name = verdict.name;
    out.z = pixel_statistics(verdict.found, verdict.golden);
    out.image = std::move(verdict.found);
    out.golden = std::move(verdict.golden);
    out.waived = std::move(verdict.waived);
    if (!verdict.ledger.passed() && !verdict.ledger_waived) {
        out.exact.push_back(
            golden_failure("golden-ledger", verdict.ledger.stage, verdict.ledger.sentence));
    }
    if (!verdict.reconstruction_fault.empty()) {
        out.exact.push_back(golden_failure("golden-reconstruction", "reconstruct_image",
                                           verdict.reconstruction_fault));
    }
    out.verdict = std::move(verdict.image);
    out.replay =
        fmt::format("scotty verify {} --only-golden --backend {}", out.name, verdict.device);
    out.approve = fmt::format(
        "scotty golden propose {0} && scotty golden approve {0} --reason \"...\"", out.name);
    return out;
}

}  // namespace

std::size_t units_of_golden(const GoldenSettings& settings) { return cases_of(settings).size(); }

void verify_golden(const GoldenSettings& settings, const Backend& backend, Report& report) {
    const std::vector<GoldenCase> cases = cases_of(settings);
    if (cases.empty()) return;
    const auto fail = [&](const std::string& invariant, const std::string& place,
                          const std::string& sentence) {
        report.golden_failures.push_back(golden_failure(invariant, place, sentence));
    };
    report.false_alarm = settings.false_alarm;
    const auto ours = [&](std::size_t i) {
        return !settings.has_unit || settings.has_unit(settings.first_unit + i);
    };
    std::size_t reached = 0;
    std::vector<std::string> names;
    names.reserve(cases.size());
    for (const GoldenCase& one : cases) names.push_back(one.name);
    try {
        const std::filesystem::path folder =
            settings.folder.empty() ? find_golden_folder() : std::filesystem::path(settings.folder);
        std::vector<std::string> broken;
        for (const GoldenFinding& found : check_golden(folder, golden_cases(), today())) {
            const bool of_these = found.name.empty() ||
                                  std::find(names.begin(), names.end(), found.name) != names.end();
            if (!of_these) continue;
            fail(fmt::format("golden-{}", to_string(found.problem)), found.name,
                 fmt::format("{}{}{}; {}", found.file, found.file.empty() ? "" : ": ", found.text,
                             found.way_out));
            if (found.problem != GoldenProblem::waiver) broken.push_back(found.name);
        }
        WaiverBook waivers(read_waivers(folder), today());
        const double each = false_alarm_per_image(settings.false_alarm, cases.size());
        bool stopped = settings.stop && settings.stop();
        for (; reached < cases.size(); ++reached) {
            if (!ours(reached)) continue;
            const GoldenCase& one = cases[reached];
            const std::size_t unit = settings.first_unit + reached;
            if (stopped || std::find(broken.begin(), broken.end(), one.name) != broken.end()) {
                report.unjudged_units.push_back(unit);
                continue;
            }
            if (settings.progress) settings.progress(one.name, reached, cases.size());
            report.images.push_back(
                image_case(judge_golden(folder, one, backend, waivers, each, settings.threads)));
            report.images.back().unit = unit;
            stopped = settings.stop && settings.stop();
        }
        if (stopped || settings.has_unit) return;  // no shard knows what the others needed
        for (const Waiver& unused : waivers.unused(names, backend.name)) {
            spdlog::warn("{} covered nothing: it can go from golden/waivers.json",
                         to_string(unused));
        }
    } catch (const reference::Error& error) {
        if (error.kind() == reference::ErrorKind::missing_environment) throw;
        fail("golden", "", error.what());
        for (; reached < cases.size(); ++reached) {
            if (ours(reached)) report.unjudged_units.push_back(settings.first_unit + reached);
        }
    }
}

}  // namespace scotty::verify
