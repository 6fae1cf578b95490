/// How fast a back end is, and how fast Embree is on the same rays: `scotty bench emulator`, `cuda`
/// and `embree`.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "verify/bench/bench_occupancy.h"
#include "verify/bench/bench_parts.h"
#include "verify/bench/bench_rays.h"
#include "verify/bench/bench_subject.h"
#include "verify/bench/measure.h"

namespace scotty::verify {

struct BenchReport : BenchSubject {
    TracedRays rays;
    MeasuredRenders renders;  ///< whole renders of the back end, nobody watching
    Spread embree_render{};   ///< seconds of the same paths in a plain loop through Embree
    BenchParts parts;         ///< of the median render
    Occupancy occupancy;
};

/// Whole renders, then rays by kind (trace_by_turns()), then the counts. `backend`: "emulator" or
/// "cuda". Throws as measure_renders().
BenchReport bench_backend(const reference::Scene& scene, const BenchSettings& settings,
                          const std::string& backend);

std::string table(const BenchReport& report);
/// Key "ratio_to_embree": back end over Embree, rays a second, all rays of the render together.
nlohmann::json to_json(const BenchReport& report);

/// Embree alone, single rays.
struct EmbreeBenchReport : BenchSubject {
    TracedRays rays;
    Spread render{};  ///< seconds of a render in a plain loop
};
EmbreeBenchReport bench_embree(const reference::Scene& scene, const BenchSettings& settings);

std::string table(const EmbreeBenchReport& report);
nlohmann::json to_json(const EmbreeBenchReport& report);

}  // namespace scotty::verify
