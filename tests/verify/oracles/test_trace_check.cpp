/// Rays from elsewhere: a right tracer passes, and each way to be wrong is found.
#include <cmath>
#include <set>

#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "reference/truth/tracers.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/oracles/trace_check.h"

using namespace scotty;
using namespace scotty::reference;
using verify::check_traces;
using verify::test::small_parameters;

namespace {

struct TraceRun {
    TraceRun() {
        const PipelineParameters p = small_parameters();
        const WideBvh bvh = build_wide_bvh(scene, {p.width, p.max_leaf_size, 0});
        verify::Recorder recorder(p, recording);
        emulation::Pipeline(scene, bvh, p, {}, &recorder).render();
    }
    /// What the check finds where brute force's hits are changed before it sees them.
    template <class Change>
    std::vector<verify::Failure> with(const Change& change, bool any_is_closest = true) const {
        verify::TraceCheckSettings settings;
        settings.any_is_closest = any_is_closest;
        return check_traces(
            scene, recording,
            [&](std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) {
                brute_force_closest(scene, rays, hits);
                for (std::size_t i = 0; i < rays.size(); ++i) change(rays[i], kind, hits[i], i);
            },
            settings);
    }
    Scene scene = scenes::load_scene("cornell");
    verify::Recording recording;
};

}  // namespace

TEST_CASE(
    "trace check: brute force passes, and dead rays, finite and empty intervals, axes are asked",
    "[verify][trace-check]") {
    const TraceRun run;
    std::size_t dead = 0;
    std::size_t finite = 0;
    std::size_t empty = 0;
    std::size_t along_axis = 0;
    std::set<TraversalKind> kinds;
    const auto failures =
        run.with([&](const Ray& ray, TraversalKind kind, const Hit&, std::size_t) {
            kinds.insert(kind);
            dead += is_dead(ray) ? 1 : 0;
            finite += !is_dead(ray) && std::isfinite(ray.t_max) ? 1 : 0;
            empty += ray.t_min == ray.t_max ? 1 : 0;
            along_axis += ray.direction.x == 0.0f && ray.direction.y == 0.0f ? 1 : 0;
        });
    CHECK(failures.empty());
    CHECK(kinds.size() == 2);
    CHECK(dead > 10);
    CHECK(finite > 30);
    CHECK(empty > 10);
    CHECK(along_axis > 4);
}

TEST_CASE(
    "trace check: what is wrong for one ray in a hundred, for one kind of query or for the "
    "dead alone is found",
    "[verify][trace-check]") {
    const TraceRun run;
    SECTION("a hit a unit in the last place off") {
        const auto failures = run.with([](const Ray&, TraversalKind kind, Hit& hit, std::size_t i) {
            if (kind == TraversalKind::closest && i % 100 == 99) {
                hit.t = std::nextafter(hit.t, 0.0f);
            }
        });
        REQUIRE_FALSE(failures.empty());
        CHECK(failures.front().invariant == "brute-force");
        CHECK(failures.front().ray % 100 == 99);
    }
    SECTION("a dead ray's record is not no_hit()") {
        const auto failures = run.with([](const Ray& ray, TraversalKind, Hit& hit, std::size_t) {
            if (is_dead(ray)) hit.v = 0.5f;
        });
        CHECK(failures.size() == 3);  // closest, as recorded, any
    }
    SECTION("an any-hit search that finds something farther") {
        const auto spoil = [](const Ray&, TraversalKind kind, Hit& hit, std::size_t) {
            if (kind == TraversalKind::any && is_hit(hit)) hit.primitive ^= 1u;
        };
        CHECK(run.with(spoil).size() == 1);
        CHECK(run.with(spoil, false).empty());  // where any hit will do
    }
    SECTION("a search that finds nothing") {
        const auto failures = run.with(
            [](const Ray&, TraversalKind kind, Hit& hit, std::size_t i) {
                if (kind == TraversalKind::any && i == 7) hit = is_hit(hit) ? no_hit() : Hit{};
            },
            false);
        CHECK(failures.size() == 1);
    }
    SECTION("the last of its rays is left out") {
        std::size_t last = 0;
        run.with([&](const Ray&, TraversalKind, const Hit&, std::size_t i) { last = i; });
        const auto failures = run.with([&](const Ray&, TraversalKind, Hit& hit, std::size_t i) {
            if (i == last) hit.u += 1.0f;
        });
        CHECK(failures.size() >= 2);
    }
}

TEST_CASE("trace check: a recorded hit that is another than the unwatched one is found",
          "[verify][trace-check]") {
    TraceRun run;
    for (auto& traversal : run.recording.traversals) {
        for (Hit& hit : traversal.hits) hit.u += 0.125f;
    }
    const auto failures = run.with([](const Ray&, TraversalKind, const Hit&, std::size_t) {});
    REQUIRE(failures.size() == 1);
    CHECK(failures.front().invariant == verify::invariant::kUnwatched);
}
