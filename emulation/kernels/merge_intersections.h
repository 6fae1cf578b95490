/// Kernel: the closest of a ray's buffered hits becomes its hit.
///
/// Barycentrics are computed here, once per ray, and not carried through the buffer: the winner is
/// intersected again, which gives the same t bit for bit.
#pragma once

#include <bit>
#include <cstdint>

#include "emulation/kernels/views.h"
#include "reference/contract/scene.h"
#include "reference/numerics/intersect_triangle.h"

namespace scotty::emulation {

/// Lowest (t, primitive) of a ray's gathered hits; primitive kNone if it has none.
inline reference::HitCandidate closest_candidate(std::uint32_t ray_id, const HitView& hits) {
    reference::HitCandidate best{reference::kInfinity, reference::kNone};
    if (hits.mode == reference::HitMode::packed) {
        const std::uint64_t packed = hits.packed[ray_id];
        if (packed == kNoPackedHit) return best;
        return {std::bit_cast<float>(static_cast<std::uint32_t>(packed >> 32)),
                static_cast<std::uint32_t>(packed)};
    }
    const std::uint32_t count =
        hits.counts[ray_id] < hits.capacity ? hits.counts[ray_id] : hits.capacity;
    for (std::uint32_t slot = 0; slot < count; ++slot) {
        const reference::HitCandidate candidate =
            hits.candidates[std::size_t{ray_id} * hits.capacity + slot];
        if (reference::closer(candidate.t, candidate.primitive, best.t, best.primitive)) {
            best = candidate;
        }
    }
    return best;
}

inline void merge_intersections(std::uint32_t ray_id, const reference::SceneView& scene,
                                const reference::Ray* rays, const HitView& hits,
                                reference::Hit* merged) {
    const reference::HitCandidate best = closest_candidate(ray_id, hits);
    reference::Hit hit = reference::no_hit();
    if (best.primitive != reference::kNone) {
        const reference::Ray ray = rays[ray_id];
        const std::uint32_t* corner =
            scene.triangles + 3 * static_cast<std::size_t>(best.primitive);
        reference::intersect_triangle_line(
            ray.origin, reference::safe_inverse(ray.direction), reference::ray_shear(ray.direction),
            scene.vertices[corner[0]], scene.vertices[corner[1]], scene.vertices[corner[2]], hit);
        hit.primitive = best.primitive;
    }
    merged[ray_id] = hit;
}

}  // namespace scotty::emulation
