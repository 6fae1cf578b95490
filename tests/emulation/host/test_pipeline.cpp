/// Whole renders give the same bits under every parameter that must not matter, and Embree's.
#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "reference/base/error.h"
#include "reference/truth/embree_renderer.h"
#include "tests/catch.h"
#include "tests/emulation/renders.h"

using namespace scotty::emulation;
using namespace scotty::emulation::test;
using namespace scotty::reference;

namespace {

using Change = std::function<void(PipelineParameters&)>;

/// Checks for the same bits as with standard parameters.
void check_same(const std::string& scene, const PipelineParameters& base,
                const std::vector<Change>& changes) {
    const Image expected = render(scene, base);
    for (std::size_t i = 0; i < changes.size(); ++i) {
        PipelineParameters p = base;
        changes[i](p);
        INFO(scene << ", change " << i);
        CHECK(differing_pixels(render(scene, p, {2}), expected) == 0);
    }
}

Image by_embree(const std::string& name, const PipelineParameters& p) {
    return render_with_embree(scene_named(name), p, EmbreeTracer(scene_named(name)), 2);
}

/// Asks Embree about every ray of a render, and double precision where the two disagree.
class Adjudicator : public StageObserver {
 public:
    Adjudicator(const Scene& scene, std::uint32_t spp) : scene_(scene), tracer_(scene), spp_(spp) {}
    bool wants(StageKind kind) const override { return kind == StageKind::merge_intersections; }
    void on_stage(const StageView& stage) override {
        const auto traced = stage.get<Ray>("rays");
        const auto merged = stage.get<Hit>("merged");
        for (std::size_t i = 0; i < traced.size(); ++i) {
            if (is_dead(traced[i])) continue;
            ++rays;
            const Hit embree = tracer_.closest(traced[i]);
            const Adjudication verdict =
                stage.light == kNotApplicable
                    ? adjudicate_closest(scene_, traced[i], merged[i], embree)
                    : adjudicate_occluded(scene_, traced[i], is_hit(merged[i]),
                                          tracer_.occluded(traced[i]), embree);
            if (verdict.verdict == Disagreement::none) continue;
            explained.insert(i / spp_);
            if (verdict.verdict == Disagreement::ours_wrong) {
                wrong.push_back(stage.name + ": " + verdict.explanation);
            }
        }
    }
    std::size_t rays = 0;
    std::set<std::size_t> explained;  ///< pixels with a ray on which the two differ
    std::vector<std::string> wrong;

 private:
    const Scene& scene_;
    EmbreeTracer tracer_;
    std::uint32_t spp_;
};

std::map<StageKind, std::size_t> count_kinds(const std::vector<LaunchRecord>& launches) {
    std::map<StageKind, std::size_t> counts;
    for (const LaunchRecord& launch : launches) ++counts[launch.kind];
    return counts;
}

}  // namespace

TEST_CASE("pipeline: tree width and rays per block never change a bit of the image",
          "[emulation][pipeline]") {
    for (const char* scene : {"cornell", "coil", "veil", "slivers"}) {
        std::vector<Change> changes;
        for (const int width : {2, 4, 16}) {
            changes.emplace_back([=](PipelineParameters& p) { p.width = width; });
        }
        for (const int threads : {32, 96, 1024}) {
            changes.emplace_back([=](PipelineParameters& p) { p.rays_per_block = threads; });
        }
        check_same(scene, tiny(9, 7), changes);
    }
}

