/// The CUDA pipeline on the executor against the emulator, stage by stage.
#include <algorithm>
#include <cstring>
#include <map>

#include "emulation/host/pipeline.h"
#include "reference/contract/wide_bvh.h"
#include "reference/truth/tracers.h"
#include "tests/emulation/renders.h"
#include "tests/emulation/simt/executor_tools.h"
#include "tests/reference/meshes.h"
#include "tests/small_parameters.h"
#include "tests/verify/capture_tools.h"
#include "verify/backends/simt/simt_pipeline.h"
#include "verify/capture/canonical.h"
#include "verify/capture/replay_inputs.h"

namespace {

using namespace scotty::reference;
using namespace scotty::simt::test;
using Catch::Matchers::ContainsSubstring;
using scotty::emulation::test::bvh_of;
using scotty::emulation::test::differing_pixels;
using scotty::emulation::test::scene_named;
using scotty::simt::make_simt_pipeline;
using scotty::verify::canonical_bytes;
using scotty::verify::Capture;
using scotty::verify::LoadedStage;
using scotty::verify::regions_of;
using scotty::verify::test::make_capture;
using scotty::verify::test::small_parameters;
using scotty::verify::test::spheres_input;
using scotty::verify::test::StageCopies;
using scotty::verify::test::TemporaryFolder;

/// "" or the name of the first buffer whose canonical forms differ.
std::string first_difference(const StageView& a, const StageView& b, bool outputs) {
    const auto& buffers = outputs ? a.outputs : a.inputs;
    const auto& others = outputs ? b.outputs : b.inputs;
    if (buffers.size() != others.size()) return "another number of buffers";
    for (const BufferView& buffer : buffers) {
        const auto other = std::find_if(others.begin(), others.end(), [&](const BufferView& view) {
            return view.name == buffer.name;
        });
        const std::string name(buffer.name);
        if (other == others.end()) return name + " is missing";
        if (canonical_bytes(buffer, regions_of(a, buffer, outputs)) !=
            canonical_bytes(*other, regions_of(b, *other, outputs))) {
            return name + " differs";
        }
    }
    return "";
}

/// Compares every stage with the emulator's of the same name. If a traversal was run again, its
/// last run counts.
class Against : public StageObserver {
 public:
    Against(StageCopies& emulator, const PipelineParameters& p)
        : emulator_(emulator), p_(p), timing_(p.early_out == EarlyOut::immediate) {}

    void on_stage(const StageView& stage) override {
        ++stages_[stage.name];
        // Queues and gathered hits depend on timing under `immediate`.
        const bool queues = stage.kind == StageKind::scan_counts ||
                            stage.kind == StageKind::intersect ||
                            stage.kind == StageKind::intersect_root;
        if (timing_ && queues) return;
        const StageView& expected = emulator_.at(stage.name).view;
        const bool merge = stage.kind == StageKind::merge_intersections;
        const bool any = stage.light != kNotApplicable && p_.shadow_query == ShadowQuery::any;
        std::string& difference = differences_[stage.name];
        difference.clear();
        if (!timing_ || (!merge && stage.kind != StageKind::resolve_light)) {
            difference = first_difference(expected, stage, false);
        }
        if (timing_ && merge && any) {  // for an any-hit query only hit or not is fixed
            const auto a = expected.get<Hit>("merged");
            const auto b = stage.get<Hit>("merged");
            for (std::size_t i = 0; i < a.size(); ++i) {
                if (is_hit(a[i]) != is_hit(b[i])) difference = "merged differs";
            }
        } else if (difference.empty()) {
            difference = first_difference(expected, stage, true);
        }
    }
    void on_retry(std::string_view, std::string_view) override { ++retries; }

    std::string differences() const {
        std::string text;
        for (const auto& [stage, what] : differences_) {
            if (!what.empty()) text += stage + ": " + what + "\n";
        }
        return text;
    }
    /// Stages that the emulator has and this run lacks, or the other way round.
    std::string missing() const {
        std::map<std::string, int> names;
        for (const auto& copy : emulator_.all()) ++names[copy.view.name];
        std::string text;
        if (timing_) return text;
        for (const auto& [name, count] : stages_) {
            if (names.count(name) == 0) text += name + " is new\n";
        }
        for (const auto& [name, count] : names) {
            if (stages_.count(name) == 0) text += name + " is missing\n";
        }
        return text;
    }

    std::size_t retries = 0;

