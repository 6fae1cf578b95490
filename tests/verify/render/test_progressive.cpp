/// A picture that is refined pass by pass is the picture, at every pass.
#include <algorithm>
#include <csignal>
#include <cstring>
#include <utility>
#include <vector>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/base/stop_signal.h"
#include "verify/render/progressive.h"

namespace scotty::verify::test {
namespace {

using reference::Filter;
using reference::Image;
using reference::PipelineParameters;
using reference::StageKind;
using reference::StageObserver;
using reference::StageView;
using reference::Vec3;

bool same_bits(const Image& a, const Image& b) {
    return a.width == b.width && a.height == b.height && a.pixels.size() == b.pixels.size() &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(Vec3)) == 0;
}

/// One pass after the other, beside ordinary renders of as many samples.
void check_passes(const Backend& backend, const PipelineParameters& p,
                  const std::vector<std::uint32_t>& expected_passes) {
    const PipelineInput input = spheres_input(p);
    const auto plain = [&](std::uint32_t samples) {
        PipelineInput whole = input;
        whole.parameters.spp = samples;
        whole.parameters.samples_per_pass = 0;
        return backend.render(whole, nullptr);
    };
    std::vector<std::uint32_t> passes;
    const ProgressiveImage last =
        render_progressively(backend, input,
                             {[&](std::uint32_t samples, const std::function<Image()>& picture) {
                                  passes.push_back(samples);
                                  CHECK(same_bits(picture(), plain(samples)));
                              },
                              [](const std::string&) { return false; }});
    CHECK(passes == expected_passes);
    CHECK(last.samples == p.spp);
    CHECK(same_bits(last.image, plain(p.spp)));
}

PipelineParameters passes_of(std::uint32_t samples, std::uint32_t spp) {
    PipelineParameters p = small_parameters();
    p.spp = spp;
    p.samples_per_pass = samples;
    return p;
}

}  // namespace

TEST_CASE("progressive: every pass is the render of that many samples, bit for bit",
          "[verify][progressive]") {
    for (const std::uint32_t batch : {1u << 16, 37u}) {
        for (const Backend& backend :
             {backend_named("emulator", 0), backend_named("simt", 0), embree_backend(0)}) {
            INFO(backend.name << ", batches of " << batch);
            PipelineParameters p = passes_of(1, 4);
            p.batch_rays = batch;
            check_passes(backend, p, {1, 2, 3});
            p.samples_per_pass = 3;
            p.spp = 7;
            check_passes(backend, p, {3, 6});
        }
    }
    // More samples a pass than a batch holds.
    PipelineParameters p = passes_of(3, 7);
    p.image_width = p.image_height = 3;
    p.batch_rays = 2;
    check_passes(backend_named("emulator", 0), p, {3, 6});
}

TEST_CASE("progressive: one pipeline renders other cameras and sizes as new ones would",
          "[verify][progressive]") {
    for (const Backend& backend :
         {backend_named("emulator", 0), backend_named("simt", 0), embree_backend(0)}) {
        INFO(backend.name);
        PipelineInput input = spheres_input(passes_of(0, 2));
        const ProgressiveListener nobody{[](std::uint32_t, const std::function<Image()>&) {},
                                         [](const std::string&) { return false; }};
        ProgressiveRenderer renderer(backend, input);
        for (std::uint32_t i = 0; i < 4; ++i) {
            input.scene.camera.position.x += 0.1f * static_cast<float>(i);
            input.parameters.image_width = 20 - 3 * i;
            input.parameters.spp = 1 + i % 2;
            input.parameters.seed = i;
            input.parameters.bounces = i;
            input.parameters.batch_rays = 100 + i;
            CHECK(same_bits(renderer.render(nobody).image, backend.render(input, nullptr)));
        }
    }
}

TEST_CASE("progressive: only passes that are wanted are shown", "[verify][progressive]") {
    for (const std::uint32_t batch : {1u << 16, 37u}) {
        PipelineParameters p = passes_of(1, 6);
        p.batch_rays = batch;
        std::vector<std::uint32_t> shown;
        const ProgressiveImage last =
            render_progressively(backend_named("emulator", 0), spheres_input(p),
                                 {[&](std::uint32_t samples, const std::function<Image()>&) {
                                      shown.push_back(samples);
                                  },
                                  [](const std::string&) { return false; },
                                  [](std::uint32_t samples) { return samples % 2 == 0; }});
        CHECK(shown == std::vector<std::uint32_t>{2, 4});
        CHECK(last.samples == 6);
    }
}

TEST_CASE("progressive: the filter is applied below the threshold and no longer",
          "[verify][progressive]") {
    for (const Filter filter : {Filter::median, Filter::gaussian, Filter::bilateral}) {
        for (const char* backend : {"emulator", "simt"}) {
            PipelineParameters p = passes_of(1, 4);
            p.filter = filter;
            p.filter_threshold = 3;
            check_passes(backend_named(backend, 0), p, {1, 2, 3});
            p.filter_threshold = 5;  // the last image too
            check_passes(backend_named(backend, 0), p, {1, 2, 3});
        }
    }
}