TEST_CASE(
    "pipeline: early-out, hit mode, block order, shadow query, capacity and queue levels "
    "change no bit",
    "[emulation][pipeline]") {
    for (const char* scene : {"cornell", "coil", "veil", "slivers"}) {
        check_same(
            scene, tiny(9, 7),
            {[](auto& p) { p.early_out = EarlyOut::off; },
             [](auto& p) { p.early_out = EarlyOut::immediate; },
             [](auto& p) { p.hit_mode = HitMode::packed; },
             [](auto& p) { p.block_order = BlockOrder::strided; },
             [](auto& p) { p.shadow_query = ShadowQuery::closest; },
             [](auto& p) { p.hit_capacity = 1; }, [](auto& p) { p.queue_levels = 1; },
             [](auto& p) { p.queue_levels = 2; }, [](auto& p) { p.queues = QueueKind::pairs; },
             [](auto& p) {
                 p.queues = QueueKind::pairs;
                 p.queue_levels = 2;
                 p.hit_mode = HitMode::packed;
                 p.block_order = BlockOrder::strided;
                 p.early_out = EarlyOut::immediate;
             },
             [](auto& p) {
                 p.queue_levels = 3;
                 p.hit_mode = HitMode::packed;
                 p.early_out = EarlyOut::immediate;
             },
             [](auto& p) {
                 p.early_out = EarlyOut::off;
                 p.hit_capacity = 1;
                 p.width = 2;
             },
             [](auto& p) {
                 p.early_out = EarlyOut::immediate;
                 p.hit_mode = HitMode::packed;
                 p.block_order = BlockOrder::strided;
                 p.shadow_query = ShadowQuery::closest;
                 p.rays_per_block = 32;
                 p.width = 16;
             }});
    }
}

TEST_CASE("pipeline: batches of 1, 7, 64 or all rays change no bit", "[emulation][pipeline]") {
    std::vector<Change> changes;
    for (const std::uint32_t batch : {1u, 7u, 64u}) {
        changes.emplace_back([=](PipelineParameters& p) { p.batch_rays = batch; });
    }
    check_same("cornell", tiny(9, 7), changes);
    // There are more samples than a batch holds: the running sums add up in the same order.
    PipelineParameters many = tiny(3, 2);
    many.spp = 30;
    check_same("spheres", many, changes);
}

TEST_CASE("pipeline: passes of a few samples over the whole image change no bit",
          "[emulation][pipeline]") {
    std::vector<Change> changes;
    for (const std::uint32_t pass : {1u, 2u, 3u, 7u, 9u}) {
        for (const std::uint32_t batch : {1u << 16, 11u, 2u}) {
            changes.emplace_back([=](PipelineParameters& p) {
                p.samples_per_pass = pass;
                p.batch_rays = batch;
            });
        }
    }
    PipelineParameters p = tiny(3, 2);
    p.spp = 8;
    check_same("spheres", p, changes);
}

TEST_CASE("pipeline: schedules and threads change no bit", "[emulation][pipeline]") {
    PipelineParameters p = tiny(9, 7);
    p.rays_per_block = 32;
    for (const EarlyOut early_out : {EarlyOut::level, EarlyOut::immediate}) {
        p.early_out = early_out;
        for (const char* scene : {"coil", "veil"}) {
            const Image expected = render(scene, p, {1});
            for (const DeviceOptions& device :
                 {DeviceOptions{2}, DeviceOptions{0}, DeviceOptions{1, ScheduleKind::linear},
                  DeviceOptions{1, ScheduleKind::reversed},
                  DeviceOptions{1, ScheduleKind::shuffled, 1},
                  DeviceOptions{1, ScheduleKind::shuffled, 2}}) {
                CHECK(differing_pixels(render(scene, p, device), expected) == 0);
            }
        }
    }
}

TEST_CASE("pipeline: two runs are equal bit by bit, and another seed gives another image",
          "[emulation][pipeline]") {
    PipelineParameters p = tiny(16, 16);
    const Image first = render("cornell", p);
    CHECK(differing_pixels(render("cornell", p), first) == 0);
    // One pipeline renders twice: nothing is left over from the render before.
    Pipeline pipeline(scene_named("cornell"), bvh_of("cornell", 8), p, {2});
    CHECK(differing_pixels(pipeline.render(), first) == 0);
    CHECK(differing_pixels(pipeline.render(), first) == 0);
    p.seed = 1;
    CHECK(differing_pixels(render("cornell", p), first) > 100);
}

