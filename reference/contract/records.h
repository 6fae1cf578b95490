/// The records that every pipeline agrees on: float32 and uint32, little endian, by ray id.
///
/// A queue entry is a 4-byte ray id; everything a ray carries along its path is state indexed by
/// that id. Layouts are part of the contract: a capture holds these bytes.
#pragma once

#include <cstddef>
#include <cstdint>

#include "reference/base/host_device.h"
#include "reference/base/vec3.h"

namespace scotty::reference {

/// "No child", "no primitive", "no node".
constexpr std::uint32_t kNone = 0xffffffffu;

/// The largest coordinate that scenes may have (loaders check it).
constexpr float kMaxCoordinate = 1.0e12f;

/// Traversal ray: hits count in the half-open interval [t_min, t_max).
/// One 32-byte record, so that a gather through shuffled ids is two 16-byte loads.
struct alignas(16) Ray {
    Vec3 origin;
    float t_min;  ///< >= 0
    Vec3 direction;
    float t_max;  ///< may be +infinity; t_max < t_min is a dead ray, which hits nothing
};
static_assert(sizeof(Ray) == 32, "two 16-byte loads");

/// A ray that no traversal follows.
SCOTTY_HD Ray dead_ray() { return {Vec3(0.0f, 0.0f, 0.0f), 0.0f, Vec3(0.0f, 0.0f, 1.0f), -1.0f}; }
SCOTTY_HD bool is_dead(const Ray& ray) { return ray.t_max < ray.t_min; }

/// Closest hit: position = (1 - u - v) v0 + u v1 + v v2.
struct alignas(16) Hit {
    float t;                  ///< +infinity where nothing is hit
    std::uint32_t primitive;  ///< triangle index in the scene, kNone where nothing is hit
    float u;
    float v;
};
static_assert(sizeof(Hit) == 16, "one 16-byte load");

SCOTTY_HD Hit no_hit() { return {kInfinity, kNone, 0.0f, 0.0f}; }
SCOTTY_HD bool is_hit(const Hit& hit) { return hit.primitive != kNone; }

/// Packed hit of a ray that hits nothing: greater than every (t, primitive).
constexpr std::uint64_t kNoPackedHit = ~std::uint64_t{0};
/// A ray whose minimum is this has its any-hit answer: every entry distance is greater.
constexpr float kDone = -1.0f;

/// One entry of a ray's multi-intersection buffer.
struct HitCandidate {
    float t;
    std::uint32_t primitive;
};
static_assert(sizeof(HitCandidate) == 8, "one 8-byte store");

/// Inner node of an N-way BVH. Missing children: kNone with an inverted, infinite box.
/// An entry of a level's queue of pairs: the ray goes on in the node's children.
struct alignas(8) NodeRay {
    std::uint32_t node;  ///< index of an inner node, as in WideBvh::inner
    std::uint32_t ray;
};

template <int Width>
struct alignas(16) WideNode {
    float low_x[Width], low_y[Width], low_z[Width];
    float high_x[Width], high_y[Width], high_z[Width];
    std::uint32_t child[Width];  ///< node id, kNone where there is none
    float low[3], high[3];       ///< box of the node itself: what ray_slabs() pads by
};

/// Nodes of a subtree that can wait at once: cut_levels() leaves no subtree that needs more.
constexpr std::uint32_t kSubtreeStack = 128;

/// Leaf of a BVH: a range of WideBvh::triangles.
struct Leaf {
    std::uint32_t first;
    std::uint32_t count;
};

/// A triangle as the traversal reads it, in leaf order.
struct alignas(8) LeafTriangle {
    Vec3 v0, v1, v2;
    std::uint32_t primitive;  ///< its index in the scene
};
static_assert(sizeof(LeafTriangle) == 40, "packed");

/// WideBvhView::node_refs: the top bit tells a leaf from an inner node, the rest is its index.
constexpr std::uint32_t kLeafBit = 0x80000000u;
SCOTTY_HD bool is_leaf(std::uint32_t node_ref) { return (node_ref & kLeafBit) != 0; }
SCOTTY_HD std::uint32_t ref_index(std::uint32_t node_ref) { return node_ref & ~kLeafBit; }

enum class MaterialKind : std::uint32_t {
    diffuse = 0,
    mirror = 1,
    glass = 2,
    conductor = 3  ///< rough metal: GGX microfacets
};
constexpr std::size_t kMaterialKinds = 4;

/// What a surface does with light. Emission is a property of its own: a diffuse surface may glow.
struct Material {
    MaterialKind kind = MaterialKind::diffuse;
    /// Albedo of diffuse, tint of mirror and glass, of a conductor what it reflects head on; 0..1.
    Vec3 reflectance{0.0f, 0.0f, 0.0f};
    Vec3 transmittance{0.0f, 0.0f, 0.0f};  ///< tint of refraction (glass); 0..1
    /// Index of refraction inside (glass). A conductor keeps its roughness here, 0..1.
    float ior = 1.0f;
    Vec3 emission{0.0f, 0.0f, 0.0f};  ///< radiance leaving the front side (winding), W/m^2/sr
    /// 1 where a Light of the scene stands for this emission: then a path counts it only where it
    /// is seen directly or in a mirror, never a second time after light sampling.
    std::uint32_t emission_is_sampled = 0;
};

/// A lobe narrower than this is found by scattering only, like a mirror's: lights that have an
/// extent are not sampled for it, and emission that a path meets after it counts. Wider ones are
/// lit by light samples only, like diffuse surfaces. Each light is counted once either way.
constexpr float kSharpRoughness = 0.3f;
/// A smoother conductor is taken to be this rough: below it floats cannot resolve the lobe.
constexpr float kLeastRoughness = 0.02f;

/// All light leaves in one direction for each that arrives: its BSDF has no values.
SCOTTY_HD bool is_smooth(const Material& material) {
    return material.kind == MaterialKind::mirror || material.kind == MaterialKind::glass;
}
/// What follows a scattering counts as seen directly.
SCOTTY_HD bool is_sharp(const Material& material) {
    return is_smooth(material) ||
           (material.kind == MaterialKind::conductor && material.ior < kSharpRoughness);
}

enum class LightKind : std::uint32_t {
    parallelogram = 0,  ///< position + x edge_x + y edge_y, x and y in [0, 1]
    triangle = 1,       ///< the same with x + y <= 1
    point = 2,
    directional = 3,
    environment = 4,  ///< the same radiance from every direction
    hemisphere = 5,   ///< the same from the half around `normal`, black from the other
    spot = 6          ///< a point that shines into a cone around `normal`; see SpotCone
};
constexpr std::size_t kLightKinds = 7;
/// A path can meet it: it has an area, or fills a part of the sky.
SCOTTY_HD bool has_extent(LightKind kind) {
    return kind == LightKind::parallelogram || kind == LightKind::triangle ||
           kind == LightKind::environment || kind == LightKind::hemisphere;
}

struct Light {
    LightKind kind = LightKind::point;
    Vec3 position{0.0f, 0.0f, 0.0f};  ///< corner of an area light, or the point
    Vec3 edge_x{0.0f, 0.0f, 0.0f};    ///< of an area light; a spot light keeps its SpotCone here
    Vec3 edge_y{0.0f, 0.0f, 0.0f};
    /// Unit: the front side of an area light (it emits there only); where a directional or spot
    /// light shines to; the middle of a hemisphere.
    Vec3 normal{0.0f, 0.0f, 1.0f};
    /// Area, environment: radiance, W/m^2/sr. Point: intensity, W/sr. Spot: the same in the middle
    /// of the cone. Directional: irradiance on a surface that faces it, W/m^2.
    Vec3 radiance{0.0f, 0.0f, 0.0f};
    float area = 0.0f;  ///< m^2, area lights
};

/// Cosines of the angles from a spot light's direction up to which it has its full intensity
/// (inner) and from which on it is dark (outer). -1 <= outer <= inner <= 1, outer < 1.
struct SpotCone {
    float inner;
    float outer;
};
SCOTTY_HD SpotCone spot_cone(const Light& light) { return {light.edge_x.x, light.edge_x.y}; }
SCOTTY_HD void set_spot_cone(Light& light, const SpotCone& cone) {
    light.edge_x = Vec3(cone.inner, cone.outer, 0.0f);
}

/// Pinhole camera; right, up, forward are orthonormal and right-handed as seen: x right, y up.
struct Camera {
    Vec3 position{0.0f, 0.0f, 0.0f};
    Vec3 right{1.0f, 0.0f, 0.0f};
    Vec3 up{0.0f, 1.0f, 0.0f};
    Vec3 forward{0.0f, 0.0f, -1.0f};
    /// Tangent of half the vertical field of view. The horizontal one follows from the image's
    /// aspect ratio, so any image shape sees an undistorted scene.
    float tan_half_fov = 0.5f;
    /// Where not 0, the tangent of half the horizontal field of view: then the vertical one follows
    /// from the image's aspect ratio instead, and tan_half_fov does not count.
    float tan_half_width = 0.0f;
};

/// Bits of PathState::flags.
constexpr std::uint32_t kPathAlive = 1u;     ///< there is a vertex to shade
constexpr std::uint32_t kPathSpecular = 2u;  ///< the last scattering was a mirror's or glass's

}  // namespace scotty::reference
