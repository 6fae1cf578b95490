/// Kernel: potential radiance becomes radiance if nothing blocks the way from surface to light.
#pragma once

#include "emulation/kernels/views.h"

namespace scotty::emulation {

inline void resolve_light(std::uint32_t ray_id, const reference::Ray* shadow_rays,
                          const reference::Hit* shadow_hits, const PathView& paths) {
    if (!reference::is_dead(shadow_rays[ray_id]) && !reference::is_hit(shadow_hits[ray_id])) {
        paths.radiance[ray_id] += paths.potential[ray_id];
    }
}

}  // namespace scotty::emulation
