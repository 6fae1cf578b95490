/// A run of the emulator on the spheres: its stages, to be spoiled, and a checker to show them to.
#pragma once

#include <vector>

#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "scenes/scenes.h"
#include "tests/verify/stage_copies.h"
#include "verify/invariants/invariants.h"

namespace scotty::verify::test {

inline const reference::Scene& spheres() {
    static const reference::Scene scene = scenes::load_scene("spheres");
    return scene;
}

struct SpheresRun {
    explicit SpheresRun(const reference::PipelineParameters& p)
        : parameters(p), bvh(build_wide_bvh(spheres(), bvh_parameters(p, 0))) {
        emulation::Pipeline(spheres(), bvh, parameters, {}, &stages).render();
    }

    std::vector<Failure> check(const InvariantSettings& settings = {}) const {
        InvariantChecker checker(spheres(), bvh, parameters, settings);
        stages.show_to(checker);
        return checker.failures();
    }

    std::uint32_t first_node(std::uint32_t level) const { return bvh.level_begins[level]; }

    reference::PipelineParameters parameters;
    reference::WideBvh bvh;
    StageCopies stages;
};

}  // namespace scotty::verify::test
