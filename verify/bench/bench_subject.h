/// What a benchmark of renders measures, and how often: said at the head of every one.
#pragma once

#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"

namespace scotty::verify {

struct BenchSettings {
    reference::PipelineParameters parameters;
    std::size_t threads = 0;  ///< of the CPU; 0: all
    int warm_ups = 1;         ///< rounds that do not count
    int repeats = 3;          ///< rounds that do; the median counts
    std::string peers;        ///< folder of other tracers' programs (bench_peers.h); empty: none
    std::function<void(const std::string&)> progress;
};

struct BenchSubject {
    std::string scene;
    std::uint64_t triangles = 0;
    reference::PipelineParameters parameters;
    std::size_t threads = 0;
    int warm_ups = 0, repeats = 0;
};
BenchSubject subject_of(const reference::Scene& scene, const BenchSettings& settings);
/// Two lines and an empty one, which begin a table.
std::string heading(const BenchSubject& subject);
nlohmann::json subject_json(const BenchSubject& subject);

}  // namespace scotty::verify
