/// Launches, rays and trees that must be refused are; and pipelines that believe all, name nothing
/// or refuse everything are seen.
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "reference/base/error.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/backends/temporary_capture.h"
#include "verify/diff/run_refusals.h"

namespace scotty::verify::test {
namespace {

using reference::PipelineInterface;

Backend emulator_of_refusals() { return backend_named("emulator", 1); }

/// What a pipeline that is wrong about errors does with one.
using OnError = void (*)(const reference::Error&);

/// The emulator, with another opinion of what it refuses.
class Credulous : public PipelineInterface {
 public:
    Credulous(std::unique_ptr<PipelineInterface> inner, OnError on_error)
        : inner_(std::move(inner)), on_error_(on_error) {}

    reference::Image render() override { return inner_->render(); }
    void look(const reference::Camera& camera,
              const reference::PipelineParameters& parameters) override {
        inner_->look(camera, parameters);
    }
    void trace(std::span<const reference::Ray> rays, reference::TraversalKind kind,
               std::span<reference::Hit> hits) override {
        try {
            inner_->trace(rays, kind, hits);
        } catch (const reference::Error& error) {
            on_error_(error);
        }
    }
    double time_trace(std::span<const reference::Ray> rays, reference::TraversalKind kind,
                      int repeats) override {
        return inner_->time_trace(rays, kind, repeats);
    }
    std::vector<reference::OwnedBuffer> run_stage(const reference::StageView& stage) override {
        try {
            return inner_->run_stage(stage);
        } catch (const reference::Error& error) {
            on_error_(error);
            return {};
        }
    }
    const std::vector<reference::LaunchRecord>& launches() override { return inner_->launches(); }
    void clear_launches() override { inner_->clear_launches(); }
    std::size_t device_bytes() const override { return inner_->device_bytes(); }

 private:
    std::unique_ptr<PipelineInterface> inner_;
    OnError on_error_;
};

Backend with_errors(OnError on_error) {
    Backend backend = emulator_of_refusals();
    backend.make = [make = backend.make, on_error](const auto&... arguments) {
        return std::make_unique<Credulous>(make(arguments...), on_error);
    };
    return backend;
}
void believe_all_launches(const reference::Error&) {}
void name_nothing(const reference::Error&) {
    throw reference::Error::bad_input("something", "is wrong");
}

/// Pictures of few paths; every hit mode and early-out is in one of them.
std::vector<reference::PipelineParameters> tiny_pictures() {
    std::vector<reference::PipelineParameters> all;
    for (const auto early_out :
         {reference::EarlyOut::off, reference::EarlyOut::level, reference::EarlyOut::immediate}) {
        reference::PipelineParameters p;
        p.image_width = 3;
        p.image_height = 2;
        p.spp = 2;
        p.bounces = 1;
        p.light_samples = 1;
        p.width = 4;
        p.max_leaf_size = 2;
        p.filter = reference::Filter::median;
        p.early_out = early_out;
        p.hit_mode = early_out == reference::EarlyOut::level ? reference::HitMode::packed
                                                             : reference::HitMode::buffer;
        all.push_back(p);
    }
    all.back().image_width = all.back().image_height = all.back().spp = 1;
    return all;
}

PipelineInput tiny_input(const reference::PipelineParameters& p) {
    const reference::Scene scene = scenes::load_scene("cornell");
    return {scene, build_wide_bvh(scene, bvh_parameters(p, 1)), p};
}

std::string said(const std::vector<Failure>& failures) {
    std::string text;
    for (const Failure& failure : failures) text += failure.stage + ": " + failure.sentence + "\n";
    return text;
}

std::vector<reference::Ray> camera_rays() {
    const reference::Scene scene = scenes::load_scene("cornell");
    const reference::Ray forward{scene.camera.position, 0.0f, scene.camera.forward,
                                 reference::kInfinity};
    return {forward, forward, forward};
}

}  // namespace

TEST_CASE("run refusals: the emulator and the CUDA text refuse each by its name",
          "[verify][replay]") {
    for (const char* name : {"emulator", "simt"}) {
        const Backend backend = backend_named(name, 1);
        std::vector<reference::PipelineParameters> all = tiny_pictures();
        for (reference::PipelineParameters p : tiny_pictures()) {
            p.queues = reference::QueueKind::pairs;
            all.push_back(p);
        }
        for (const reference::PipelineParameters& p : all) {
            CAPTURE(name, to_string(p.early_out), to_string(p.queues));
            const PipelineInput input = tiny_input(p);
            const TemporaryCapture capture(backend, input);
            CHECK(said(check_stage_refusals(capture.get(), backend)) == "");
            CHECK(said(check_ray_refusals(input, backend, camera_rays())) == "");
            CHECK(said(check_queue_refusal(input, backend, camera_rays())) == "");
        }
    }
}

TEST_CASE("run refusals: a pipeline that believes all is seen in every kind of launch",
          "[verify][replay]") {
    const Backend credulous = with_errors(believe_all_launches);
    std::set<std::string> kinds;
    std::set<std::string> needed;
    for (const reference::PipelineParameters& p : tiny_pictures()) {
        const PipelineInput input = tiny_input(p);
        const TemporaryCapture capture(emulator_of_refusals(), input);
        for (const Failure& failure : check_stage_refusals(capture.get(), credulous)) {
            kinds.insert(failure.stage.substr(failure.stage.rfind('/') + 1));
        }
        for (const StageRecord& stage : capture.get().stages()) {
            needed.insert(stage.name.substr(stage.name.rfind('/') + 1));
        }
        CHECK(check_ray_refusals(input, credulous, camera_rays()).size() == 22);
        CHECK(check_queue_refusal(input, credulous, camera_rays()).size() == 1);
    }
    CHECK(kinds == needed);
}

TEST_CASE("run refusals: errors that do not name what is wrong are seen", "[verify][replay]") {
    const Backend vague = with_errors(name_nothing);
    const PipelineInput input = tiny_input(tiny_pictures().front());
    const TemporaryCapture capture(emulator_of_refusals(), input);
    CHECK(check_stage_refusals(capture.get(), vague).size() > 50);
    CHECK(check_ray_refusals(input, vague, camera_rays()).size() == 22);
    CHECK(check_queue_refusal(input, vague, camera_rays()).size() == 1);
}

}  // namespace scotty::verify::test