TEST_CASE("pipeline: with roulette paths end early, and the image is the same on average",
          "[emulation][pipeline]") {
    PipelineParameters p = tiny(12, 12);
    p.bounces = 5;
    p.spp = 64;
    PipelineParameters short_paths = p;
    short_paths.roulette = 1;
    // Differences of independent renders: their mean is 0 within five standard errors.
    std::vector<double> differences;
    std::uint64_t rays = 0;
    std::uint64_t rays_of_short = 0;
    for (std::uint64_t seed = 0; seed < 24; ++seed) {
        p.seed = seed;
        short_paths.seed = 1000 + seed;
        const auto mean = [](const PipelineParameters& q, std::uint64_t& traced) {
            Pipeline pipeline(scene_named("cornell"), bvh_of("cornell", q.width), q, {2});
            const Image image = pipeline.render();
            for (const auto& launch : pipeline.launches()) {
                if (launch.kind == StageKind::intersect) traced += launch.items;
            }
            double sum = 0.0;
            for (const auto& pixel : image.pixels) sum += double{pixel.x} + pixel.y + pixel.z;
            return sum / static_cast<double>(image.pixels.size());
        };
        differences.push_back(mean(p, rays) - mean(short_paths, rays_of_short));
    }
    double mean = 0.0;
    for (const double d : differences) mean += d / static_cast<double>(differences.size());
    double variance = 0.0;
    for (const double d : differences) variance += (d - mean) * (d - mean);
    const auto n = static_cast<double>(differences.size());
    CHECK(std::abs(mean) < 5.0 * std::sqrt(variance / (n * (n - 1))));
    CHECK(10 * rays_of_short < 9 * rays);
    p.roulette = 64;  // never reached
    CHECK(differing_pixels(render("cornell", p), [&] {
              p.roulette = 0;
              return render("cornell", p);
          }()) == 0);
}

TEST_CASE("pipeline: the image is the one that Embree's traversal gives, bit for bit",
          "[emulation][pipeline]") {
    for (const char* scene : {"cornell", "spheres", "furnace"}) {
        PipelineParameters p = tiny(40, 30);
        p.bounces = 4;
        INFO(scene);
        CHECK(differing_pixels(render(scene, p, {2}), by_embree(scene, p)) == 0);
    }
}

TEST_CASE("pipeline: where Embree's image differs, Embree saw another of two hits alike",
          "[emulation][pipeline]") {
    // These have edges and slivers everywhere: sometimes two answers are right.
    for (const char* scene : {"coil", "veil", "slivers"}) {
        const PipelineParameters p = tiny(24, 18);
        Adjudicator adjudicator(scene_named(scene), p.spp);
        const Image ours =
            Pipeline(scene_named(scene), bvh_of(scene, p.width), p, {2}, &adjudicator).render();
        const Image theirs = by_embree(scene, p);
        INFO(scene);
        CHECK(adjudicator.wrong.empty());
        std::size_t unexplained = 0;
        for (std::size_t i = 0; i < ours.pixels.size(); ++i) {
            if (ours.pixels[i] != theirs.pixels[i])
                unexplained += 1 - adjudicator.explained.count(i);
        }
        CHECK(unexplained == 0);
        CHECK(differing_pixels(ours, theirs) < 22);  // at most 5 % all the same
        CHECK(adjudicator.rays > 1000);
    }
}

TEST_CASE("pipeline: any image size, odd, narrow or of one pixel", "[emulation][pipeline]") {
    for (const auto& [width, height] : {std::pair{1u, 1u}, {1u, 17u}, {33u, 5u}, {5u, 33u}}) {
        PipelineParameters p = tiny(width, height);
        const Image expected = by_embree("cornell", p);
        for (const std::uint32_t batch : {1u << 16, 13u}) {
            p.batch_rays = batch;
            const Image image = render("cornell", p, {2});
            INFO(width << "x" << height << ", batch " << batch);
            CHECK((image.width == width && image.height == height));
            CHECK(image.pixels.size() == width * height);
            CHECK(differing_pixels(image, expected) == 0);
        }
    }
}

