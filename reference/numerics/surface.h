/// A hit turned into a point that can be shaded, and rays that leave it without hitting it again.
#pragma once

#include "reference/base/host_device.h"
#include "reference/base/vec3.h"
#include "reference/contract/records.h"
#include "reference/contract/scene.h"

namespace scotty::reference {

struct Surface {
    Vec3 position;
    Vec3 geometric_normal;  ///< unit, faces the viewer
    Vec3 shading_normal;    ///< unit, on the viewer's side of the surface
    bool front;             ///< the viewer sees the side that the winding calls the outside
    float offset;           ///< how far a ray must start off the surface, metres
    std::uint32_t material;
};

/// Relative start distance of rays that leave a surface, 2^-16 of the triangle's coordinates: some
/// hundred roundings, relative to the scene's own scale (no absolute epsilon).
constexpr float kSurfaceOffset = 1.52587890625e-5f;

SCOTTY_HD Surface surface_at(const SceneView& scene, const Ray& ray, const Hit& hit) {
    const std::uint32_t* corner = scene.triangles + 3 * static_cast<std::size_t>(hit.primitive);
    const Vec3 v0 = scene.vertices[corner[0]];
    const Vec3 v1 = scene.vertices[corner[1]];
    const Vec3 v2 = scene.vertices[corner[2]];
    const float w = 1.0f - hit.u - hit.v;

    Surface surface;
    surface.position = v0 * w + v1 * hit.u + v2 * hit.v;
    const Vec3 towards_viewer = ray.direction * -1.0f;
    const Vec3 outside = normalize_or(cross(v1 - v0, v2 - v0), towards_viewer);
    surface.front = dot(outside, ray.direction) < 0.0f;
    surface.geometric_normal = surface.front ? outside : outside * -1.0f;
    surface.shading_normal = surface.geometric_normal;
    if (scene.normals != nullptr) {
        const Vec3 smooth = scene.normals[corner[0]] * w + scene.normals[corner[1]] * hit.u +
                            scene.normals[corner[2]] * hit.v;
        const Vec3 unit = normalize_or(smooth, surface.geometric_normal);
        const Vec3 facing = surface.front ? unit : unit * -1.0f;
        // A smooth normal that faces away from the viewer would light the surface from behind.
        if (dot(facing, ray.direction) < 0.0f) surface.shading_normal = facing;
    }
    surface.offset = kSurfaceOffset * max_of(max_of(max_abs(v0), max_abs(v1)), max_abs(v2));
    surface.material = scene.material_of[hit.primitive];
    return surface;
}

/// A ray from the surface: it starts off the side that it leaves to.
SCOTTY_HD Ray leave_surface(const Surface& surface, const Vec3& direction, float t_max) {
    const float side = dot(direction, surface.geometric_normal) < 0.0f ? -1.0f : 1.0f;
    return {surface.position + surface.geometric_normal * (side * surface.offset), 0.0f, direction,
            t_max};
}

}  // namespace scotty::reference
