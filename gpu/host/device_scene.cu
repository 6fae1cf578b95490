#include <algorithm>
#include <tuple>
#include <variant>

#include "gpu/host/device_scene.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/subtree_nodes.h"

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

SubtreeRoot root_of(const reference::WideBvh& bvh) {
    return std::visit(
        [](const auto& inner) {
            const auto& [low, high] = std::tie(inner[0].low, inner[0].high);
            return SubtreeRoot{0, {low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
        },
        bvh.inner);
}

template <class T>
std::span<const std::uint8_t> bytes_of(const std::vector<T>& records, std::size_t count) {
    return {reinterpret_cast<const std::uint8_t*>(records.data()), count * sizeof(T)};
}

}  // namespace

DeviceScene::DeviceScene(const reference::Scene& scene, const reference::WideBvh& bvh, bool pairs,
                         MemoryBudget& budget)
    : width_(bvh.width),
      level_begins_(bvh.level_begins),
      inner_begins_(reference::inner_begins(bvh)),
      has_subtrees_(bvh.has_subtrees()),
      root_(root_of(bvh)),
      first_subtree_(pairs ? 0 : inner_begins_[bvh.level_count() - 1]),
      vertices_(budget),
      normals_(budget),
      triangles_(budget),
      material_of_(budget),
      materials_(budget),
      lights_(budget),
      inner_(budget),
      subtrees_(budget),
      leaves_(budget),
      triangle_rows_(budget),
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
            inner_.upload(bytes_of(nodes, inner_begins_.back()), "BVH nodes");
            if (!has_subtrees_ && !pairs) return;
            const auto subtrees = subtree_nodes(bvh, nodes, first_subtree_);
            subtrees_.upload(bytes_of(subtrees, subtrees.size()), "BVH nodes below the queues");
        },
        bvh.inner);
    // Of nodes below the queues nobody asks for an id.
    const std::uint32_t nodes = bvh.level_begins.back();
    const std::vector<std::uint32_t> positions = positions_of_parents(bvh);
    leaves_.upload({bvh.leaves.data(), nodes - inner_begins_.back()}, "BVH leaves");
    triangle_rows_.upload(triangle_rows(bvh), "BVH triangles");
    node_refs_.upload({bvh.node_refs.data(), nodes}, "BVH node references");
    parent_positions_.upload({positions.data(), nodes}, "BVH parents");

    view_ = reference::view_of(scene);
    view_.vertices = vertices_.data();
    view_.normals = scene.normals.empty() ? nullptr : normals_.data();
    view_.triangles = triangles_.data();
    view_.material_of = material_of_.data();
    view_.materials = materials_.data();
    view_.lights = lights_.data();
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