TEST_CASE("pipeline: no bounces, no light samples, many of either: as Embree's paths",
          "[emulation][pipeline]") {
    for (const std::uint32_t bounces : {0u, 1u, 8u}) {
        for (const std::uint32_t light_samples : {0u, 1u, 5u}) {
            for (const std::uint32_t spp : {1u, 5u}) {
                PipelineParameters p = tiny(11, 6);
                p.bounces = bounces;
                p.light_samples = light_samples;
                p.spp = spp;
                INFO(bounces << " bounces, " << light_samples << " light samples, " << spp);
                CHECK(differing_pixels(render("cornell", p), by_embree("cornell", p)) == 0);
                CHECK(differing_pixels(render("spheres", p), by_embree("spheres", p)) == 0);
            }
        }
    }
}

TEST_CASE("pipeline: every launch is recorded with its kind and place", "[emulation][pipeline]") {
    PipelineParameters p = tiny(8, 8);
    p.bounces = 2;
    p.light_samples = 3;
    p.batch_rays = 32;
    Pipeline pipeline(scene_named("cornell"), bvh_of("cornell", 8), p, {1});
    pipeline.render();
    auto counts = count_kinds(pipeline.launches());
    const std::size_t batches = 8 * 8 * 2 / 32;
    const std::size_t vertices = 3;
    const std::size_t traversals = batches * vertices * (1 + 3);
    CHECK(counts[StageKind::primary_rays] == batches);
    CHECK(counts[StageKind::direct_light_rays] == batches * vertices * 3);
    CHECK(counts[StageKind::resolve_light] == batches * vertices * 3);
    CHECK(counts[StageKind::scene_rays] == batches * vertices);
    CHECK(counts[StageKind::merge_intersections] == traversals);
    CHECK(counts[StageKind::intersect_root] == traversals);
    CHECK(counts[StageKind::reconstruct_image] == batches);
    CHECK(counts[StageKind::intersect] > 0);
    const std::size_t levels = counts[StageKind::intersect_root] + counts[StageKind::intersect];
    CHECK(counts[StageKind::scan_counts] == levels);
    CHECK(counts[StageKind::publish_minimum] == levels);  // early-out level
    CHECK(counts[StageKind::filter] == 0);
    std::uint32_t last_batch = 0;
    for (const LaunchRecord& launch : pipeline.launches()) {
        CHECK(launch.blocks > 0);
        CHECK(launch.seconds >= 0.0);
        CHECK((launch.batch == last_batch || launch.batch == last_batch + 1));
        last_batch = launch.batch;
        const bool is_level =
            launch.kind == StageKind::intersect || launch.kind == StageKind::scan_counts;
        if (is_level) CHECK(launch.level < bvh_of("cornell", 8).level_count());
    }
    CHECK(last_batch + 1 == batches);
    pipeline.clear_launches();
    CHECK(pipeline.launches().empty());
}

TEST_CASE("pipeline: memory grows with the rays in flight, not with the image",
          "[emulation][pipeline]") {
    const auto bytes = [](std::uint32_t size, std::uint32_t batch) {
        PipelineParameters p = tiny(size, size);
        p.spp = 1;
        p.bounces = 1;
        p.light_samples = 1;
        p.batch_rays = batch;
        Pipeline pipeline(scene_named("cornell"), bvh_of("cornell", 8), p, {2});
        pipeline.render();
        return pipeline.device_bytes() -
               2 * std::size_t{size} * size * sizeof(Vec3);  // image, variance
    };
    const std::size_t small = bytes(64, 1024);
    const std::size_t large_image = bytes(256, 1024);
    const std::size_t large_batch = bytes(64, 4096);
    INFO(small << " bytes at 64x64, " << large_image << " at 256x256, " << large_batch
               << " with batches four times as large");
    CHECK(large_image < 2 * small);  // 16 times the pixels
    CHECK(large_batch > 3 * small);
    CHECK(small > 1024 * (sizeof(Ray) + sizeof(Hit)));
}

TEST_CASE("pipeline: parameters out of range are refused by name", "[emulation][pipeline]") {
    PipelineParameters p = tiny(8, 8);
    p.rays_per_block = 33;
    CHECK_THROWS_WITH(render("cornell", p), Catch::Matchers::ContainsSubstring("rays per block"));
}
