#include "verify/golden/golden_judge.h"

#include <fmt/format.h>

#include <chrono>

#include "scenes/scenes.h"

namespace scotty::verify {

namespace {

/// What failed goes to the waived or to the faults.
void place(const std::string& fault, const Waiver* waiver, GoldenVerdict& verdict) {
    if (waiver == nullptr) {
        verdict.faults.push_back(fault);
    } else {
        verdict.waived.push_back(fmt::format("{} ({})", fault, to_string(*waiver)));
    }
}

}  // namespace

GoldenVerdict judge_golden(const std::filesystem::path& golden, const GoldenCase& golden_case,
                           const Backend& backend, WaiverBook& waivers, double false_alarm,
                           std::size_t threads) {
    const auto start = std::chrono::steady_clock::now();
    const reference::Scene scene = scenes::load_scene(golden_case.scene);
    GoldenTruth truth = read_golden(golden, golden_case, scene);
    GoldenRun run = run_golden(golden_case, scene, backend, threads);

    GoldenVerdict verdict;
    verdict.name = golden_case.name;
    verdict.device = backend.name;
    verdict.ledger = compare_ledgers(truth.ledger, run.ledger);
    if (!verdict.ledger.passed()) {
        const Waiver* waiver =
            waivers.cover_stage(verdict.name, verdict.ledger.stage, verdict.device);
        verdict.ledger_waived = waiver != nullptr;
        place("ledger: " + verdict.ledger.sentence, waiver, verdict);
    }
    verdict.reconstruction_fault = run.image.reconstruction_fault;
    if (!verdict.reconstruction_fault.empty()) {
        verdict.faults.push_back(verdict.reconstruction_fault);
    }
    verdict.image =
        judge_image(run.image.image, truth.image,
                    {.false_alarm = false_alarm, .light_tailed = is_light_tailed(scene)});
    for (GateResult& gate : verdict.image.gates) {
        if (!gate.ran || gate.passed) continue;
        const std::string gate_name(name(gate.gate));
        const Waiver* waiver = waivers.cover_gate(verdict.name, gate_name, verdict.device);
        if (waiver != nullptr) gate.waiver = to_string(*waiver);
        place(fmt::format("image, {} gate: {}", gate_name, gate.text), waiver, verdict);
    }
    verdict.found = std::move(run.image.image);
    verdict.golden = std::move(truth.image);
    verdict.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return verdict;
}

}  // namespace scotty::verify
