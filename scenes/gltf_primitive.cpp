#include "scenes/gltf_primitive.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Error;
using reference::Scene;

namespace {

constexpr std::uint64_t kBatch = 8192;  // elements that are read at once

/// Makes triangles of corners that come one by one.
class Assembler {
 public:
    Assembler(std::uint64_t mode, bool mirrored, std::uint32_t material, Scene& scene)
        : mode_(mode), mirrored_(mirrored), material_(material), scene_(&scene) {}

    void add(std::uint32_t corner) {
        constexpr std::uint64_t kList = 4;
        constexpr std::uint64_t kStrip = 5;
        if (held_ < 2) {
            last_[held_++] = corner;
            return;
        }
        const auto [first, second] = last_;
        if (mode_ == kList) {
            held_ = 0;
            emit(first, second, corner);
        } else if (mode_ == kStrip) {
            // Every second triangle of a strip is turned, so that all face the same way.
            if (turned_) {
                emit_distinct(second, first, corner);
            } else {
                emit_distinct(first, second, corner);
            }
            turned_ = !turned_;
            last_ = {second, corner};
        } else {
            emit_distinct(second, corner, first);
            last_ = {first, corner};
        }
    }

 private:
    void emit(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (mirrored_) std::swap(b, c);
        add_triangle(*scene_, a, b, c, material_);
    }
    /// Strips are joined by triangles without area, which repeat a corner.
    void emit_distinct(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (a != b && b != c && c != a) emit(a, b, c);
    }

    std::uint64_t mode_;
    bool mirrored_;
    std::uint32_t material_;
    Scene* scene_;
    std::array<std::uint32_t, 2> last_{};
    std::size_t held_ = 0;
    bool turned_ = false;
};

/// Appends the triangles, whose corners are numbers of the primitive's own vertices.
void add_triangles(Scene& scene, const GltfPrimitive& primitive, bool mirrored,
                   std::uint32_t material) {
    Assembler assembler(primitive.mode, mirrored, material, scene);
    const std::uint64_t vertices = primitive.position.count();
    if (!primitive.indices) {
        for (std::uint64_t i = 0; i < vertices; ++i) assembler.add(static_cast<std::uint32_t>(i));
        return;
    }
    const std::uint64_t corners = primitive.indices->count();
    std::vector<std::uint32_t> batch(std::min(corners, kBatch));
    for (std::uint64_t first = 0; first < corners; first += kBatch) {
        const std::uint64_t count = std::min(kBatch, corners - first);
        primitive.indices->read(first, count, batch.data());
        for (std::uint64_t i = 0; i < count; ++i) {
            if (batch[i] >= vertices) {
                throw Error::bad_input(
                    primitive.place,
                    fmt::format("index {}: vertex index {} out of range, there are {} vertices{}",
                                first + i, batch[i], vertices,
                                batch[i] == primitive.indices->largest_number()
                                    ? "; glTF has no primitive restart: make each strip or fan a "
                                      "primitive of its own"
                                    : ""));
            }
            assembler.add(batch[i]);
        }
    }
}

/// The number in the scene of each vertex that a triangle uses, kNone for the others.
std::vector<std::uint32_t> number_vertices(const GltfPrimitive& primitive,
                                           std::span<const std::array<std::uint32_t, 3>> triangles,
                                           std::size_t first_number) {
    std::vector<std::uint32_t> number_of(primitive.position.count(), reference::kNone);
    for (const auto& triangle : triangles) {
        for (const std::uint32_t vertex : triangle) number_of[vertex] = 0;
    }
    std::size_t next = first_number;
    for (std::uint32_t& number : number_of) {
        if (number != reference::kNone) number = static_cast<std::uint32_t>(next++);
    }
    if (next >= reference::kNone) {
        throw Error::bad_input(primitive.place, "more vertices than 32 bits can number");
    }
    return number_of;
}

}  // namespace

void add_gltf_primitive(Scene& scene, const GltfPrimitive& primitive, const GltfPose& pose,
                        std::uint32_t material) {
    const std::size_t before = scene.triangles.size();
    const bool is_skinned = !pose.joints.empty() && !primitive.influences.empty();
    const Affine& place = is_skinned ? pose.joints.front() : pose.place;
    add_triangles(scene, primitive, place.determinant() < 0.0, material);
    const std::span added = std::span(scene.triangles).subspan(before);
    const auto number_of = number_vertices(primitive, added, scene.vertices.size());
    add_gltf_vertices(scene, primitive, pose, number_of);
    for (auto& triangle : added) {
        for (std::uint32_t& vertex : triangle) vertex = number_of[vertex];
    }
}

}  // namespace scotty::scenes
