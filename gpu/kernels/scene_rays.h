/// Kernel: adds the emission that a path has met and sends it on by its material's BSDF.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/stages/path_stages.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_KERNEL(scene_rays)
(std::uint32_t count, reference::SceneView scene, reference::PathParameters parameters,
 std::uint32_t bounce, const reference::Hit* path_hits, PathView paths) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= count) SCOTTY_RETURN;
    reference::advance_path(scene, parameters, bounce, path_hits[ray_id], paths, ray_id);
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
