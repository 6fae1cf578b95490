/// How fast the emulator is, and how fast Embree is on the same rays, threads and machine.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "emulation/pipeline.h"
#include "reference/pipeline_parameters.h"
#include "reference/scene.h"

namespace scotty::verify {

struct BenchSettings {
    reference::PipelineParameters parameters;
    std::size_t threads = 0;
    int warm_ups = 1;
    int repeats = 3;  ///< the median counts
    std::function<void(const std::string&)> progress;
};

/// Rays of one kind: living ones of all traversals, traced together.
struct BenchRays {
    std::string kind;  ///< "primary", "bounce 1", "shadow"
    std::uint64_t rays = 0;
    double emulator_seconds = 0.0;
    double embree_seconds = 0.0;

    double emulator_rate() const { return static_cast<double>(rays) / emulator_seconds; }
    double embree_rate() const { return static_cast<double>(rays) / embree_seconds; }
    double ratio() const { return embree_seconds / emulator_seconds; }
};

/// Time of one part of a render: a stage kind, or a level of all traversals.
struct BenchPart {
    std::string name;
    double seconds = 0.0;
    std::uint64_t launches = 0;
    std::uint64_t blocks = 0;
    std::uint64_t items = 0;  ///< rays, or queue entries
};

/// What was measured, in every benchmark of renders.
struct BenchSubject {
    std::string scene;
    std::uint64_t triangles = 0;
    reference::PipelineParameters parameters;
    std::size_t threads = 0;
    int repeats = 0;
};
BenchSubject subject_of(const reference::Scene& scene, const BenchSettings& settings);
/// Two lines and an empty one, which begin a table.
std::string heading(const BenchSubject& subject);
nlohmann::json subject_json(const BenchSubject& subject);

struct BenchReport : BenchSubject {
    std::vector<BenchRays> kinds;
    BenchRays all;
    double render_seconds = 0.0;         ///< a whole render of the emulator, nobody watching
    double embree_render_seconds = 0.0;  ///< the same paths in a plain loop through Embree
    std::vector<BenchPart> stages;       ///< of that render, the slowest first
    std::vector<BenchPart> levels;       ///< its scans and intersections by level
    std::size_t device_bytes = 0;
};

/// Renders once to collect the rays of every traversal, then times both tracers on them, kind by
/// kind, taking turns so that neither has the cooler machine.
BenchReport bench_emulator(const reference::Scene& scene, const BenchSettings& settings);

/// The middle of the values (the lower middle of an even number); at least one value.
double median(std::vector<double> values);

std::string table(const BenchReport& report);
/// Key "ratio_to_embree": emulator over Embree, rays a second, all rays of the render together.
nlohmann::json to_json(const BenchReport& report);

}  // namespace scotty::verify
