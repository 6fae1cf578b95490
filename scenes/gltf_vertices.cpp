#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "scenes/gltf_primitive.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Error;

namespace {

/// Vertices that are read at once.
constexpr std::uint64_t kVertexBatch = 8192;

void add_scaled(Point& to, const float* from, double scale) {
    for (std::size_t k = 0; k < 3; ++k) to[k] += scale * from[k];
}

/// The batch of a primitive's vertices from `first` on, as plain numbers.
class VertexBatch {
 public:
    VertexBatch(const GltfPrimitive& primitive, const GltfPose& pose, std::uint64_t first,
                std::uint64_t count)
        : primitive_(&primitive), pose_(&pose), first_(first) {
        read(primitive.position, count, positions_);
        if (primitive.normal) read(*primitive.normal, count, normals_);
        for (std::size_t t = 0; t < primitive.targets.size(); ++t) {
            moves_.emplace_back();
            turns_.emplace_back();
            if (weight(t) == 0.0) continue;
            const auto& [position, normal] = primitive.targets[t];
            if (position) read(*position, count, moves_.back());
            if (normal && primitive.normal) read(*normal, count, turns_.back());
        }
        if (pose.joints.empty()) return;
        for (const GltfInfluences& set : primitive.influences) {
            joints_.emplace_back(count * 4);
            set.joints.read(first, count, joints_.back().data());
            read(set.weights, count, weights_.emplace_back());
        }
    }

    const float* file_position(std::uint64_t i) const { return &positions_[i * 3]; }
    /// Vertex `i` of the batch in the scene.
    Vec3 position(std::uint64_t i, const Affine& place) const {
        Point out{};
        add_scaled(out, &positions_[i * 3], 1.0);
        for (std::size_t t = 0; t < moves_.size(); ++t) {
            if (!moves_[t].empty()) add_scaled(out, &moves_[t][i * 3], weight(t));
        }
        return rounded(place.point(out));
    }
    Vec3 normal(std::uint64_t i, const Affine& place) const {
        if (normals_.empty()) return Vec3(0.0f);
        Point out{};
        add_scaled(out, &normals_[i * 3], 1.0);
        for (std::size_t t = 0; t < turns_.size(); ++t) {
            if (!turns_[t].empty()) add_scaled(out, &turns_[t][i * 3], weight(t));
        }
        return rounded(place.normal(out));
    }
    /// Where vertex `i` is taken: the node's place, or the weighted mean of its joints'.
    Affine place_of(std::uint64_t i) const {
        if (joints_.empty()) return pose_->place;
        Affine sum;
        for (auto& row : sum.m) row.fill(0.0);
        double total = 0.0;
        for (std::size_t set = 0; set < joints_.size(); ++set) {
            for (std::size_t k = i * 4; k < i * 4 + 4; ++k) {
                const double share = weights_[set][k];
                if (share == 0.0) continue;
                const Affine& joint = joint_of(i, joints_[set][k]);
                for (std::size_t r = 0; r < 3; ++r) {
                    for (std::size_t c = 0; c < 4; ++c) sum.m[r][c] += share * joint.m[r][c];
                }
                total += share;
            }
        }
        if (!(total > 0.0)) return joint_of(i, joints_[0][i * 4]);
        // Exporters round weights, so that their sum is not quite one.
        for (auto& row : sum.m) {
            for (double& value : row) value /= total;
        }
        return sum;
    }

 private:
    void read(const GltfAccessor& accessor, std::uint64_t count, std::vector<float>& to) const {
        to.resize(count * accessor.components());
        accessor.read(first_, count, to.data());
    }
    double weight(std::size_t target) const {
        return target < pose_->weights.size() ? pose_->weights[target] : 0.0;
    }
    const Affine& joint_of(std::uint64_t i, std::uint32_t number) const {
        if (number < pose_->joints.size()) return pose_->joints[number];
        throw Error::bad_input(primitive_->place,
                               fmt::format("vertex {}: joint {} out of range, the skin has {}",
                                           first_ + i, number, pose_->joints.size()));
    }

    const GltfPrimitive* primitive_;
    const GltfPose* pose_;
    std::uint64_t first_;
    std::vector<float> positions_, normals_;
    std::vector<std::vector<float>> moves_, turns_;  ///< of the targets; empty where they have none
    std::vector<std::vector<std::uint32_t>> joints_;
    std::vector<std::vector<float>> weights_;
};

}  // namespace

void add_gltf_vertices(reference::Scene& scene, const GltfPrimitive& primitive,
                       const GltfPose& pose, const std::vector<std::uint32_t>& number_of) {
    const std::uint64_t vertices = number_of.size();
    for (std::uint64_t first = 0; first < vertices; first += kVertexBatch) {
        const std::uint64_t count = std::min(kVertexBatch, vertices - first);
        const VertexBatch batch(primitive, pose, first, count);
        for (std::uint64_t i = 0; i < count; ++i) {
            if (number_of[first + i] == reference::kNone) continue;
            const Affine place = batch.place_of(i);
            const Vec3 position = batch.position(i, place);
            if (!std::isfinite(position.x + position.y + position.z)) {
                const float* p = batch.file_position(i);
                throw Error::bad_input(
                    primitive.place,
                    fmt::format("vertex {}: expected a finite position, found {} {} {}, placed at "
                                "{} {} {}",
                                first + i, p[0], p[1], p[2], position.x, position.y, position.z));
            }
            add_vertex(scene, position, batch.normal(i, place));
        }
    }
}

}  // namespace scotty::scenes
