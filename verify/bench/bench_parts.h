/// A render's launches added up: by stage, by kernel, by level, by kind of rays.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "reference/contract/launch_record.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::verify {

/// Time of some of a render's launches.
struct BenchPart {
    std::string name;
    double seconds = 0.0;
    std::uint64_t launches = 0;
    std::uint64_t blocks = 0;  ///< on cuda those started, which may each take several
    std::uint64_t items = 0;   ///< rays, or queue entries; 0 where the host does not know
};

struct BenchParts {
    std::vector<BenchPart> stages;   ///< by stage kind, the slowest first
    std::vector<BenchPart> kernels;  ///< by the function that ran, the slowest first
    std::vector<BenchPart> levels;   ///< the level kernels, from the root
    /// Whole traversals by kind of rays, as they first ran; then "shading", all that is left.
    std::vector<BenchPart> rays;
    /// By stage name, batches and levels added up: "bounce1/light0/intersect". The slowest first.
    std::vector<BenchPart> paths;
    double seconds = 0.0;  ///< all launches
};
/// `bvh` and `parameters` are those of the render.
BenchParts parts_of(const std::vector<reference::LaunchRecord>& launches,
                    const reference::WideBvh& bvh, const reference::PipelineParameters& parameters);

/// The function in emulation/ and gpu/ that a launch runs: of the stage `intersect` it is
/// intersect_subtrees where queues end, of `filter` the filter's own.
std::string kernel_of(const reference::LaunchRecord& launch, const reference::WideBvh& bvh,
                      const reference::PipelineParameters& parameters);

/// Tables by kernel, level, kind of rays and stage, of the last no more than ten rows. Shares are
/// of all launches.
std::string table(const BenchParts& parts);
/// Keys stages, kernels, levels, traversals, stage_paths, kernel_seconds.
nlohmann::json to_json(const BenchParts& parts);

}  // namespace scotty::verify
