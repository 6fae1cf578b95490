/// The oracles are seen to fail on hits that were spoiled.
#include <string>

#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "reference/truth/tracers.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/small_parameters.h"
#include "verify/capture/recording.h"
#include "verify/oracles/hit_check.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using verify::check_hits;
using verify::check_image;
using verify::HitCheckResult;
using verify::Recording;

PipelineParameters tiny() {
    PipelineParameters p = scotty::test::small_picture(17, 9, 2);
    p.early_out = EarlyOut::off;
    p.shadow_query = ShadowQuery::closest;
    return p;
}

const Scene& spheres() {
    static const Scene scene = scenes::load_scene("spheres");
    return scene;
}

const EmbreeTracer& embree() {
    static const EmbreeTracer tracer(spheres());
    return tracer;
}

Recording record(const PipelineParameters& p) {
    const WideBvh bvh = build_wide_bvh(spheres(), bvh_parameters(p, 0));
    Recording recording;
    verify::Recorder recorder(p, recording);
    recording.image = emulation::Pipeline(spheres(), bvh, p, {}, &recorder).render();
    return recording;
}

/// The first path whose ray hits something; fails the test where none does.
std::uint32_t first_hit(const std::vector<Hit>& hits) {
    for (std::uint32_t i = 0; i < hits.size(); ++i) {
        if (is_hit(hits[i])) return i;
    }
    FAIL("no ray hits anything");
    return 0;
}

TEST_CASE("recording: paths are found by pixel and sample, whatever batch they ran in",
          "[verify][recording]") {
    PipelineParameters p = tiny();
    const Recording whole = record(p);
    CHECK(whole.traversals.size() == 4);
    CHECK(whole.traversals[0].rays.size() == 17u * 9 * 2);
    CHECK(whole.traversals[1].stage() == "bounce0/light0/merge_intersections");
    CHECK(whole.living_rays() > 17u * 9 * 2);
    for (const std::uint32_t batch : {1u, 7u, 100u}) {
        p.batch_rays = batch;
        CHECK(compare(whole, record(p), false, p.spp).empty());
    }
}

TEST_CASE("recording: a ray, a hit, a radiance and a pixel that differ are each found",
          "[verify][recording]") {
    const PipelineParameters p = tiny();
    const Recording whole = record(p);
    Recording other = whole;
    std::string stage = "bounce0/merge_intersections";
    std::string field;
    SECTION("ray") {
        other.traversals[0].rays[11].origin.x += 1e-6f;
        field = "rays";
    }
    SECTION("hit") {
        other.traversals[0].hits[11].u += 1e-6f;
        field = "merged";
    }
    SECTION("radiance") {
        other.radiance[11].y += 1e-6f;
        stage = "reconstruct_image";
        field = "radiance";
    }
    SECTION("pixel") {
        other.image.pixels[5].y += 1e-6f;
        stage = "reconstruct_image";
        field = "image[5]";
    }
    const auto failures = compare(whole, other, false, p.spp);
    REQUIRE(failures.size() == 1);
    CHECK(failures[0].stage == stage);
    CHECK(failures[0].field == field);
    CHECK(failures[0].ray == (field == "image[5]" ? 10u : 11u));
    CHECK(failures[0].sentence.find("pixel 5, sample") != std::string::npos);
}

TEST_CASE("recording: a traversal that is missing is found", "[verify][recording]") {
    const PipelineParameters p = tiny();
    const Recording whole = record(p);
    Recording other = whole;
    other.traversals.erase(other.traversals.begin() + 2);
    CHECK_FALSE(compare(whole, other, false, p.spp).empty());
    CHECK_FALSE(compare(other, whole, false, p.spp).empty());
}

TEST_CASE("recording: where any hit will do, which one is free, but not whether",
          "[verify][recording]") {
    const PipelineParameters p = tiny();
    const Recording whole = record(p);
    Recording other = whole;
    auto& hits = other.traversals[1].hits;
    const std::uint32_t hit = first_hit(hits);
    hits[hit].primitive ^= 1;
    CHECK(compare(whole, other, true, p.spp).empty());
    CHECK(compare(whole, other, false, p.spp).size() == 1);
    hits[hit] = no_hit();
    CHECK(compare(whole, other, true, p.spp).size() == 1);
}

TEST_CASE("oracles: what the pipeline finds passes, and every ray is checked", "[verify][oracle]") {
    const PipelineParameters p = tiny();
    const Recording recording = record(p);
    const HitCheckResult result = check_hits(spheres(), recording, embree(), p.spp, {});
    CHECK(result.failures.empty());
    CHECK(result.ours_wrong == 0);
    CHECK(result.traversals == 4);
    CHECK(result.rays == recording.living_rays());
    CHECK(result.brute_force_rays == result.rays);
    CHECK(result.embree_rays == result.rays);
    CHECK(result.occlusion_rays > 0);
    CHECK(result.occlusion_rays < result.rays);
}

