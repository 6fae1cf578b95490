/// Rays that end or start where they hit: a closed interval is seen, and so is an open one.
#include <cmath>

#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "reference/truth/tracers.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/oracles/interval_check.h"

using namespace scotty;
using namespace scotty::reference;
using verify::check_intervals;
using verify::test::small_parameters;

namespace {

constexpr std::uint64_t kTests = 20'000'000;

struct Run {
    Run() {
        const PipelineParameters p = small_parameters();
        const WideBvh bvh = build_wide_bvh(scene, {p.width, p.max_leaf_size, 0});
        verify::Recorder recorder(p, recording);
        emulation::Pipeline(scene, bvh, p, {}, &recorder).render();
    }
    Scene scene = scenes::load_scene("cornell");
    verify::Recording recording;
};

}  // namespace

TEST_CASE("intervals: half-open ones pass, and every ray is traced twice", "[verify][intervals]") {
    const Run run;
    std::size_t rays = 0;
    std::size_t hits = 0;
    const auto failures = check_intervals(
        run.scene, run.recording,
        [&](std::span<const Ray> some, std::span<Hit> out) {
            brute_force_closest(run.scene, some, out);
            rays += some.size();
            for (const Hit& hit : out) hits += is_hit(hit) ? 1 : 0;
        },
        kTests);
    CHECK(failures.empty());
    CHECK(rays > 100);
    CHECK(hits >= rays / 2);  // all that start where they hit
}

TEST_CASE("intervals: a hit at t_max that counts is found", "[verify][intervals]") {
    const Run run;
    const auto failures = check_intervals(
        run.scene, run.recording,
        [&](std::span<const Ray> some, std::span<Hit> out) {
            std::vector<Ray> longer(some.begin(), some.end());
            for (Ray& ray : longer) ray.t_max = std::nextafter(ray.t_max, kInfinity);
            brute_force_closest(run.scene, longer, out);
        },
        kTests);
    REQUIRE(failures.size() == 1);
    CHECK(failures[0].invariant == "brute-force");
    CHECK(failures[0].sentence.find("ends where it hit") != std::string::npos);
}

TEST_CASE("intervals: a hit at t_min that does not count is found", "[verify][intervals]") {
    const Run run;
    const auto failures = check_intervals(
        run.scene, run.recording,
        [&](std::span<const Ray> some, std::span<Hit> out) {
            std::vector<Ray> later(some.begin(), some.end());
            for (Ray& ray : later) {
                if (ray.t_min > 0.0f) ray.t_min = std::nextafter(ray.t_min, kInfinity);
            }
            brute_force_closest(run.scene, later, out);
        },
        kTests);
    REQUIRE(failures.size() == 1);
    CHECK(failures[0].sentence.find("starts where it hit") != std::string::npos);
}
