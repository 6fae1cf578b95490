/// An independent path tracer: the truth that the pipeline's pictures are held against.
///
/// Embree finds the hits; sampling, shading, random numbers and sums are its own, in double
/// precision. What it shares with the pipelines is data (scene, parameters) and, where several
/// triangles lie exactly on each other, the contract's rule on which of them is seen.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/truth/sample_sums.h"

namespace scotty::reference {

/// Rises with every change that changes the numbers it finds: images of another version are stale.
constexpr int kPathTracerVersion = 1;

struct PathTracerOptions {
    std::size_t threads = 0;  ///< 0: all. The result does not depend on it.
    /// Where a run that is cut short can go on: read at the start where it exists, written every
    /// `samples_a_round` samples. Empty: nothing is kept.
    std::filesystem::path state;
    std::uint32_t samples_a_round = 64;  ///< at least 1
    /// After each round: samples per pixel that are done, and in all. May throw to end the run.
    std::function<void(std::uint64_t done, std::uint64_t total)> progress;
};

/// Converges to what a pipeline's picture with the same image size, bounces, and light samples (any
/// number but 0 stands for all others) converges to; spp and seed are its own. Filters are not
/// applied. The same sums bit for bit whatever threads, rounds and interruptions.
/// Throws bad_input where the parameters are wrong, or the state is of another run or damaged.
SampleSums trace_paths(const Scene& scene, const PipelineParameters& parameters,
                       const PathTracerOptions& options = {});

}  // namespace scotty::reference