TEST_CASE("oracles: beyond the budget brute force takes a subset, the same for the same seed",
          "[verify][oracle]") {
    const PipelineParameters p = tiny();
    const Recording recording = record(p);
    const std::uint64_t half = recording.living_rays() * spheres().triangles.size() / 2;
    const auto rays = [&](std::uint64_t seed) {
        return check_hits(spheres(), recording, embree(), p.spp,
                          {.brute_force_tests = half, .seed = seed, .stage_pattern = {}})
            .brute_force_rays;
    };
    CHECK(rays(1) == rays(1));
    CHECK(rays(1) > recording.living_rays() / 3);
    CHECK(rays(1) < recording.living_rays() * 2 / 3);
}

TEST_CASE("oracles: a hit that is off by one bit fails brute force", "[verify][oracle]") {
    const PipelineParameters p = tiny();
    Recording recording = record(p);
    auto& hits = recording.traversals[2].hits;
    const std::uint32_t ray = first_hit(hits);
    hits[ray].t *= 1.0000002f;
    const HitCheckResult result = check_hits(spheres(), recording, embree(), p.spp, {});
    REQUIRE(result.failures.size() == 1);
    CHECK(result.failures[0].invariant == "brute-force");
    CHECK(result.failures[0].stage == "bounce1/merge_intersections");
    CHECK(result.failures[0].ray == ray);
}

TEST_CASE("oracles: a hit that is lost fails both, and Embree says that ours is wrong",
          "[verify][oracle]") {
    const PipelineParameters p = tiny();
    Recording recording = record(p);
    const std::uint32_t ray = first_hit(recording.traversals[0].hits);
    recording.traversals[0].hits[ray] = no_hit();
    const HitCheckResult result = check_hits(spheres(), recording, embree(), p.spp, {});
    CHECK(result.ours_wrong == 1);
    REQUIRE(result.failures.size() == 2);
    CHECK(result.failures[0].invariant == "brute-force");
    CHECK(result.failures[1].invariant == "embree");
    CHECK(result.failures[1].ray == ray);
}

TEST_CASE("oracles: a shadow that is lost fails the any-hit comparison", "[verify][oracle]") {
    const PipelineParameters p = tiny();
    Recording recording = record(p);
    auto& shadow = recording.traversals[1];
    shadow.hits[first_hit(shadow.hits)] = no_hit();
    // Without the brute force: its budget is nothing.
    const HitCheckResult result =
        check_hits(spheres(), recording, embree(), p.spp,
                   {.brute_force_tests = 0, .seed = 0, .stage_pattern = {}});
    CHECK(result.brute_force_rays == 0);
    CHECK(result.ours_wrong == 2);  // closest and any
    CHECK(result.failures.front().stage == "bounce0/light0/merge_intersections");
}

TEST_CASE("oracles: a dead ray that hits something fails", "[verify][oracle]") {
    const PipelineParameters p = tiny();
    Recording recording = record(p);
    auto& traversal = recording.traversals[0];
    traversal.rays[first_hit(traversal.hits)] = dead_ray();
    CHECK(check_hits(spheres(), recording, embree(), p.spp, {}).failures.size() == 1);
}

TEST_CASE("oracles: a stage pattern leaves out the other traversals", "[verify][oracle]") {
    const PipelineParameters p = tiny();
    const Recording recording = record(p);
    CHECK(
        check_hits(spheres(), recording, embree(), p.spp, {.stage_pattern = "light0"}).traversals ==
        2);
}

TEST_CASE("image check: a pixel may differ only where one of its rays has an excuse",
          "[verify][oracle]") {
    const PipelineParameters p = tiny();
    const Image ours = record(p).image;
    Image theirs = ours;
    std::vector<bool> excused(ours.pixels.size() * p.spp, false);
    CHECK(check_image(ours, theirs, excused, p.spp).identical == ours.pixels.size());
    theirs.pixels[20].x += 1e-6f;
    const auto bad = check_image(ours, theirs, excused, p.spp);
    REQUIRE(bad.failures.size() == 1);
    CHECK(bad.failures[0].field == "image[20] (x 3, y 1)");
    excused[41] = true;  // sample 1 of pixel 20
    const auto fine = check_image(ours, theirs, excused, p.spp);
    CHECK(fine.failures.empty());
    CHECK(fine.excused == 1);
    CHECK(fine.identical == ours.pixels.size() - 1);
}

}  // namespace
