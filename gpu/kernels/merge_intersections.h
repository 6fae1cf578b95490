/// Kernel: the closest of a ray's buffered hits becomes its hit; barycentrics are computed here.
#pragma once

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/contract/scene.h"
#include "reference/numerics/intersect_triangle.h"

namespace SCOTTY_DEVICE_NAMESPACE {

SCOTTY_DEVICE reference::HitCandidate closest_candidate(std::uint32_t ray_id, const HitView& hits) {
    reference::HitCandidate best{reference::kInfinity, reference::kNone};
    if (hits.packed_mode != 0) {
        const std::uint64_t packed = hits.packed[ray_id];
        if (packed != kNoPackedHit) {
            best.t = bits_float(static_cast<std::uint32_t>(packed >> 32));
            best.primitive = static_cast<std::uint32_t>(packed);
        }
        return best;
    }
    const std::uint32_t gathered = hits.counts[ray_id];
    const std::uint32_t count = gathered < hits.capacity ? gathered : hits.capacity;
    for (std::uint32_t slot = 0; slot < count; ++slot) {
        const reference::HitCandidate candidate =
            hits.candidates[static_cast<std::size_t>(ray_id) * hits.capacity + slot];
        if (reference::closer(candidate.t, candidate.primitive, best.t, best.primitive)) {
            best = candidate;
        }
    }
    return best;
}

/// Writes the closest candidate's hit, barycentrics included, or none.
SCOTTY_DEVICE void merge_hit(const reference::SceneView& scene, const reference::HitCandidate& best,
                             const reference::Vec3& origin, const reference::Vec3& inverse,
                             const reference::RayShear& shear, reference::Hit& merged) {
    reference::Hit hit = reference::no_hit();
    if (best.primitive != reference::kNone) {
        const std::uint32_t* corner =
            scene.triangles + 3 * static_cast<std::size_t>(best.primitive);
        reference::intersect_triangle_line(origin, inverse, shear, scene.vertices[corner[0]],
                                           scene.vertices[corner[1]], scene.vertices[corner[2]],
                                           hit);
        hit.primitive = best.primitive;
    }
    merged = hit;
}

SCOTTY_KERNEL(merge_intersections)
(std::uint32_t count, reference::SceneView scene, const reference::Ray* rays, HitView hits,
 reference::Hit* merged) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= count) SCOTTY_RETURN;
    const reference::HitCandidate best = closest_candidate(ray_id, hits);
    reference::Ray ray = reference::dead_ray();
    if (best.primitive != reference::kNone) ray = load_record(rays + ray_id);
    merge_hit(scene, best, ray.origin, reference::safe_inverse(ray.direction),
              reference::ray_shear(ray.direction), merged[ray_id]);
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
