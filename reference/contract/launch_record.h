/// What a pipeline notes about each launch, and what a traversal asks; the same for all back ends.
#pragma once

#include <cstdint>

#include "reference/contract/stage_observer.h"

namespace scotty::reference {

enum class TraversalKind {
    closest,  ///< the nearest hit
    any       ///< whether there is a hit: under an early-out only is_hit() is meaningful
};

/// One kernel launch as it was run: what `scotty bench` adds up.
struct LaunchRecord {
    StageKind kind = StageKind::primary_rays;
    std::uint32_t batch = 0;
    std::uint32_t bounce = kNotApplicable;
    std::uint32_t light = kNotApplicable;
    std::uint32_t level = kNotApplicable;
    std::uint32_t blocks = 0;
    std::uint64_t items = 0;  ///< threads with work: rays, or queue entries of a level; 0: unknown
    double seconds = 0.0;
};

/// Where in the render a stage stands.
struct StagePlace {
    std::uint32_t batch = 0;
    bool several_batches = false;
    std::uint32_t bounce = kNotApplicable;  ///< not applicable: rays from elsewhere
    std::uint32_t light = kNotApplicable;
    std::uint32_t level = kNotApplicable;

    StagePlace at_level(std::uint32_t l) const {
        StagePlace place = *this;
        place.level = l;
        return place;
    }
    std::string name(StageKind kind) const {
        return stage_name(kind, batch, bounce, light, level, several_batches);
    }
};

}  // namespace scotty::reference
