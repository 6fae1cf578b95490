/// Parameters of the small pictures that tests render.
#pragma once

#include <cstdint>

#include "reference/contract/pipeline_parameters.h"

namespace scotty::test {

/// What is left out is as a user gets it.
inline reference::PipelineParameters small_picture(std::uint32_t width, std::uint32_t height,
                                                   std::uint32_t spp = 1, std::uint32_t bounces = 1,
                                                   std::uint32_t light_samples = 1) {
    reference::PipelineParameters p;
    p.image_width = width;
    p.image_height = height;
    p.spp = spp;
    p.bounces = bounces;
    p.light_samples = light_samples;
    return p;
}

}  // namespace scotty::test
