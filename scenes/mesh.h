/// What the generators and loaders build meshes with.
///
/// While a scene is being built it has one normal per vertex, zero for flat; finish_normals()
/// drops them where the whole scene is flat.
#pragma once

#include <cstdint>

#include "reference/contract/scene.h"

namespace scotty::scenes {

using reference::Vec3;

/// Largest number of triangles that a generator makes: 16 bytes each, plus vertices and the tree.
constexpr double kMaxTriangles = 200e6;

std::uint32_t add_material(reference::Scene& scene, const reference::Material& material);
std::uint32_t add_diffuse(reference::Scene& scene, const Vec3& albedo);
std::uint32_t add_mirror(reference::Scene& scene, const Vec3& reflectance);
std::uint32_t add_glass(reference::Scene& scene, const Vec3& tint, float ior);

std::uint32_t add_vertex(reference::Scene& scene, const Vec3& position,
                         const Vec3& normal = Vec3(0.0f, 0.0f, 0.0f));
/// Counter-clockwise seen from the front.
void add_triangle(reference::Scene& scene, std::uint32_t a, std::uint32_t b, std::uint32_t c,
                  std::uint32_t material);
/// Two triangles over four vertices; the front is the side of cross(edge_x, edge_y).
void add_quad(reference::Scene& scene, const Vec3& corner, const Vec3& edge_x, const Vec3& edge_y,
              std::uint32_t material);

/// A parallelogram light whose front is the side of cross(edge_x, edge_y).
reference::Light parallelogram_light(const Vec3& corner, const Vec3& edge_x, const Vec3& edge_y,
                                     const Vec3& radiance);
/// A triangle light over the corners a, b, c; the front is the side that sees them
/// counter-clockwise.
reference::Light triangle_light(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& radiance);
reference::Light point_light(const Vec3& position, const Vec3& intensity);
/// `direction`, of any length, is where the light shines to; zero makes a light of no direction.
reference::Light spot_light(const Vec3& position, const Vec3& direction, const Vec3& intensity,
                            const reference::SpotCone& cone);
/// `direction`, of any length, is where the light shines to.
reference::Light directional_light(const Vec3& direction, const Vec3& irradiance);
reference::Light environment_light(const Vec3& radiance);
/// From above only: scenes are y up.
reference::Light hemisphere_light(const Vec3& radiance);

/// An emissive quad and the light that stands for it.
void add_lamp(reference::Scene& scene, const Vec3& corner, const Vec3& edge_x, const Vec3& edge_y,
              const Vec3& radiance);

/// Gives the vertices from `first_vertex` on the area-weighted mean normal of the triangles from
/// `first_triangle` on.
void smooth_normals(reference::Scene& scene, std::size_t first_vertex, std::size_t first_triangle);

/// Drops the normals where all of them are zero.
void finish_normals(reference::Scene& scene);

/// A camera at `position` that looks at `target`; `up` need not be perpendicular.
/// Throws reference::Error (internal) where the three have no direction.
reference::Camera look_at(const Vec3& position, const Vec3& target, const Vec3& up,
                          float tan_half_fov);

}  // namespace scotty::scenes
