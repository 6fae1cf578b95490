/// The parts of a glTF scene that are not meshes: materials, lights, cameras, nodes.
#pragma once

#include <optional>
#include <vector>

#include "reference/contract/records.h"
#include "scenes/affine.h"
#include "scenes/gltf_document.h"

namespace scotty::scenes {

/// A material and whether its surface can be seen at all (alphaMode).
struct GltfMaterial {
    reference::Material material;
    bool is_visible = true;
};
GltfMaterial read_gltf_material(const GltfObject& object, Notes& notes);

/// A light of KHR_lights_punctual, which shines along its node's -z. Nothing, with a note, where
/// the node's transform leaves it no direction.
std::optional<reference::Light> read_gltf_light(const GltfObject& light, const Affine& place,
                                                Notes& notes);

/// A perspective camera, which looks along its node's -z; nothing, with a note, for others.
std::optional<reference::Camera> read_gltf_camera(const GltfObject& camera, const Affine& place,
                                                  Notes& notes);

/// The nodes below the scene that is shown, and where they are.
class GltfNodes {
 public:
    struct Placed {
        std::uint64_t index;
        Affine place;
    };

    /// Throws reference::Error (bad_input) where nodes are no trees: a child of two nodes, a node
    /// below itself, a root that is a child. Notes scenes that are not shown.
    GltfNodes(const GltfDocument& document, Notes& notes);

    /// Depth first, in the order of the file.
    const std::vector<Placed>& placed() const { return placed_; }
    /// Where a node is; null where the scene does not show it, or there is none.
    const Affine* place_of(std::uint64_t node) const;

 private:
    std::vector<std::uint64_t> roots(const GltfDocument& document, Notes& notes) const;
    void find_parents(const std::vector<GltfObject>& nodes);
    void check_circles(const std::vector<GltfObject>& nodes) const;
    void place_below(std::uint64_t root, const std::vector<GltfObject>& nodes, Notes& notes);

    std::vector<std::vector<std::uint64_t>> children_;
    std::vector<std::uint64_t> parent_;
    std::vector<Placed> placed_;
    std::vector<std::uint64_t> number_in_placed_;
};

/// The joints of a skin, each from the space of the mesh to the scene. Throws reference::Error
/// (bad_input) where a joint is not in the scene or a matrix is missing.
std::vector<Affine> read_gltf_skin(GltfDocument& document, const GltfObject& skin,
                                   const GltfNodes& nodes);

}  // namespace scotty::scenes
