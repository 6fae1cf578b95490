/// A path tracer's sums on disk, so that an interrupted run can go on. Internal to reference/.
#pragma once

#include <filesystem>
#include <string>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/truth/sample_sums.h"

namespace scotty::reference {

/// The file: lines of text that say of what it is, an empty line, the sums and the sums of squares
/// as little-endian doubles, XXH64 of all that.
class PathTracerState {
 public:
    /// An empty path: nothing is read or written.
    PathTracerState(std::filesystem::path file, const Scene& scene,
                    const PipelineParameters& parameters);

    /// What was saved; no samples where there is no such file. Throws bad_input naming the file:
    /// of another scene, other parameters or another version, cut short or damaged.
    SampleSums load() const;
    /// Under a name of its own, then renamed: there is a whole file or the one before.
    void save(const SampleSums& sums) const;

 private:
    std::filesystem::path file_;
    std::string identity_;  ///< the lines, but for the number of samples
    std::uint32_t width_, height_;
};

}  // namespace scotty::reference