 private:
    StageCopies& emulator_;
    const PipelineParameters& p_;
    bool timing_;
    std::map<std::string, int> stages_;
    std::map<std::string, std::string> differences_;
};

void check_against_emulator(const std::string& scene, const PipelineParameters& p,
                            const SimtOptions& options = {}) {
    INFO(scene << ", width " << p.width << ", " << p.rays_per_block << " rays per block, early-out "
               << to_string(p.early_out) << ", " << to_string(p.hit_mode) << ", shadow "
               << to_string(p.shadow_query) << ", " << to_string(p.block_order) << ", "
               << p.queue_levels << " queue levels, queues of " << to_string(p.queues));
    scotty::reference::WideBvh bvh = bvh_of(scene, p.width);
    cut_levels(bvh, p.queue_levels);
    StageCopies stages;
    const Image expected =
        scotty::emulation::Pipeline(scene_named(scene), bvh, p, {}, &stages).render();
    Against against(stages, p);
    const Image image = make_simt_pipeline(scene_named(scene), bvh, p, options, &against)->render();
    CHECK(against.differences() == "");
    CHECK(against.missing() == "");
    CHECK(differing_pixels(image, expected) == 0);
}

TEST_CASE(
    "pipeline: every stage is the emulator's, for widths 2 to 16 and 32 to 1024 rays per block",
    "[simt][pipeline]") {
    PipelineParameters p = small_parameters();
    const auto order = every_order();
    std::size_t row = 0;
    for (const int width : {2, 4, 8, 16}) {
        for (const int threads : {32, 64, 96, 256, 1024}) {
            for (const EarlyOut early_out : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
                p.width = width;
                p.rays_per_block = threads;
                p.early_out = early_out;
                p.hit_mode = row % 2 == 0 ? HitMode::buffer : HitMode::packed;
                p.shadow_query = row / 2 % 2 == 0 ? ShadowQuery::any : ShadowQuery::closest;
                p.block_order = row / 3 % 2 == 0 ? BlockOrder::linear : BlockOrder::strided;
                p.light_samples = static_cast<std::uint32_t>(row % 3);
                p.queue_levels = static_cast<std::uint32_t>(row / 2 % 4);
                p.queues = row % 5 < 2 ? QueueKind::pairs : QueueKind::nodes;
                check_against_emulator("spheres", p, order[row % order.size()]);
                ++row;
            }
        }
    }
}

TEST_CASE("pipeline: filters, batches that split pixels, and scenes of many levels",
          "[simt][pipeline]") {
    PipelineParameters p = small_parameters();
    for (const Filter filter : {Filter::gaussian, Filter::bilateral, Filter::median}) {
        p.filter = filter;
        check_against_emulator("cornell", p);
    }
    p.batch_rays = 97;
    p.spp = 3;
    p.width = 2;
    check_against_emulator("coil", p);
    p.samples_per_pass = 2;
    check_against_emulator("coil", p);
}

TEST_CASE("pipeline: buffers that are too small grow, and the picture is the same",
          "[simt][pipeline]") {
    PipelineParameters p = small_parameters();
    p.early_out = EarlyOut::off;
    const Image expected =
        scotty::emulation::Pipeline(scene_named("spheres"), bvh_of("spheres", p.width), p).render();
    p.hit_capacity = 1;
    class Retries : public StageObserver {
     public:
        bool wants(StageKind) const override { return false; }
        void on_stage(const StageView&) override {}
        void on_retry(std::string_view, std::string_view reason) override {
            (ContainsSubstring("a ray has").match(std::string(reason)) ? grown : halved) += 1;
        }
        int grown = 0;
        int halved = 0;
    } retries;
    const auto render = [&](std::size_t memory_limit) {
        return make_simt_pipeline(scene_named("spheres"), bvh_of("spheres", p.width), p, {},
                                  &retries, {false, memory_limit})
            ->render();
    };
    CHECK(differing_pixels(render(0), expected) == 0);
    CHECK(retries.grown > 0);
    CHECK(retries.halved == 0);
    // There is less device memory than one batch needs: batches are halved until they fit.
    p.image_width = p.image_height = 64;
    p.hit_capacity = 32;
    const Image larger =
        scotty::emulation::Pipeline(scene_named("spheres"), bvh_of("spheres", p.width), p).render();
    CHECK(differing_pixels(render(std::size_t{2} << 20), larger) == 0);
    CHECK(retries.halved > 0);
}

TEST_CASE("pipeline: a level's pairs that find no room are appended again", "[simt][pipeline]") {
    // A ray through so many triangles, one behind the other, is in more nodes of a level than the
    // queue has slots for it at first.
    Scene scene;
    scene.materials.emplace_back();
    for (int i = 0; i < 200; ++i) {
        const float z = -static_cast<float>(i);
        scotty::reference::test::add_triangle(scene, Vec3(-1, -1, z), Vec3(1, -1, z),
                                              Vec3(0, 1, z));
    }
    PipelineParameters p = small_parameters();
    p.queues = QueueKind::pairs;
    p.width = 2;
    p.max_leaf_size = 1;
    p.early_out = EarlyOut::off;
    const WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 0));
    class Retries : public StageObserver {
     public:
        bool wants(StageKind) const override { return false; }
        void on_stage(const StageView&) override {}
        void on_retry(std::string_view, std::string_view reason) override {
            pairs += ContainsSubstring("a level's queues need").match(std::string(reason)) ? 1 : 0;
        }
        int pairs = 0;
    } retries;
    const std::vector<Ray> rays(300, Ray{Vec3(0, 0, 1), 0.0f, Vec3(0, 0, -1), kInfinity});
    std::vector<Hit> hits(rays.size()), expected(rays.size());
    scotty::emulation::Pipeline(scene, bvh, p).trace(rays, TraversalKind::closest, expected);
    make_simt_pipeline(scene, bvh, p, {}, &retries)->trace(rays, TraversalKind::closest, hits);
    CHECK(scotty::emulation::test::same_bits(hits, expected));
    CHECK(hits[0].primitive == 0);
    CHECK(retries.pairs > 0);
}

