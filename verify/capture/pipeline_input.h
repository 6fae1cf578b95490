/// A pipeline's whole input as files: scene, BVH and parameters, with no loader or builder needed.
///
/// This is how a run reaches a machine that has nothing but a GPU driver, and how a capture stays
/// replayable when its scene file is gone.
#pragma once

#include <filesystem>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/wide_bvh.h"
#include "verify/capture/capture_format.h"

namespace scotty::verify {

struct PipelineInput {
    reference::Scene scene;
    reference::WideBvh bvh;
    reference::PipelineParameters parameters;
};

/// Writes input.json and one .npy an array into `directory`, which is made where it is missing.
/// Throws bad_input naming the file that cannot be written.
void write_pipeline_input(const std::filesystem::path& directory, const reference::Scene& scene,
                          const reference::WideBvh& bvh,
                          const reference::PipelineParameters& parameters);

/// Reads what the above has written; `given` may be the directory of a capture too. The same bits:
/// both fingerprints are checked. Throws bad_input naming file and element.
PipelineInput read_pipeline_input(const std::filesystem::path& given);

/// The header of a capture of a run with that input.
CaptureHeader header_of(const std::string& backend, const reference::Scene& scene,
                        const reference::WideBvh& bvh,
                        const reference::PipelineParameters& parameters);

}  // namespace scotty::verify
