#include "verify/bench/bench_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "verify/base/ask.h"

namespace scotty::verify {

namespace {

constexpr std::pair<const char*, double> kLimits[] = {{"emulator", 10.0}, {"simt", 20.0}};

void append(nlohmann::json& to, const nlohmann::json& from) {
    for (const auto& [name, limit] : kLimits) {
        for (const auto& seconds : from.at(name)) to[name].push_back(seconds);
    }
}

Spread spread_in(const nlohmann::json& seconds) {
    return verify::spread_of(seconds.get<std::vector<double>>());
}

}  // namespace

bool CheckBenchReport::passed() const {
    return std::all_of(parts.begin(), parts.end(), [](const auto& part) { return part.within(); });
}

nlohmann::json render_seconds(const reference::Scene& scene, const BenchSettings& settings) {
    const RendersByTurns renders = render_by_turns(scene, settings);
    nlohmann::json seconds;
    for (const TimedRender& render : renders.emulator)
        seconds["emulator"].push_back(render.seconds);
    for (const TimedRender& render : renders.simt) seconds["simt"].push_back(render.seconds);
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
    static_cast<BenchSubject&>(report) = subject_of(scene, settings);
    for (const auto& [name, limit] : kLimits) {
        report.parts.push_back({name, limit, spread_in(plain[name]), spread_in(checked[name])});
    }
    return report;
}

std::string table(const CheckBenchReport& report) {
    std::string out = heading(report) + fmt::format("{:<10} {:>12} {:>12} {:>8} {:>8}\n", "",
                                                    "plain ms", "checked ms", "ratio", "limit");
    for (const CheckBenchPart& part : report.parts) {
        out += fmt::format("{:<10} {:>12.2f} {:>12.2f} {:>8.2f} {:>8.0f}{}\n", part.name,
                           1e3 * part.plain.median, 1e3 * part.checked.median, part.ratio(),
                           part.limit, part.within() ? "" : "  OVER THE LIMIT");
        out += fmt::format("{:<10} plain {}, checked {}\n", "", readable_seconds(part.plain),
                           readable_seconds(part.checked));
    }
    return out;
}

nlohmann::json to_json(const CheckBenchReport& report) {
    nlohmann::json parts = nlohmann::json::array();
    for (const CheckBenchPart& part : report.parts) {
        parts.push_back({{"name", part.name},
                         {"plain_seconds", part.plain.median},
                         {"plain_spread", to_json(part.plain)},
                         {"checked_seconds", part.checked.median},
                         {"checked_spread", to_json(part.checked)},
                         {"ratio", part.ratio()},
                         {"limit", part.limit},
                         {"within", part.within()}});
    }
    nlohmann::json out = subject_json(report);
    out.update({{"passed", report.passed()}, {"tiers", parts}});
    return out;
}

}  // namespace scotty::verify