TEST_CASE("pipeline: a fifth of the memory is enough for smaller batches", "[simt][pipeline]") {
    const PipelineParameters p = scotty::test::small_picture(128, 96, 2);
    const Scene& scene = scene_named("coil");
    const WideBvh& bvh = bvh_of("coil", p.width);
    const auto whole = make_simt_pipeline(scene, bvh, p, {}, nullptr);
    const Image expected = whole->render();
    for (const std::size_t part : {2, 4, 5}) {
        const std::size_t limit = whole->device_bytes() / part;
        const auto pipeline = make_simt_pipeline(scene, bvh, p, {}, nullptr, {false, limit});
        CHECK(differing_pixels(pipeline->render(), expected) == 0);
        CHECK(pipeline->device_bytes() <= limit);
    }
}

TEST_CASE("pipeline: rays from elsewhere get brute force's hits", "[simt][pipeline]") {
    const Scene& scene = scene_named("spheres");
    const std::vector<Ray> rays = [] {
        std::vector<Ray> some;
        for (int i = 0; i < 500; ++i) {
            const float x = static_cast<float>(i % 25) * 0.08f - 1.0f;
            const float y = static_cast<float>(i / 25) * 0.1f - 1.0f;
            some.push_back({Vec3(0, 1, 4), 0.0f, Vec3(x, y, -2.0f), kInfinity});
        }
        return some;
    }();
    PipelineParameters p = small_parameters();
    p.batch_rays = 128;
    std::vector<Hit> expected(rays.size());
    scotty::emulation::Pipeline(scene, bvh_of("spheres", p.width), p)
        .trace(rays, TraversalKind::closest, expected);
    for (const SimtOptions& options : every_order()) {
        std::vector<Hit> hits(rays.size());
        auto pipeline = make_simt_pipeline(scene, bvh_of("spheres", p.width), p, options);
        pipeline->trace(rays, TraversalKind::closest, hits);
        CHECK(scotty::emulation::test::same_bits(hits, expected));
        CHECK(pipeline->launches().size() > 10);
        CHECK(pipeline->device_bytes() > 0);
    }
    auto timed = make_simt_pipeline(scene, bvh_of("spheres", p.width), p, {}, nullptr, {true, 0});
    CHECK(timed->time_trace(rays, TraversalKind::closest, 3) > 0.0);
}

