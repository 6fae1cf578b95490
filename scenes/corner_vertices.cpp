#include "scenes/corner_vertices.h"

#include <algorithm>
#include <cstring>

#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::kNone;
using reference::Scene;

namespace {

std::array<std::uint32_t, 3> bits_of(const Vec3& v) {
    std::array<std::uint32_t, 3> bits{};
    std::memcpy(bits.data(), &v, sizeof bits);
    return bits;
}

}  // namespace

CornerVertices::CornerVertices(Scene& scene)
    : scene_(scene),
      is_used_(scene.vertices.size()),
      positions_(static_cast<std::uint32_t>(scene.vertices.size())) {}

std::uint32_t CornerVertices::vertex(std::uint32_t position, const Vec3& normal) {
    if (!is_used_[position]) {
        is_used_[position] = true;
        scene_.normals[position] = normal;
        return position;
    }
    const auto bits = bits_of(normal);
    if (bits_of(scene_.normals[position]) == bits) return position;
    if (2 * position_of_copy_.size() >= slots_.size()) grow();
    std::size_t slot = first_slot(position, normal);
    while (slots_[slot] != kNone) {
        const std::uint32_t copy = slots_[slot];
        if (position_of_copy_[copy - positions_] == position &&
            bits_of(scene_.normals[copy]) == bits) {
            return copy;
        }
        slot = (slot + 1) & (slots_.size() - 1);
    }
    position_of_copy_.push_back(position);
    // The position is copied before the vertices may move.
    const Vec3 where = scene_.vertices[position];
    slots_[slot] = add_vertex(scene_, where, normal);
    return slots_[slot];
}

std::size_t CornerVertices::first_slot(std::uint32_t position, const Vec3& normal) const {
    std::uint64_t hash = position;
    for (const std::uint32_t word : bits_of(normal)) {
        hash = (hash ^ word) * 0x9e3779b97f4a7c15ull;
        hash ^= hash >> 29;
    }
    return static_cast<std::size_t>(hash) & (slots_.size() - 1);
}

void CornerVertices::grow() {
    slots_.assign(std::max<std::size_t>(1024, 2 * slots_.size()), kNone);
    for (std::uint32_t i = 0; i < position_of_copy_.size(); ++i) {
        const std::uint32_t copy = positions_ + i;
        std::size_t slot = first_slot(position_of_copy_[i], scene_.normals[copy]);
        while (slots_[slot] != kNone) slot = (slot + 1) & (slots_.size() - 1);
        slots_[slot] = copy;
    }
}

void CornerVertices::drop_unused() {
    is_used_.resize(scene_.vertices.size(), true);
    drop_unused_vertices(scene_, is_used_);
}

void drop_unused_vertices(Scene& scene, const std::vector<bool>& is_used) {
    if (std::find(is_used.begin(), is_used.end(), false) == is_used.end()) return;
    std::vector<std::uint32_t> place(is_used.size(), kNone);
    std::uint32_t kept = 0;
    for (std::size_t i = 0; i < is_used.size(); ++i) {
        if (!is_used[i]) continue;
        scene.vertices[kept] = scene.vertices[i];
        scene.normals[kept] = scene.normals[i];
        place[i] = kept++;
    }
    scene.vertices.resize(kept);
    scene.normals.resize(kept);
    for (auto& triangle : scene.triangles) {
        for (std::uint32_t& vertex : triangle) vertex = place[vertex];
    }
}

}  // namespace scotty::scenes
