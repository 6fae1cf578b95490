/// What the tests of golden verdicts share.
#pragma once

#include "tests/verify/capture_tools.h"
#include "verify/backend.h"

namespace scotty::verify::test {

/// The emulator, but every path's radiance is `factor` times what it should be.
inline Backend with_light_scaled(float factor) {
    Backend backend = backend_named("emulator", 0);
    backend.render = [factor, render = backend.render](const PipelineInput& input,
                                                       reference::StageObserver* observer) {
        StageCopies stages;
        reference::Image image = render(input, &stages);
        StageCopy& last = stages.at("reconstruct_image");
        for (float& value : last.input<float>("radiance")) value *= factor;
        for (float& value : last.output<float>("image")) value *= factor;
        for (reference::Vec3& pixel : image.pixels) pixel *= factor;
        stages.show_to(*observer);
        return image;
    };
    return backend;
}

}  // namespace scotty::verify::test
