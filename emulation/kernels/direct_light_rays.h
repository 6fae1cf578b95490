/// Kernel: one direct-light sample per path vertex: a shadow ray and the radiance it may add.
#pragma once

#include "emulation/kernels/views.h"
#include "reference/stages/path_stages.h"

namespace scotty::emulation {

/// The path's own hit stays as it is; the potential radiance waits in the path state.
inline void direct_light_rays(std::uint32_t ray_id, const reference::SceneView& scene,
                              const reference::PathParameters& parameters, std::uint32_t bounce,
                              std::uint32_t light_sample, const PathView& paths,
                              const reference::Hit* path_hits, reference::Ray* shadow_rays) {
    reference::ask_for_light(scene, parameters, bounce, light_sample, path_hits[ray_id], paths,
                             ray_id, shadow_rays[ray_id]);
}

}  // namespace scotty::emulation
