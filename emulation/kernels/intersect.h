/// Kernel: one level of the breadth-first traversal. One block takes up to B rays of one node.
///
/// Inner node: node to shared memory; every ray against every child's box; per child an exclusive
/// scan over the block, one atomicAdd on the child's counter, scatter of ray ids to the child's
/// region. Leaf: triangles to shared memory; each ray's closest hit in the leaf goes to its
/// multi-intersection buffer with one atomicAdd, or into its packed hit with one atomicMin.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "emulation/device/atomics.h"
#include "emulation/device/device.h"
#include "emulation/kernels/views.h"
#include "reference/numerics/intersect_box.h"
#include "reference/numerics/intersect_triangle.h"

namespace scotty::emulation {

/// The rays that a block has loaded, with one register each per thread.
struct BlockRays {
    PerThread<std::uint32_t> id;
    PerThread<float> origin_x, origin_y, origin_z;
    PerThread<float> inverse_x, inverse_y, inverse_z;
    PerThread<float> t_min, t_max;
    PerThread<float> limit;  ///< nearest hit known; +infinity if nothing culls
};

/// The block's work: a node, and a part of its queue.
struct BlockWork {
    std::uint32_t node;   ///< position in the level; kNone: an idle block of the 2-D grid
    std::uint32_t first;  ///< first entry of the node's queue
    std::uint32_t count;  ///< entries, 1..B
};

/// Logical index of a launched block. Strided: the 2018 paper's sqrt(total) x sqrt(total) grid with
/// y as the minor index, so that neighbours in launch order work on different nodes.
inline std::uint32_t logical_block(std::uint32_t launched, std::uint32_t grid_side) {
    return grid_side == 0 ? launched : launched % grid_side * grid_side + launched / grid_side;
}

/// "Parallel search": the threads of a block probe the scanned block offsets together, each round
/// narrowing the range by a factor of B. Returns the last node whose first block is <= `block_id`.
inline std::uint32_t find_node(const Block& block, const std::uint32_t* block_offsets,
                               std::uint32_t node_count, std::uint32_t block_id) {
    std::uint32_t low = 0;
    std::uint32_t length = node_count;
    while (length > 1) {
        const std::uint32_t step = (length + block.threads() - 1) / block.threads();
        const std::uint32_t probes = (length + step - 1) / step;
        // Count the threads that found their probe at or before the block.
        const std::uint32_t passed = block.count(probes, [&](std::uint32_t thread) {
            return block_offsets[low + thread * step] <= block_id;
        });
        const std::uint32_t skipped = (passed - 1) * step;
        low += skipped;
        length = std::min(step, length - skipped);
    }
    return low;
}

inline BlockWork find_work(const Block& block, const LevelView& level, std::uint32_t grid_side) {
    const std::uint32_t id = logical_block(block.index(), grid_side);
    if (id >= level.block_offsets[level.node_count]) return {reference::kNone, 0, 0};
    const std::uint32_t node = find_node(block, level.block_offsets, level.node_count, id);
    const std::uint32_t first = (id - level.block_offsets[node]) * block.threads();
    return {node, first, std::min(block.threads(), level.node_counts[node] - first)};
}

/// Gathers the block's rays through their ids.
inline void load_rays(const Block& block, const BlockWork& work, const reference::Ray* rays,
                      const LevelView& level, const MinimumView& minimum, BlockRays& out) {
    const std::uint32_t* queue = level.queue == nullptr
                                     ? nullptr
                                     : level.queue + level.queue_offsets[work.node] + work.first;
    block.phase(work.count, [&](std::uint32_t thread) {
        out.id[thread] = queue == nullptr ? work.first + thread : queue[thread];
        prefetch(&rays[out.id[thread]].origin);
        prefetch(&rays[out.id[thread]].t_max);  // may lie in the next cache line
        prefetch(minimum.minimum + out.id[thread]);
    });
    block.phase(work.count, [&](std::uint32_t thread) {
        const reference::Ray& ray = rays[out.id[thread]];
        out.origin_x[thread] = ray.origin.x;
        out.origin_y[thread] = ray.origin.y;
        out.origin_z[thread] = ray.origin.z;
        out.inverse_x[thread] = ray.direction.x;
        out.inverse_y[thread] = ray.direction.y;
        out.inverse_z[thread] = ray.direction.z;
        out.t_min[thread] = ray.t_min;
        out.t_max[thread] = ray.t_max;
    });
    block.phase_on_registers(work.count, [&](OwnThread thread) {
        out.inverse_x[thread] = reference::safe_inverse(out.inverse_x[thread]);
        out.inverse_y[thread] = reference::safe_inverse(out.inverse_y[thread]);
        out.inverse_z[thread] = reference::safe_inverse(out.inverse_z[thread]);
    });
    if (minimum.policy == reference::EarlyOut::off) {
        block.phase_on_registers(
            work.count, [&](OwnThread thread) { out.limit[thread] = reference::kInfinity; });
    } else {
        block.phase(work.count, [&](std::uint32_t thread) {
            out.limit[thread] = load_relaxed(minimum.minimum[out.id[thread]]);
        });
    }
}

/// Bit c of children[thread]: the thread's ray enters child c and is not culled.
template <int Width>
void test_children(const Block& block, std::uint32_t count, const reference::WideNode<Width>& node,
                   const BlockRays& rays, PerThread<std::uint32_t>& children) {
    using reference::Vec3;
    PerThread<float> near_x, near_y, near_z, far_x, far_y, far_z;
    const Vec3 node_low(node.low[0], node.low[1], node.low[2]);
    const Vec3 node_high(node.high[0], node.high[1], node.high[2]);
    block.phase_on_registers(count, [&](OwnThread thread) {
        const Vec3 origin(rays.origin_x[thread], rays.origin_y[thread], rays.origin_z[thread]);
        const float pad = reference::box_pad(origin, node_low, node_high);
        near_x[thread] = reference::slab_offset(origin.x, rays.inverse_x[thread], pad);
        near_y[thread] = reference::slab_offset(origin.y, rays.inverse_y[thread], pad);
        near_z[thread] = reference::slab_offset(origin.z, rays.inverse_z[thread], pad);
        far_x[thread] = reference::slab_offset(origin.x, rays.inverse_x[thread], -pad);
        far_y[thread] = reference::slab_offset(origin.y, rays.inverse_y[thread], -pad);
        far_z[thread] = reference::slab_offset(origin.z, rays.inverse_z[thread], -pad);
        children[thread] = 0;
    });
    for (std::uint32_t child = 0; child < Width; ++child) {
        if (node.child[child] == reference::kNone) continue;
        const Vec3 low(node.low_x[child], node.low_y[child], node.low_z[child]);
        const Vec3 high(node.high_x[child], node.high_y[child], node.high_z[child]);
        block.phase_on_registers(count, [&](OwnThread thread) {
            const reference::RaySlabs slabs{
                Vec3(rays.inverse_x[thread], rays.inverse_y[thread], rays.inverse_z[thread]),
                Vec3(near_x[thread], near_y[thread], near_z[thread]),
                Vec3(far_x[thread], far_y[thread], far_z[thread])};
            const reference::BoxInterval interval = reference::clip(
                reference::intersect_box(slabs, low, high), rays.t_min[thread], rays.t_max[thread]);
            const bool entered =
                static_cast<bool>(static_cast<int>(reference::overlaps(interval)) &
                                  static_cast<int>(interval.entry <= rays.limit[thread]));
            children[thread] |= static_cast<std::uint32_t>(entered) << child;
        });
    }
}

/// The 2018 paper's compaction: ranks by exclusive scan in the block, one atomicAdd per child.
template <int Width>
void push_to_children(const Block& block, std::uint32_t count,
                      const reference::WideNode<Width>& node,
                      const PerThread<std::uint32_t>& children, const BlockRays& rays,
                      const LevelView& level) {
    for (std::uint32_t child = 0; child < Width; ++child) {
        if (node.child[child] == reference::kNone) continue;
        Shared<std::uint32_t> compacted("compacted");
        std::uint32_t total = 0;
        block.phase_in_order(count, [&](std::uint32_t thread) {
            compacted[total] = rays.id[thread];
            total += children[thread] >> child & 1u;
        });
        if (total == 0) continue;
        const std::uint32_t target = node.child[child] - level.first_child_node;
        const std::uint32_t begin = level.child_offsets[target];
        const std::uint32_t room = level.child_offsets[target + 1] - begin;
        std::uint32_t base = 0;
        block.phase_thread_zero([&] { base = atomic_add(level.child_counts[target], total); });
        if (base + total > room) {
            atomic_max(*level.overflow, node.child[child] + 1);
            continue;
        }
        std::uint32_t* region = level.child_queue + begin + base;
        block.phase(total, [&](std::uint32_t rank) { region[rank] = compacted[rank]; });
    }
}

/// The shear of each thread's ray, for the triangle test.
struct BlockShear {
    PerThread<std::int32_t> kz;
    PerThread<float> sx, sy, sz;
};

inline void shear_rays(const Block& block, std::uint32_t count, const reference::Ray* rays,
                       const BlockRays& loaded, BlockShear& out) {
    block.phase(count, [&](std::uint32_t thread) {
        const reference::RayShear shear = reference::ray_shear(rays[loaded.id[thread]].direction);
        out.kz[thread] = shear.kz;
        out.sx[thread] = shear.sx;
        out.sy[thread] = shear.sy;
        out.sz[thread] = shear.sz;
    });
}

inline reference::RayShear shear_of(const BlockShear& shear, OwnThread thread) {
    return {shear.kz[thread], shear.sx[thread], shear.sy[thread], shear.sz[thread]};
}

/// Appends a leaf's hit to those that the ray has gathered, and lowers its minimum.
inline void record_hit(std::uint32_t ray_id, const reference::HitCandidate& hit,
                       const HitView& hits, const MinimumView& minimum) {
    if (hits.mode == reference::HitMode::packed) {
        atomic_min(hits.packed[ray_id],
                   std::uint64_t{std::bit_cast<std::uint32_t>(hit.t)} << 32 | hit.primitive);
    } else {
        const std::uint32_t slot = atomic_add(hits.counts[ray_id], 1);
        if (slot < hits.capacity) {
            hits.candidates[std::size_t{ray_id} * hits.capacity + slot] = hit;
        } else {
            atomic_max(*hits.needed, slot + 1);  // the host then grows it and retries
        }
    }
    if (minimum.policy != reference::EarlyOut::off) {
        atomic_min_distance(minimum.lowered[ray_id], minimum.any_hit ? kDone : hit.t);
    }
}

/// Asks for what record_hit() writes.
inline void prefetch_record(std::uint32_t ray_id, const HitView& hits, const MinimumView& minimum) {
    if (hits.mode == reference::HitMode::packed) {
        prefetch(hits.packed + ray_id);
    } else {
        prefetch(hits.counts + ray_id);
        prefetch(hits.candidates + std::size_t{ray_id} * hits.capacity);
    }
    prefetch(minimum.lowered + ray_id);
}

/// Triangles that a block holds in shared memory at once; larger leaves take several loads.
constexpr std::uint32_t kLeafChunk = 64;

/// Without a branch, so that loops over threads vectorise.
inline bool both(bool a, bool b) {
    return static_cast<bool>(static_cast<int>(a) & static_cast<int>(b));
}

/// Each thread's closest hit in a leaf. The functions below are no lambdas in intersect_leaf(): a
/// closure keeps the registers' addresses, and the checked build then watches every access to them.
struct BlockHits {
    PerThread<float> t;
    PerThread<std::uint32_t> primitive;
};

inline void keep_nearer(OwnThread thread, std::uint32_t primitive, float t, bool hit,
                        const BlockRays& rays, BlockHits& best) {
    const bool in_range = both(rays.t_min[thread] <= t, t < rays.t_max[thread]);
    const bool closer = reference::closer(t, primitive, best.t[thread], best.primitive[thread]);
    const bool nearer = both(both(hit, in_range), closer);
    best.t[thread] = nearer ? t : best.t[thread];
    best.primitive[thread] = nearer ? primitive : best.primitive[thread];
}

inline reference::Vec3 origin_of(const BlockRays& rays, OwnThread thread) {
    return {rays.origin_x[thread], rays.origin_y[thread], rays.origin_z[thread]};
}

inline reference::Vec3 inverse_of(const BlockRays& rays, OwnThread thread) {
    return {rays.inverse_x[thread], rays.inverse_y[thread], rays.inverse_z[thread]};
}

inline bool is_nearest(const BlockHits& best, const BlockRays& rays, std::uint32_t thread) {
    return best.primitive[thread] != reference::kNone && best.t[thread] <= rays.limit[thread];
}

/// Finds the closest hit of each ray of the block in one leaf.
inline void intersect_leaf(const Block& block, std::uint32_t count, const reference::Leaf& leaf,
                           const reference::LeafTriangle* triangles, const reference::Ray* rays,
                           const BlockRays& loaded, const HitView& hits,
                           const MinimumView& minimum) {
    using reference::Vec3;
    BlockShear shear;
    BlockHits best;
    PerThread<std::uint32_t> on_edge;
    shear_rays(block, count, rays, loaded, shear);
    block.phase_on_registers(count, [&](OwnThread thread) {
        best.t[thread] = reference::kInfinity;
        best.primitive[thread] = reference::kNone;
    });
    reference::LeafTriangle shared[kLeafChunk];
    for (std::uint32_t done = 0; done < leaf.count; done += kLeafChunk) {
        const std::uint32_t chunk = std::min(kLeafChunk, leaf.count - done);
        std::copy_n(triangles + leaf.first + done, chunk, shared);
        for (std::uint32_t i = 0; i < chunk; ++i) {
            const reference::LeafTriangle triangle = shared[i];
            const Vec3 low =
                reference::min_number(reference::min_number(triangle.v0, triangle.v1), triangle.v2);
            const Vec3 high =
                reference::max_number(reference::max_number(triangle.v0, triangle.v1), triangle.v2);
            // The steps of intersect_triangle_line(), for all threads at once and without a branch.
            block.phase_on_registers(count, [&](OwnThread thread) {
                const Vec3 origin = origin_of(loaded, thread);
                const reference::RayShear ray = shear_of(shear, thread);
                const Vec3 a = reference::swap_axes(triangle.v0 - origin, ray.kz);
                const Vec3 b = reference::swap_axes(triangle.v1 - origin, ray.kz);
                const Vec3 c = reference::swap_axes(triangle.v2 - origin, ray.kz);
                const reference::EdgeFunctions e =
                    reference::edge_functions(reference::shear(ray, a, b, c));
                on_edge[thread] = static_cast<std::uint32_t>(reference::may_be_zero(e));
                const reference::Crossing crossing = reference::crossing_of(ray, e, a, b, c);
                const reference::CutDistance cut = reference::cut_distance(
                    crossing.t, origin, inverse_of(loaded, thread), low, high);
                const bool inside = both(on_edge[thread] == 0, !reference::signs_differ(e));
                const bool crosses = both(inside, reference::abs_of(crossing.determinant) > 0.0f);
                keep_nearer(thread, triangle.primitive, cut.t, both(crosses, cut.inside), loaded,
                            best);
            });
            // Few lines meet an edge: the signs are those of exact arithmetic there.
            if (block.count(count, [&](std::uint32_t thread) { return on_edge[thread] != 0; }) ==
                0) {
                continue;
            }
            block.phase_on_registers(count, [&](OwnThread thread) {
                if (on_edge[thread] == 0) return;
                reference::Hit hit = reference::no_hit();
                const bool crosses = reference::intersect_triangle_line(
                    origin_of(loaded, thread), inverse_of(loaded, thread), shear_of(shear, thread),
                    triangle.v0, triangle.v1, triangle.v2, hit);
                keep_nearer(thread, triangle.primitive, hit.t, crosses, loaded, best);
            });
        }
    }
    block.phase(count, [&](std::uint32_t thread) {
        if (is_nearest(best, loaded, thread)) prefetch_record(loaded.id[thread], hits, minimum);
    });
    block.phase(count, [&](std::uint32_t thread) {
        if (is_nearest(best, loaded, thread)) {
            record_hit(loaded.id[thread], {best.t[thread], best.primitive[thread]}, hits, minimum);
        }
    });
}

/// Common to both level kernels: finds the block's rays, intersects a leaf with them, or hands them
/// to `visit(inner, work, rays)`. `grid_side`: 0 for linear block order, else the side of the 2-D
/// grid.
template <int Width, class Visit>
void visit_queue(const Block& block, const reference::WideBvhView<Width>& bvh,
                 const reference::Ray* rays, const LevelView& level, const HitView& hits,
                 const MinimumView& minimum, std::uint32_t grid_side, const Visit& visit) {
    const BlockWork work = find_work(block, level, grid_side);
    if (work.node == reference::kNone) return;
    const std::uint32_t node_ref = bvh.node_refs[level.first_node + work.node];
    BlockRays loaded;
    load_rays(block, work, rays, level, minimum, loaded);
    if (reference::is_leaf(node_ref)) {
        intersect_leaf(block, work.count, bvh.leaves[reference::ref_index(node_ref)], bvh.triangles,
                       rays, loaded, hits, minimum);
    } else {
        visit(reference::ref_index(node_ref), work, loaded);
    }
}

/// The level kernel.
template <int Width>
void intersect(const Block& block, const reference::WideBvhView<Width>& bvh,
               const reference::Ray* rays, const LevelView& level, const HitView& hits,
               const MinimumView& minimum, std::uint32_t grid_side) {
    visit_queue(block, bvh, rays, level, hits, minimum, grid_side,
                [&](std::uint32_t inner, const BlockWork& work, const BlockRays& loaded) {
                    const reference::WideNode<Width> node = bvh.inner[inner];
                    PerThread<std::uint32_t> children;
                    test_children(block, work.count, node, loaded, children);
                    push_to_children(block, work.count, node, children, loaded, level);
                });
}

}  // namespace scotty::emulation
