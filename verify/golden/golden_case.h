/// What golden images and ledgers there are to be: one case a built-in scene.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"

namespace scotty::verify {

struct GoldenCase {
    std::string name;   ///< of its files
    std::string scene;  ///< for scenes::load_scene()
    /// The golden image: size, bounces, and samples and seed of the path tracer that makes it.
    reference::PipelineParameters image;
    /// The pipeline's side of the comparison: as above, with samples and seed of its own.
    reference::PipelineParameters pipeline;
    /// The ledger's run: small, and deterministic stage by stage.
    reference::PipelineParameters ledger;
};

/// All built-in scenes, in their order.
std::vector<GoldenCase> golden_cases();

/// Throws bad_input naming those there are.
const GoldenCase& find_case(const std::vector<GoldenCase>& cases, const std::string& name);

/// No path can bring much more light than the average one: false where mirrors or glass throw a
/// lamp's light on diffuse surfaces, which paths find rarely and then see in full.
bool is_light_tailed(const reference::Scene& scene);

}  // namespace scotty::verify
