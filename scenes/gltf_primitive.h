/// Meshes of a glTF file: what their primitives are made of, and their triangles in a scene.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "scenes/affine.h"
#include "scenes/gltf_accessor.h"

namespace scotty::scenes {

/// Four of the joints that move each vertex, and how much.
struct GltfInfluences {
    GltfAccessor joints;
    GltfAccessor weights;
};

/// What a morph target of full weight adds to each vertex.
struct GltfTarget {
    std::optional<GltfAccessor> position;
    std::optional<GltfAccessor> normal;
};

/// Where a mesh is and what shape it has there.
struct GltfPose {
    Affine place;
    std::span<const Affine> joints;  ///< of its skin, from the mesh to the scene; none: no skin
    std::vector<double> weights;     ///< of its morph targets; those that are missing are 0
};

/// A part of a mesh that has triangles; its accessors are checked against each other.
struct GltfPrimitive {
    std::string place;  ///< for errors: "a.gltf: meshes[2] ('Cube'): primitives[0]"
    std::uint64_t mode = 4;
    std::optional<std::uint64_t> material;
    GltfAccessor position;
    std::optional<GltfAccessor> normal;
    std::optional<GltfAccessor> indices;
    std::vector<GltfInfluences> influences = {};
    std::vector<GltfTarget> targets = {};

    std::uint64_t corners() const { return indices ? indices->count() : position.count(); }
    /// As many as there can be: those of a strip that repeat a corner are left out.
    std::uint64_t triangles() const;
};

/// The primitives of a mesh. Notes those that are left out (points, lines, no positions) and what
/// the others have that is not supported. Throws reference::Error (bad_input).
std::vector<GltfPrimitive> read_gltf_mesh(GltfDocument& document, const GltfObject& mesh,
                                          Notes& notes);

/// Appends a primitive's triangles and the vertices that they use, in the order of the file.
/// Throws reference::Error (bad_input) naming the primitive where an index is out of range or a
/// position is not finite.
void add_gltf_primitive(reference::Scene& scene, const GltfPrimitive& primitive,
                        const GltfPose& pose, std::uint32_t material);

/// Appends the vertices whose number is not kNone, posed (gltf_vertices.cpp).
void add_gltf_vertices(reference::Scene& scene, const GltfPrimitive& primitive,
                       const GltfPose& pose, const std::vector<std::uint32_t>& number_of);

/// What the extension KHR_draco_mesh_compression of a primitive holds (gltf_draco.cpp): indices,
/// POSITION and, if there, NORMAL.
struct GltfDracoMesh {
    GltfAccessor indices;
    GltfAccessor position;
    std::optional<GltfAccessor> normal;
};
GltfDracoMesh decode_draco(GltfDocument& document, const GltfObject& extension);

}  // namespace scotty::scenes