TEST_CASE("progressive: a render that is stopped keeps the last pass that every pixel had",
          "[verify][progressive]") {
    PipelineParameters p = passes_of(1, 5);
    p.batch_rays = 37;
    const PipelineInput input = spheres_input(p);
    const Backend backend = backend_named("emulator", 0);
    std::vector<std::size_t> stages_at_pass;
    std::size_t stages = 0;
    render_progressively(
        backend, input,
        {[&](std::uint32_t, const std::function<Image()>&) { stages_at_pass.push_back(stages); },
         [&](const std::string&) {
             ++stages;
             return false;
         }});
    REQUIRE(stages_at_pass.size() == 4);
    const auto stopped_at = [&](std::size_t wanted) {
        std::size_t stage = 0;
        return render_progressively(backend, input,
                                    {[](std::uint32_t, const std::function<Image()>&) {},
                                     [&](const std::string&) { return stage++ == wanted; }});
    };
    const auto plain = [&](std::uint32_t samples) {
        PipelineInput whole = input;
        whole.parameters.spp = samples;
        return backend.render(whole, nullptr);
    };
    // Half-way through a pass, and at its last launch but one.
    for (std::uint32_t samples = 1; samples <= 3; ++samples) {
        for (const std::size_t stage : {(stages_at_pass[samples - 1] + stages_at_pass[samples]) / 2,
                                        stages_at_pass[samples] - 1}) {
            const ProgressiveImage kept = stopped_at(stage);
            CHECK(kept.samples == samples);
            CHECK(same_bits(kept.image, plain(samples)));
        }
        CHECK(stopped_at(stages_at_pass[samples]).samples == samples + 1);
    }
    CHECK(stopped_at(stages_at_pass[0] - 1).samples == 0);
    CHECK(stopped_at(stages_at_pass[0] - 1).image.pixels.empty());
    CHECK(stopped_at(stages - 1).samples == 4);
    // 4 batches a pass: nothing is left to stop.
    const ProgressiveImage whole = render_progressively(
        backend, input,
        {[](std::uint32_t, const std::function<Image()>&) {},
         [](const std::string& stage) { return stage == "batch19/reconstruct_image"; }});
    CHECK(whole.samples == 5);
    CHECK(same_bits(whole.image, plain(5)));
}

TEST_CASE("progressive: a render that begins again with smaller batches counts anew",
          "[verify][progressive]") {
    struct Full {};
    class Until : public StageObserver {
     public:
        explicit Until(StageObserver& shown) : shown_(shown) {}
        bool wants(StageKind kind) const override { return shown_.wants(kind); }
        void on_stage(const StageView& stage) override {
            if (stage.batch == 11) throw Full{};
            shown_.on_stage(stage);
        }

     private:
        StageObserver& shown_;
    };
    const Backend out_of_memory =
        render_only("emulator", [](const reference::Scene& scene, const reference::WideBvh& bvh,
                                   const PipelineParameters& whole, StageObserver* observer) {
            const Backend emulator = backend_named("emulator", 0);
            PipelineParameters p = whole;
            if (observer == nullptr) return emulator.make(scene, bvh, p, {})->render();
            try {
                Until until(*observer);
                emulator.make(scene, bvh, p, {.observer = &until})->render();
            } catch (const Full&) {
                p.batch_rays /= 2;
            }
            return emulator.make(scene, bvh, p, {.observer = observer})->render();
        });
    PipelineParameters p = passes_of(1, 6);
    p.batch_rays = 41;  // 4 batches a pass, and then 8
    check_passes(out_of_memory, p, {1, 2, 3, 4, 5});
}

TEST_CASE("stop signals: the first is noted, the second is the system's, and all is put back",
          "[verify][progressive]") {
    const auto handler = [](int signal) {
        struct sigaction now {};
        sigaction(signal, nullptr, &now);
        return now.sa_handler;
    };
    for (const int signal : {SIGINT, SIGTERM}) {
        const auto before = std::signal(signal, SIG_IGN);
        {
            const StopSignals ignored;
            CHECK(handler(signal) == SIG_IGN);
        }
        std::signal(signal, before);
        {
            const StopSignals signals;
            CHECK(signals.received() == 0);
            const auto noting = handler(signal);
            std::raise(signal);
            CHECK(signals.received() == signal);
            // What ends the program now, and removes its scratch folders first.
            CHECK(handler(SIGINT) != noting);
            CHECK(handler(SIGTERM) != noting);
        }
        CHECK(handler(signal) == before);
        CHECK(StopSignals().received() == 0);
    }
}

}  // namespace scotty::verify::test
