/// Scene and BVH in device memory.
#pragma once

#include <vector>

#include "gpu/host/device_memory.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/subtree_ray.h"
#include "gpu/kernels/views.h"
#include "reference/contract/scene.h"
#include "reference/contract/wide_bvh.h"

namespace SCOTTY_DEVICE_NAMESPACE {

class DeviceScene {
 public:
    /// `pairs`: all nodes are laid out as those below the queues are, since pairs are tested so.
    DeviceScene(const reference::Scene& scene, const reference::WideBvh& bvh, bool pairs,
                MemoryBudget& budget);

    reference::SceneView view() const { return view_; }
    void set_camera(const reference::Camera& camera) { view_.camera = camera; }
    template <int Width>
    BvhView<Width> bvh() const {
        return {reinterpret_cast<const reference::WideNode<Width>*>(inner_.data()),
                leaves_.data(),
                triangle_rows_.data(),
                node_refs_.data(),
                reinterpret_cast<const SubtreeNode<Width>*>(subtrees_.data()),
                first_subtree_};
    }
    /// The whole BVH as a subtree.
    const SubtreeRoot& root() const { return root_; }
    /// By node id: the parent's position in its level.
    const std::uint32_t* parent_positions() const { return parent_positions_.data(); }
    int width() const { return width_; }
    const std::vector<std::uint32_t>& level_begins() const { return level_begins_; }
    /// reference::inner_begins().
    const std::vector<std::uint32_t>& inner_begins() const { return inner_begins_; }
    std::uint32_t level_count() const {
        return static_cast<std::uint32_t>(level_begins_.size() - 1);
    }
    std::uint32_t level_nodes(std::uint32_t level) const {
        return level < level_count() ? level_begins_[level + 1] - level_begins_[level] : 0;
    }
    /// WideBvh::is_level_of_subtrees().
    bool is_level_of_subtrees(std::uint32_t level) const {
        return has_subtrees_ && level + 1 == level_count();
    }

 private:
    int width_;
    std::vector<std::uint32_t> level_begins_, inner_begins_;
    bool has_subtrees_;
    SubtreeRoot root_;
    std::uint32_t first_subtree_;  ///< inner nodes of the levels above; 0 with pairs
    reference::SceneView view_;
    DeviceMemory<reference::Vec3> vertices_, normals_;
    DeviceMemory<std::uint32_t> triangles_, material_of_;
    DeviceMemory<reference::Material> materials_;
    DeviceMemory<reference::Light> lights_;
    DeviceMemory<std::uint8_t> inner_, subtrees_;
    DeviceMemory<reference::Leaf> leaves_;
    DeviceMemory<TriangleRows> triangle_rows_;
    DeviceMemory<std::uint32_t> node_refs_, parent_positions_;
};

}  // namespace SCOTTY_DEVICE_NAMESPACE
