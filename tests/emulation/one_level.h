/// One handmade level of a BVH and its queues, for tests of the level kernel alone.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "emulation/kernels/intersect.h"
#include "emulation/kernels/intersect_root.h"
#include "emulation/kernels/scan_counts.h"
#include "tests/reference/meshes.h"

namespace scotty::emulation::test {

using reference::HitCandidate;
using reference::kInfinity;
using reference::kNone;
using reference::Ray;
using reference::Vec3;
using reference::test::Random;

constexpr std::uint32_t kPoison = 0xdeadbeefu;

/// Inner nodes 1..n under a root that does not exist, their children after them breadth-first.
/// `pushed[child]`: what a straight loop with the same numerics puts into each child's queue.
template <int Width>
struct OneLevel {
    OneLevel(const std::vector<std::uint32_t>& queue_lengths, std::uint32_t seed)
        : random(seed), node_counts(queue_lengths) {
        const auto nodes = static_cast<std::uint32_t>(queue_lengths.size());
        node_refs.push_back(kPoison);
        for (std::uint32_t i = 0; i < nodes; ++i) {
            node_refs.push_back(i);
            inner.push_back(make_node(i, 1 + nodes));
        }
        rays = reference::test::random_rays(500, 1.5f, seed + 1);
        for (std::size_t i = 0; i < rays.size(); i += 11) rays[i] = reference::dead_ray();
        for (std::size_t i = 5; i < rays.size(); i += 13) rays[i].direction = Vec3(0, 0, -1);
        for (std::size_t i = 7; i < rays.size(); i += 17) rays[i].t_max = 0.5f;
        for (std::uint32_t i = 0; i < nodes; ++i) {
            queue_offsets.push_back(static_cast<std::uint32_t>(queue.size()));
            for (std::uint32_t entry = 0; entry < queue_lengths[i]; ++entry) {
                queue.push_back(below(static_cast<std::uint32_t>(rays.size())));
            }
        }
        queue_offsets.push_back(static_cast<std::uint32_t>(queue.size()));
        minimum.assign(rays.size(), kInfinity);
    }

    std::uint32_t below(std::uint32_t end) { return static_cast<std::uint32_t>(random() % end); }

    /// A node with 1..Width children, in any of its slots.
    reference::WideNode<Width> make_node(std::uint32_t position, std::uint32_t first_child) {
        reference::WideNode<Width> node{};
        Vec3 low(kInfinity), high(-kInfinity);
        const std::uint32_t always = below(Width);
        for (std::uint32_t c = 0; c < Width; ++c) {
            if (c != always && below(4) == 0) {
                node.child[c] = kNone;
                node.low_x[c] = node.low_y[c] = node.low_z[c] = kInfinity;
                node.high_x[c] = node.high_y[c] = node.high_z[c] = -kInfinity;
                continue;
            }
            node.child[c] = first_child + static_cast<std::uint32_t>(parents.size());
            parents.push_back(position);
            const Vec3 a = reference::test::uniform3(random, -1, 1);
            const Vec3 b = reference::test::uniform3(random, -1, 1);
            const Vec3 box_low = reference::min_of(a, b);
            const Vec3 box_high = reference::max_of(a, b);
            node.low_x[c] = box_low.x, node.low_y[c] = box_low.y, node.low_z[c] = box_low.z;
            node.high_x[c] = box_high.x, node.high_y[c] = box_high.y, node.high_z[c] = box_high.z;
            low = reference::min_of(low, box_low);
            high = reference::max_of(high, box_high);
        }
        for (int axis = 0; axis < 3; ++axis) {
            node.low[axis] = low[axis];
            node.high[axis] = high[axis];
        }
        return node;
    }

    /// The straight loop: the ids that belong in every child's queue, in input order.
    std::vector<std::vector<std::uint32_t>> pushed() const {
        std::vector<std::vector<std::uint32_t>> children(parents.size());
        for (std::size_t n = 0; n < inner.size(); ++n) {
            const auto& node = inner[n];
            const Vec3 low(node.low[0], node.low[1], node.low[2]);
            const Vec3 high(node.high[0], node.high[1], node.high[2]);
            for (std::uint32_t i = queue_offsets[n]; i < queue_offsets[n + 1]; ++i) {
                const Ray& ray = rays[queue[i]];
                const reference::RaySlabs slabs =
                    reference::ray_slabs(ray.origin, reference::safe_inverse(ray.direction),
                                         reference::box_pad(ray.origin, low, high));
                for (std::uint32_t c = 0; c < Width; ++c) {
                    if (node.child[c] == kNone) continue;
                    const reference::BoxInterval interval = reference::clip(
                        reference::intersect_box(
                            slabs, Vec3(node.low_x[c], node.low_y[c], node.low_z[c]),
                            Vec3(node.high_x[c], node.high_y[c], node.high_z[c])),
                        ray.t_min, ray.t_max);
                    if (reference::overlaps(interval) && interval.entry <= minimum[queue[i]]) {
                        children[node.child[c] - first_child()].push_back(queue[i]);
                    }
                }
            }
        }
        return children;
    }

    std::uint32_t first_child() const { return 1 + static_cast<std::uint32_t>(inner.size()); }

    /// Sets block and child offsets as scan_counts does; output buffers are poisoned.
    void scan(std::uint32_t threads) {
        block_offsets.resize(inner.size() + 1);
        child_offsets.resize(parents.size() + 1);
        scan_counts(Block(0, kScanThreads),
                    {static_cast<std::uint32_t>(inner.size()), node_counts.data(),
                     static_cast<std::uint32_t>(parents.size()), parents.data(), threads,
                     block_offsets.data(), child_offsets.data()});
        child_counts.assign(parents.size(), 0);
        child_queue.assign(child_offsets.back() + 64, kPoison);
    }

    LevelView view() {
        return {1,
                static_cast<std::uint32_t>(inner.size()),
                first_child(),
                node_counts.data(),
                queue_offsets.data(),
                queue.data(),
                block_offsets.data(),
                child_counts.data(),
                child_offsets.data(),
                child_queue.data(),
                &overflow};
    }
    reference::WideBvhView<Width> bvh() const {
        return {inner.data(), nullptr, nullptr, node_refs.data()};
    }
    MinimumView minimum_view(reference::EarlyOut policy) {
        return {policy, false, minimum.data(), minimum.data()};
    }

    /// Runs the level kernel over all blocks, with `grid_side` as the kernel takes it.
    void run(Device& device, std::uint32_t threads, reference::EarlyOut policy,
             std::uint32_t grid_side = 0) {
        const std::uint32_t blocks = grid_side == 0 ? block_offsets.back() : grid_side * grid_side;
        device.launch(blocks, threads, [&](const Block& block) {
            intersect(block, bvh(), rays.data(), view(), HitView{}, minimum_view(policy),
                      grid_side);
        });
    }

    /// The content of a child's queue after a launch.
    std::vector<std::uint32_t> queue_of(std::size_t child) const {
        const auto begin = child_queue.begin() + child_offsets[child];
        return {begin, begin + child_counts[child]};
    }

    Random random;
    std::vector<reference::WideNode<Width>> inner;
    std::vector<std::uint32_t> node_refs, parents, node_counts, queue_offsets, queue;
    std::vector<Ray> rays;
    std::vector<float> minimum;
    std::vector<std::uint32_t> block_offsets, child_offsets, child_counts, child_queue;
    std::uint32_t overflow = 0;
};

inline std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> ids) {
    std::sort(ids.begin(), ids.end());
    return ids;
}

}  // namespace scotty::emulation::test
