/// What shading and filters give, recomputed: seen to fail, at the right stage and ray.
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "tests/verify/spheres_run.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using verify::Failure;
using verify::test::small_parameters;

struct Run : verify::test::SpheresRun {
    using SpheresRun::SpheresRun;

    std::vector<Failure> failures(bool recompute = true) const {
        verify::InvariantSettings settings;
        settings.recompute_shading = recompute;
        return check(settings);
    }
};

void one_ulp_up(float& value) {
    value = std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) + 1);
}

}  // namespace

TEST_CASE("shading: a camera ray that is a unit in the last place off is found",
          "[verify][invariants]") {
    Run run(small_parameters());
    CHECK(run.failures().empty());
    one_ulp_up(run.stages.at("primary_rays").output<Ray>("rays")[7].direction.x);
    CHECK(run.failures(false).front().invariant != verify::invariant::kShading);
    const Failure failure = run.failures().front();
    CHECK(failure.invariant == verify::invariant::kShading);
    CHECK(failure.stage == "primary_rays");
    CHECK(failure.ray == 7);
    CHECK(failure.field == "rays[7]");
}

TEST_CASE("shading: potential radiance that is not the light's is found", "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce1/light0/direct_light_rays");
    const auto shadow = stage.output<Ray>("shadow_rays");
    std::size_t ray = 0;
    while (is_dead(shadow[ray])) ++ray;
    one_ulp_up(stage.output<Vec3>("potential")[ray].x);
    const Failure failure = run.failures().front();
    CHECK(failure.invariant == verify::invariant::kShading);
    CHECK(failure.stage == "bounce1/light0/direct_light_rays");
    CHECK(failure.ray == ray);
    CHECK(failure.field == "potential[" + std::to_string(ray) + "]");
}

TEST_CASE("shading: a path that carries on too much is found", "[verify][invariants]") {
    Run run(small_parameters());
    auto& stage = run.stages.at("bounce0/scene_rays");
    const auto rays = stage.output<Ray>("rays");
    std::size_t ray = 0;
    while (is_dead(rays[ray])) ++ray;
    one_ulp_up(stage.output<Vec3>("throughput")[ray].y);
    const Failure failure = run.failures().front();
    CHECK(failure.invariant == verify::invariant::kShading);
    CHECK(failure.stage == "bounce0/scene_rays");
    CHECK(failure.ray == ray);
}

TEST_CASE("filter: a pixel that a filter does not give is found, by each of them",
          "[verify][invariants]") {
    for (const Filter filter : {Filter::gaussian, Filter::bilateral, Filter::median}) {
        PipelineParameters p = small_parameters();
        p.filter = filter;
        Run run(p);
        CAPTURE(to_string(filter));
        CHECK(run.failures().empty());
        auto& stage = run.stages.at(std::string("filter_") + to_string(filter));
        stage.output<Vec3>("filtered")[p.image_width + 2].z += 0.01f;
        const auto failures = run.failures();
        REQUIRE(failures.size() == 1);
        CHECK(failures.front().invariant == verify::invariant::kFilter);
        CHECK(failures.front().stage == stage.view.name);
        CHECK(failures.front().field ==
              "filtered[" + std::to_string(p.image_width + 2) + "] (x 2, y 1), channel 2");
    }
}
