/// What building a scene's tree takes, and what it gains: for `scotty info --tree`.
#pragma once

#include <cstddef>

#include "reference/contract/scene.h"

namespace scotty::reference {

struct TreeFigures {
    double seconds_built = 0.0;      ///< the binary BVH by Embree's builder
    double seconds_optimised = 0.0;  ///< reinsertion
    double cost_built = 0.0;         ///< surface_area_cost() of either
    double cost_optimised = 0.0;
};

/// Builds as build_wide_bvh() does, up to compaction. `threads` 0: all. Throws bad_input for a
/// scene without triangles.
TreeFigures measure_tree(const Scene& scene, std::size_t threads);

}  // namespace scotty::reference
