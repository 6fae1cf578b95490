#include "verify/bench/bench_gates.h"

#include <fmt/format.h>

#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

namespace scotty::verify {
namespace {

constexpr std::array kGates{Gate::layout, Gate::finite, Gate::global, Gate::tile, Gate::pixel};

struct Experiment {
    std::string title;
    ImageFault fault = ImageFault::none;
    bool fireflies = false;
    bool light_tailed = true;
    bool samples_known = true;  ///< if not, each image's own variance is all there is
};

std::vector<Experiment> experiments() {
    std::vector<Experiment> all;
    for (const ImageFault fault : all_image_faults()) {
        all.push_back({std::string(name(fault)), fault});
    }
    all.push_back({"none, fireflies", ImageFault::none, true, false});
    all.push_back({"none, fireflies, as light-tailed", ImageFault::none, true, true});
    all.push_back({"same, samples not known", ImageFault::none, true, true, false});
    all.push_back({"cosine forgotten, fireflies", ImageFault::cosine_forgotten, true, false});
    return all;
}

void count(const ImageVerdict& verdict, GateBenchRow& row) {
    for (const GateResult& result : verdict.gates) {
        if (result.ran && !result.passed) ++row.rejected[static_cast<std::size_t>(result.gate)];
    }
    if (!verdict.passed()) ++row.rejected_by_any;
}

/// Renders that several experiments share, by what is wrong with the estimator and fireflies.
class Renders {
 public:
    const MeasuredImage& get(SyntheticSettings settings, const Experiment& experiment) {
        settings.fireflies = experiment.fireflies;
        const ImageFault fault =
            happens_while_rendering(experiment.fault) ? experiment.fault : ImageFault::none;
        MeasuredImage& image = images_[{fault, experiment.fireflies}];
        if (image.mean.empty()) image = synthetic_render(settings, fault);
        return image;
    }

 private:
    std::map<std::pair<ImageFault, bool>, MeasuredImage> images_;
};

class Goldens {
 public:
    const MeasuredImage& get(const GateBenchSettings& settings, const Experiment& experiment) {
        SyntheticSettings image = settings.image;
        image.fireflies = experiment.fireflies;
        const bool wrong = experiment.fault == ImageFault::wrong_golden;
        MeasuredImage& golden = images_[{wrong, experiment.fireflies}];
        if (golden.mean.empty()) {
            golden = synthetic_golden(image, settings.golden_factor, experiment.fault);
        }
        return golden;
    }

 private:
    std::map<std::pair<bool, bool>, MeasuredImage> images_;
};

double percent(std::uint32_t part, const GateBenchReport& report) {
    return 100.0 * part / report.settings.trials;
}

}  // namespace

GateBenchReport bench_gates(const GateBenchSettings& settings) {
    const auto start = std::chrono::steady_clock::now();
    GateBenchReport report;
    report.settings = settings;
    const std::vector<Experiment> all = experiments();
    for (const Experiment& experiment : all) {
        report.rows.push_back({experiment.title,
                               experiment.fault == ImageFault::none,
                               experiment.light_tailed,
                               {},
                               0});
    }
    Goldens goldens;
    for (std::uint32_t trial = 0; trial < settings.trials; ++trial) {
        SyntheticSettings image = settings.image;
        image.seed += trial;
        Renders renders;
        for (std::size_t i = 0; i < all.size(); ++i) {
            if (settings.progress) {
                settings.progress(
                    fmt::format("trial {} of {}: {}", trial + 1, settings.trials, all[i].title));
            }
            MeasuredImage render = renders.get(image, all[i]);
            if (!happens_while_rendering(all[i].fault)) plant(render, all[i].fault);
            if (!all[i].samples_known) render.samples = 0;
            count(judge_image(render, goldens.get(settings, all[i]),
                              {settings.false_alarm, all[i].light_tailed}),
                  report.rows[i]);
        }
    }
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report;
}

std::string table(const GateBenchReport& report) {
    const GateBenchSettings& s = report.settings;
    std::string out = fmt::format(
        "synthetic images, {}x{} pixels, {} samples, golden {} samples; {} trials from seed {}, "
        "{:.1f} s\nfalse-alarm probability {:g} for an image; shares of trials that a gate "
        "rejected\n\n{:<34}",
        s.image.width, s.image.height, s.image.samples, s.image.samples * s.golden_factor, s.trials,
        s.image.seed, report.seconds, s.false_alarm, "fault");
    for (const Gate gate : kGates) out += fmt::format("{:>8}", name(gate));
    out += fmt::format("{:>8}  should\n", "any");
    for (const GateBenchRow& row : report.rows) {
        out += fmt::format("{:<34}", row.fault);
        for (std::size_t g = 0; g < kGates.size(); ++g) {
            const bool asked = kGates[g] != Gate::pixel || row.light_tailed;
            out += asked ? fmt::format("{:>6.0f} %", percent(row.rejected[g], report))
                         : fmt::format("{:>8}", "-");
        }
        out += fmt::format("{:>6.0f} %  {}\n", percent(row.rejected_by_any, report),
                           row.should_pass ? "pass" : "fail");
    }
    out += "\n-: not asked, because the image is judged as heavy-tailed\n";
    return out;
}

nlohmann::json to_json(const GateBenchReport& report) {
    const GateBenchSettings& s = report.settings;
    nlohmann::json rows = nlohmann::json::array();
    for (const GateBenchRow& row : report.rows) {
        nlohmann::json rejected;
        for (std::size_t g = 0; g < kGates.size(); ++g) {
            rejected[std::string(name(kGates[g]))] = row.rejected[g];
        }
        rows.push_back({{"fault", row.fault},
                        {"should_pass", row.should_pass},
                        {"light_tailed", row.light_tailed},
                        {"rejected", rejected},
                        {"rejected_by_any", row.rejected_by_any}});
    }
    return {{"image", {{"width", s.image.width}, {"height", s.image.height}}},
            {"samples", s.image.samples},
            {"golden_samples", s.image.samples * s.golden_factor},
            {"trials", s.trials},
            {"seed", s.image.seed},
            {"false_alarm", s.false_alarm},
            {"seconds", report.seconds},
            {"rows", rows}};
}

}  // namespace scotty::verify
