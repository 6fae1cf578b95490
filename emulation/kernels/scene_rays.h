/// Kernel: adds the emission that a path has met and sends it on by its material's BSDF.
#pragma once

#include "emulation/kernels/views.h"
#include "reference/stages/path_stages.h"

namespace scotty::emulation {

inline void scene_rays(std::uint32_t ray_id, const reference::SceneView& scene,
                       const reference::PathParameters& parameters, std::uint32_t bounce,
                       const reference::Hit* path_hits, const PathView& paths) {
    reference::advance_path(scene, parameters, bounce, path_hits[ray_id], paths, ray_id);
}

}  // namespace scotty::emulation
