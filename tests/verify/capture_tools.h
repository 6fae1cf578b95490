/// Runs, captures of them, and folders that go away: shared by the tests of captures and diffs.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/small_parameters.h"
#include "tests/temporary_folder.h"
#include "tests/verify/stage_copies.h"
#include "verify/capture/capture.h"
#include "verify/capture/capture_writer.h"
#include "verify/capture/pipeline_input.h"

namespace scotty::verify::test {

using tests::slurp;
using tests::spill;
using tests::TemporaryFolder;

/// `text` with the first `from` replaced by `to`.
inline std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

/// Small, but several levels, blocks a node, bounces and lights.
inline reference::PipelineParameters small_parameters() {
    reference::PipelineParameters p = scotty::test::small_picture(13, 11, 2);
    p.width = 4;
    p.rays_per_block = 32;
    p.hit_capacity = 32;
    return p;
}

/// What a run is of. Each tree is built once.
inline PipelineInput spheres_input(const reference::PipelineParameters& p) {
    static const reference::Scene scene = scenes::load_scene("spheres");
    static std::map<std::pair<int, int>, reference::WideBvh> bvhs;
    auto& bvh = bvhs[{p.width, static_cast<int>(p.queue_levels)}];
    if (bvh.width == 0) bvh = build_wide_bvh(scene, bvh_parameters(p, 0));
    return {scene, bvh, p};
}

using Spoil = std::function<void(StageCopies&)>;

/// Renders, lets `spoil` change the stages, and writes them as a capture.
inline Capture make_capture(const std::filesystem::path& directory,
                            const reference::PipelineParameters& p, const Spoil& spoil = {},
                            const emulation::DeviceOptions& device = {},
                            const std::vector<std::string>& patterns = {}) {
    const PipelineInput input = spheres_input(p);
    CaptureWriter writer(directory, header_of("emulator", input.scene, input.bvh, p), patterns);
    write_pipeline_input(writer.input_folder(), input.scene, input.bvh, p);
    if (spoil) {
        StageCopies stages;  // does not follow retries
        emulation::Pipeline(input.scene, input.bvh, p, device, &stages).render();
        spoil(stages);
        stages.show_to(writer);
    } else {
        emulation::Pipeline(input.scene, input.bvh, p, device, &writer).render();
    }
    writer.finish();
    return Capture::open(directory);
}

/// What the call throws.
inline std::string error_of(const std::function<void()>& call) {
    try {
        call();
    } catch (const reference::Error& error) {
        CHECK(error.kind() == reference::ErrorKind::bad_input);
        return error.what();
    }
    return "(no error)";
}

}  // namespace scotty::verify::test
