#include "verify/golden/golden_case.h"

#include <fmt/format.h>

#include <algorithm>

#include "reference/base/error.h"
#include "scenes/scenes.h"

namespace scotty::verify {

namespace {

/// 16 of the pipeline's samples a golden one: its noise is then what a verdict depends on.
constexpr std::uint32_t kGoldenSamples = 4096;
constexpr std::uint32_t kPipelineSamples = 256;
constexpr std::uint64_t kGoldenSeed = 20180427;
constexpr std::uint64_t kPipelineSeed = 1;

reference::PipelineParameters image_parameters(std::uint32_t samples, std::uint64_t seed) {
    reference::PipelineParameters p;
    p.image_width = 64;
    p.image_height = 64;
    p.spp = samples;
    p.seed = seed;
    return p;
}

reference::PipelineParameters ledger_parameters() {
    reference::PipelineParameters p;
    p.image_width = 32;
    p.image_height = 24;
    p.spp = 2;
    p.light_samples = 1;
    p.early_out = reference::EarlyOut::level;
    return p;
}

}  // namespace

std::vector<GoldenCase> golden_cases() {
    std::vector<GoldenCase> cases;
    for (const scenes::BuiltIn& scene : scenes::built_in_scenes()) {
        cases.push_back({scene.name, scene.name, image_parameters(kGoldenSamples, kGoldenSeed),
                         image_parameters(kPipelineSamples, kPipelineSeed), ledger_parameters()});
    }
    return cases;
}

const GoldenCase& find_case(const std::vector<GoldenCase>& cases, const std::string& name) {
    std::string names;
    for (const GoldenCase& golden : cases) {
        if (golden.name == name) return golden;
        names += (names.empty() ? "" : ", ") + golden.name;
    }
    throw reference::Error::bad_input(fmt::format("case '{}'", name),
                                      "no such case; there are " + names);
}

bool is_light_tailed(const reference::Scene& scene) {
    return std::none_of(scene.material_of.begin(), scene.material_of.end(), [&](std::uint32_t i) {
        return scene.materials[i].kind != reference::MaterialKind::diffuse;
    });
}

}  // namespace scotty::verify
