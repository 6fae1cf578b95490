#include <variant>

#include "gpu/device_scene.h"
#include "gpu/dialect.h"
#include "gpu/subtree_refs.h"

namespace SCOTTY_DEVICE_NAMESPACE {

namespace {

std::vector<std::uint32_t> positions_of_parents(const reference::WideBvh& bvh) {
    std::vector<std::uint32_t> positions(bvh.node_count(), 0);
    for (std::uint32_t level = 1; level < bvh.level_count(); ++level) {
        for (std::uint32_t id = bvh.level_begins[level]; id < bvh.level_begins[level + 1]; ++id) {
            positions[id] = bvh.parents[id] - bvh.level_begins[level - 1];
        }
    }
    return positions;
}

}  // namespace

DeviceScene::DeviceScene(const reference::Scene& scene, const reference::WideBvh& bvh,
                         MemoryBudget& budget)
    : width_(bvh.width),
      level_begins_(bvh.level_begins),
      has_subtrees_(bvh.has_subtrees()),
      packed_leaves_(can_pack(bvh)),
      vertices_(budget),
      normals_(budget),
      triangles_(budget),
      material_of_(budget),
      materials_(budget),
      lights_(budget),
      inner_(budget),
      leaves_(budget),
      leaf_triangles_(budget),
      node_refs_(budget),
      parent_positions_(budget) {
    vertices_.upload(scene.vertices, "vertices");
    normals_.upload(scene.normals, "normals");
    triangles_.upload({scene.triangles.front().data(), 3 * scene.triangles.size()}, "triangles");
    material_of_.upload(scene.material_of, "materials of triangles");
    materials_.upload(scene.materials, "materials");
    lights_.upload(scene.lights, "lights");
    std::visit(
        [&](const auto& nodes) {
            const auto upload = [&](const auto& of) {
                inner_.upload(
                    {reinterpret_cast<const std::uint8_t*>(of.data()), of.size() * sizeof(of[0])},
                    "BVH nodes");
            };
            if (!has_subtrees_) {
                upload(nodes);
                return;
            }
            auto with_refs = nodes;  // the host keeps ids
            make_subtree_refs(bvh, packed_leaves_, with_refs);
            upload(with_refs);
        },
        bvh.inner);
    leaves_.upload(bvh.leaves, "BVH leaves");
    leaf_triangles_.upload(bvh.triangles, "BVH triangles");
    node_refs_.upload(bvh.node_refs, "BVH node references");
    parent_positions_.upload(positions_of_parents(bvh), "BVH parents");

    view_ = reference::view_of(scene);
    view_.vertices = vertices_.data();
    view_.normals = scene.normals.empty() ? nullptr : normals_.data();
    view_.triangles = triangles_.data();
    view_.material_of = material_of_.data();
    view_.materials = materials_.data();
    view_.lights = lights_.data();
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
