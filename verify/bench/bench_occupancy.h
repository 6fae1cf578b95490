/// What the queues of a render did with their blocks and bytes: figures that need no profiler.
///
/// All are counted, none is sampled, in one render that is watched and not timed. Under early-out
/// `off` and `level` they are the same on every back end, since the contract fixes every queue
/// (docs/design.md); under `immediate` they are those of the one schedule that ran.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::verify {

/// Bytes that the kernels of a traversal ask for, as if no cache served any of them twice.
///
///     queues     4 an entry read (but at the root, whose queue is 0..n-1), 4 an entry written
///     rays       32 an entry; with an early-out 4 more, for the minimum
///     nodes      of each block: 4, and the node's record, or a leaf's 8. Below the queues, of each
///                ray: 24, the planes of each node that it enters, and 4 a child gone on to or put
///                aside
///     triangles  40 each: of a leaf's block all that the leaf has; below the queues of each ray
///     hits       a hit found: 8 written, 8 for its count, with an early-out 8 for the minimum, and
///                8 read when merged; a ray merged: 20, and 80 more (ray, indices, vertices) where
///                it hit; under early-out `level` 8 a ray and level to publish the minimum
///
/// Counters, scans and the search for a block's node, a few bytes a block, are left out.
struct Traffic {
    std::uint64_t queues = 0, rays = 0, nodes = 0, triangles = 0, hits = 0;

    std::uint64_t total() const { return queues + rays + nodes + triangles + hits; }
};

/// Counts of some launches of level kernels: those of a kind of rays, or of a level. A *visit* is
/// an entry of a node's queue: one ray in one block. Dead rays visit the root and nothing else.
struct TraversalCounts {
    std::string name;                 ///< "primary", "bounce N", "shadow"; "level N"; "all"
    std::uint64_t rays = 0;           ///< living ones that were traced; of a level: that reached it
    std::uint64_t dead = 0;           ///< visits of dead rays
    std::uint64_t visits = 0;         ///< of living rays
    std::uint64_t blocks = 0;         ///< that have entries, dead rays' included
    std::uint64_t warps = 0;          ///< of 32 threads, that have entries
    std::vector<std::uint64_t> fill;  ///< blocks by entries, [rays per block + 1]
    std::uint64_t redundant = 0;      ///< visits whose node is entered beyond the ray's final hit
    std::uint64_t visits_uncut = 0;   ///< visits with early-out off
    std::uint64_t leaf_hits = 0;      ///< (ray, leaf) pairs with a hit that was recorded
    std::uint64_t hits = 0;  ///< rays that hit something: of leaf_hits, those needed; levels: 0
    std::uint64_t box_tests =
        0;  ///< ray against child box; below the queues of missing children too
    std::uint64_t triangle_tests = 0;  ///< ray against triangle
    Traffic traffic;                   ///< of a level without the merge

    std::uint64_t lanes() const { return visits + dead; }
    void add(const TraversalCounts& other);
    /// The least number of entries that this part of the blocks does not exceed: 0.5 gives the
    /// median. 0 where there are no blocks.
    std::uint32_t fill_quantile(double part) const;
};

/// The row of that name, made where there is none.
TraversalCounts& row_of(std::vector<TraversalCounts>& rows, const std::string& name);

struct Occupancy {
    reference::PipelineParameters parameters;
    std::vector<TraversalCounts> kinds;   ///< in the order in which they first ran
    std::vector<TraversalCounts> levels;  ///< from the root
    TraversalCounts all;                  ///< sum of the kinds
    std::uint64_t rays_in_flight = 0;     ///< of the largest batch
    std::uint64_t device_bytes = 0;       ///< in the emulator's buffers
    std::uint64_t bvh_bytes = 0;          ///< nodes, leaves and triangles, once
    std::uint64_t triangle_bytes = 0;     ///< of them, in leaf order
};

/// Renders twice with the emulator, once as configured and, where that has an early-out, once with
/// it off. Hits are buffered whatever the hit mode, which changes no queue.
Occupancy count_occupancy(const reference::Scene& scene, const reference::WideBvh& bvh,
                          const reference::PipelineParameters& parameters, std::size_t threads,
                          const std::function<void(const std::string&)>& progress = {});

/// Two tables: by kind of ray, and by level.
std::string table(const Occupancy& occupancy);
nlohmann::json to_json(const Occupancy& occupancy);

}  // namespace scotty::verify