TEST_CASE("pipeline: without queues a traversal merges its own hits, unless somebody watches",
          "[simt][pipeline]") {
    class Watcher : public StageObserver {
     public:
        bool wants(StageKind) const override { return false; }
        void on_stage(const StageView&) override {}
    } watcher;
    const Scene& scene = scene_named("spheres");
    const std::vector<Ray> incoherent = scotty::reference::test::random_rays(300, 1.5f, 7);
    std::vector<Ray> coherent = incoherent;  // one thread per ray
    for (Ray& ray : coherent) ray.direction = scotty::reference::Vec3(0.1f, 0.2f, 1.0f);
    std::vector<Ray> dead = incoherent;
    for (std::size_t i = 0; i < dead.size(); i += 3) dead[i] = scotty::reference::dead_ray();
    PipelineParameters p = small_parameters();
    p.queue_levels = 1;
    scotty::reference::WideBvh bvh = bvh_of("spheres", p.width);
    cut_levels(bvh, p.queue_levels);
    for (const auto& rays : {incoherent, coherent, dead}) {
        for (const EarlyOut early_out : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
            p.early_out = early_out;
            for (const TraversalKind kind : {TraversalKind::closest, TraversalKind::any}) {
                const auto merges = [&](StageObserver* observer, std::vector<Hit>& hits) {
                    auto pipeline = make_simt_pipeline(scene, bvh, p, {}, observer);
                    pipeline->trace(rays, kind, hits);
                    std::vector<Hit> again(rays.size());  // from the first trace's end
                    pipeline->trace(rays, kind, again);
                    CHECK(scotty::emulation::test::same_bits(hits, again));
                    return std::any_of(pipeline->launches().begin(), pipeline->launches().end(),
                                       [](const auto& launch) {
                                           return launch.kind == StageKind::merge_intersections;
                                       });
                };
                std::vector<Hit> alone(rays.size()), watched(rays.size());
                CHECK_FALSE(merges(nullptr, alone));
                CHECK(merges(&watcher, watched));
                CHECK(scotty::emulation::test::same_bits(alone, watched));
                CHECK(std::any_of(alone.begin(), alone.end(),
                                  [](const Hit& hit) { return is_hit(hit); }));
            }
        }
    }
}

TEST_CASE("pipeline: below the queues a ray that enters almost every box has room for what waits",
          "[simt][pipeline]") {
    // There is nothing to cull by before the first leaf.
    const Scene scene = scotty::reference::test::soup(3000, 3.0f, 11);
    const std::vector<Ray> rays = scotty::reference::test::random_rays(64, 0.5f, 12);
    PipelineParameters p = small_parameters();
    p.early_out = EarlyOut::off;
    std::vector<Hit> expected(rays.size()), hits(rays.size());
    scotty::reference::brute_force_closest(scene, rays, expected);
    for (const int width : {2, 8, 16}) {
        p.width = width;
        const auto bvh = scotty::reference::build_wide_bvh(scene, {width, 1, 1, 1});
        make_simt_pipeline(scene, bvh, p, {})->trace(rays, TraversalKind::closest, hits);
        CHECK(scotty::emulation::test::same_bits(hits, expected));
    }
}

TEST_CASE("stages alone: every kernel makes of the emulator's inputs what the emulator makes",
          "[simt][pipeline]") {
    PipelineParameters p = small_parameters();
    SECTION("buffer, level, median") { p.filter = Filter::median; }
    SECTION("packed, off, width 8, gaussian") {
        p.filter = Filter::gaussian;
        p.hit_mode = HitMode::packed;
        p.early_out = EarlyOut::off;
        p.width = 8;
    }
    SECTION("batches, width 16, strided, bilateral") {
        p.filter = Filter::bilateral;
        p.batch_rays = 97;
        p.spp = 3;
        p.width = 16;
        p.block_order = BlockOrder::strided;
    }
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", p);
    const auto input = spheres_input(p);
    std::size_t compared = 0;
    scotty::emulation::Pipeline emulator(input.scene, input.bvh, p);
    const auto simt = make_simt_pipeline(input.scene, input.bvh, p);
    for (const auto& record : capture.stages()) {
        const LoadedStage stage = prepare_stage(capture, record);
        const auto expected = emulator.run_stage(stage.view);
        const auto found = simt->run_stage(stage.view);
        StageView a = stage.view;
        StageView b = stage.view;
        a.outputs.clear();
        b.outputs.clear();
        for (const OwnedBuffer& buffer : expected) a.outputs.push_back(buffer.view());
        for (const OwnedBuffer& buffer : found) b.outputs.push_back(buffer.view());
        INFO(record.name);
        CHECK(first_difference(a, b, true).empty());
        ++compared;
    }
    CHECK(compared > 30);
}

}  // namespace
