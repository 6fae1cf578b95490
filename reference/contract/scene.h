/// The scene model: what loaders and generators make and every tracer reads.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "reference/contract/records.h"

namespace scotty::reference {

/// What a scene file holds; the scene itself keeps no trace of it. All 0 for a built-in scene.
struct FileContents {
    std::size_t meshes = 0;     ///< that are placed in the scene
    std::size_t instances = 0;  ///< how often they are placed, all together
    std::size_t cameras = 0;
    std::size_t lights = 0;  ///< without those that emissive meshes become
};

/// Indexed triangles with one material each, lights, a camera. Right-handed, metres.
struct Scene {
    std::string name;    ///< what reports call it: "coil", "CBbunny.dae"
    std::string source;  ///< what `scotty` was given: a built-in's spec or a path
    std::vector<Vec3> vertices;
    /// One per vertex, unit; zero where the surface is flat there. Empty: all flat.
    std::vector<Vec3> normals;
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< vertex indices
    std::vector<std::uint32_t> material_of;               ///< one per triangle
    std::vector<Material> materials;
    std::vector<Light> lights;
    Camera camera;
    /// What was repaired, approximated or left out on the way in: one sentence each.
    std::vector<std::string> warnings;
    FileContents file;
};

/// Plain pointers into a Scene, for kernels. Valid as long as the scene is neither changed nor
/// freed.
struct SceneView {
    const Vec3* vertices = nullptr;
    const Vec3* normals = nullptr;             ///< null: all flat
    const std::uint32_t* triangles = nullptr;  ///< three vertex indices each
    const std::uint32_t* material_of = nullptr;
    const Material* materials = nullptr;
    const Light* lights = nullptr;
    std::uint32_t triangle_count = 0;
    std::uint32_t light_count = 0;
    Vec3 environment{0.0f, 0.0f, 0.0f};  ///< radiance of all environment lights together
    Vec3 hemisphere{0.0f, 0.0f, 0.0f};   ///< of all hemisphere lights, from around hemisphere_up
    Vec3 hemisphere_up{0.0f, 1.0f, 0.0f};
    Camera camera;
};

SceneView view_of(const Scene& scene);

/// Checks what everything downstream relies on and repairs what can be repaired.
/// Errors (bad_input naming the element): no triangles, an index out of range, a vertex that is
/// not finite or beyond kMaxCoordinate, a material index out of range, a material or light value
/// that is not finite, negative or above its range, a camera that is not orthonormal or finite.
/// Repairs (a line in `warnings` with the count): normals that are not finite or unit length,
/// zero-area triangles (kept: they have no interior to hit), no light and no emission (the picture
/// is black).
void validate_and_repair(Scene& scene);

/// Hash of all that influences a picture; the same for equal scenes on every machine.
std::uint64_t fingerprint(const Scene& scene);

struct Bounds {
    Vec3 low{kInfinity, kInfinity, kInfinity};
    Vec3 high{-kInfinity, -kInfinity, -kInfinity};
};
Bounds bounds_of(const Scene& scene);

}  // namespace scotty::reference
