/// What it costs to run the CUDA text on a CPU, thread by thread, beside the emulator's own
/// kernels.
#pragma once

#include "verify/bench/bench_occupancy.h"
#include "verify/bench/bench_parts.h"
#include "verify/bench/bench_rays.h"
#include "verify/bench/bench_subject.h"
#include "verify/bench/measure.h"

namespace scotty::verify {

struct SimtBenchPart {
    std::string name;
    double emulator_seconds = 0.0;
    double simt_seconds = 0.0;

    double ratio() const { return simt_seconds / emulator_seconds; }
};

/// Both are timed launch by launch; the parts are of each one's median render.
struct SimtBenchReport : BenchSubject {
    SimtBenchPart render;               ///< a whole render, nobody watching
    Spread emulator{}, simt{};          ///< seconds of those renders
    std::vector<SimtBenchPart> stages;  ///< by kind, the slowest first
    TracedRays rays;                    ///< of simt, beside Embree
    BenchParts parts;                   ///< of simt's median render
    Occupancy occupancy;
};

/// Renders of one back end: how long each took, and its launches.
struct TimedRender {
    double seconds = 0.0;
    std::vector<reference::LaunchRecord> launches;
};
struct RendersByTurns {
    std::vector<TimedRender> emulator, simt;  ///< one a round; warm-ups are left out
};
/// Both render the same, one after the other, round after round. Throws internal where the two
/// pictures differ in a bit.
RendersByTurns render_by_turns(const reference::Scene& scene, const BenchSettings& settings);

/// Renders with both by turns: the same scene, parameters, threads and machine.
/// Throws internal where their pictures differ in a bit.
SimtBenchReport bench_simt(const reference::Scene& scene, const BenchSettings& settings);

std::string table(const SimtBenchReport& report);
/// Key "ratio_to_emulator": seconds of the executor over the emulator's, whole renders.
nlohmann::json to_json(const SimtBenchReport& report);

}  // namespace scotty::verify
