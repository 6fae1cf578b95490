/// Rays per second by kind: a back end and Embree on the same rays.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "reference/contract/wide_bvh.h"
#include "reference/truth/tracers.h"
#include "verify/bench/bench_peers.h"
#include "verify/bench/bench_subject.h"
#include "verify/bench/measure.h"

namespace scotty::verify {

/// Rays of one kind: living ones of all traversals of a render, traced together.
struct BenchRays {
    std::string kind;  ///< "primary", "bounce 1", "shadow"; "all": the kinds added up
    std::uint64_t rays = 0;
    Spread ours{};    ///< seconds of the back end; 0 where Embree is measured alone
    Spread embree{};  ///< seconds of Embree, single rays

    double our_rate() const { return static_cast<double>(rays) / ours.median; }
    double embree_rate() const { return static_cast<double>(rays) / embree.median; }
    double ratio() const { return embree.median / ours.median; }
};

struct TracedRays {
    std::string backend;  ///< empty: Embree alone
    std::vector<BenchRays> kinds;
    BenchRays all;
    std::vector<Peer> peers;  ///< in BenchSettings::peers, on the same kinds
};

/// Renders once with the emulator to collect the rays, then times both tracers on them, kind by
/// kind, taking turns so that neither has the cooler machine. emulator and simt: by the clock, from
/// rays to hits. cuda: by device events around traversals whose rays lie on the device, in batches
/// of parameters.batch_rays; copies are not in it. Embree uses the CPU's threads in every case. The
/// peers follow, kind by kind. Throws as PeerRuns.
TracedRays trace_by_turns(const reference::Scene& scene, const reference::WideBvh& bvh,
                          const reference::EmbreeTracer& embree, const BenchSettings& settings,
                          const std::string& backend);

std::string table(const TracedRays& rays);
/// Keys rays, all_rays and, where there are such, ratio_to_embree and peers.
nlohmann::json to_json(const TracedRays& rays);

}  // namespace scotty::verify
