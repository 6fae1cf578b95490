#include "emulation/host/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "emulation/host/launch_log.h"
#include "emulation/host/path_state.h"
#include "emulation/host/traversal.h"
#include "emulation/kernels/direct_light_rays.h"
#include "emulation/kernels/filter_image.h"
#include "emulation/kernels/primary_rays.h"
#include "emulation/kernels/reconstruct_image.h"
#include "emulation/kernels/resolve_light.h"
#include "emulation/kernels/scene_rays.h"
#include "reference/base/assert.h"
#include "reference/base/memory.h"
#include "reference/contract/stage_inputs.h"
#include "reference/contract/staged_pipeline.h"

namespace scotty::emulation {

namespace buffers = reference::buffers;
using reference::Hit;
using reference::PipelineParameters;
using reference::Ray;
using reference::StageKind;
using reference::StageView;
using reference::Vec3;

namespace {

constexpr std::uint32_t kItemThreads = 256;

}  // namespace

class Pipeline::State final : public reference::StagedPipeline {
 public:
    State(const reference::Scene& scene, const reference::WideBvh& bvh,
          const PipelineParameters& parameters, const DeviceOptions& device,
          reference::StageObserver* observer)
        : StagedPipeline(parameters, reference::view_of(scene).triangle_count),
          scene_(reference::view_of(scene)),
          path_(reference::path_parameters(parameters)),
          device_(device),
          log_(observer),
          traversal_(scene, bvh, parameters_, device_, log_),
          paths_(device_) {
        SCOTTY_ASSERT(bvh.width, ==, parameters.width);
    }

    reference::Image render() override;
    void trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) override;
    double time_trace(std::span<const Ray> rays, TraversalKind kind, int repeats) override;
    const std::vector<LaunchRecord>& launches() override { return log_.records(); }
    void clear_launches() override { log_.clear(); }
    std::size_t device_bytes() const override { return traversal_.device_bytes() + paths_.bytes(); }

 private:
    reference::StageLog& log() override { return log_; }
    void take_view(const reference::Camera& camera) override {
        scene_.camera = camera;
        path_ = reference::path_parameters(parameters_);
    }
    void resize_paths(std::size_t rays) override { paths_.resize(rays); }
    void launch_primary_rays(const StagePlace& place, const BatchView& batch) override;
    void launch_direct_light(const StagePlace& place) override;
    void launch_resolve_light(const StagePlace& place) override;
    void launch_scene_rays(const StagePlace& place) override;
    void launch_reconstruct(const StagePlace& place, const BatchView& batch) override;
    void launch_filter() override;
    void wait() override {}  // launches return when they are complete
    void trace_paths(const StagePlace& place) override {
        traversal_.run(paths_.rays.view(), TraversalKind::closest, place, paths_.path_hits.span());
    }
    void trace_shadow_rays(const StagePlace& place, TraversalKind kind) override {
        traversal_.run(paths_.shadow_rays.view(), kind, place, paths_.shadow_hits.span());
        launch_resolve_light(place);
    }
    void load_paths(const StageView& stage, std::size_t rays) override { paths_.load(stage, rays); }
    void load_image(const StageView& stage) override;
    void run_traversal_stage(const StageView& stage) override { traversal_.run_stage(stage); }

    /// One thread for each of `threads` rays or pixels; then the stage is shown.
    template <class Kernel>
    void launch(StageKind kind, const StagePlace& place, std::uint32_t threads, std::uint64_t items,
                const Kernel& kernel) {
        const std::uint32_t blocks = (threads + kItemThreads - 1) / kItemThreads;
        log_.timed(kind, place, blocks, items, [&] { device_.launch_per_item(threads, kernel); });
        log_.show(parameters_, kind, place, blocks, kItemThreads,
                  [&](const reference::BufferInfo& buffer) { return paths_.view(buffer); });
    }

    reference::SceneView scene_;
    reference::PathParameters path_;
    Device device_;
    LaunchLog log_;
    Traversal traversal_;
    PathState paths_;
};

reference::Image Pipeline::State::render() {
    const std::uint32_t pixels = pixel_count();
    reference::require_memory(  // image and variance as the device has them and as they are handed
                                // out, and filtered
        std::uint64_t{5} * sizeof(Vec3) * pixels,
        fmt::format("the image of {}x{} pixels", parameters_.image_width, parameters_.image_height),
        "a smaller one needs less");
    for (auto* buffer : {&paths_.image, &paths_.variance}) {
        buffer->resize(pixels);
        buffer->fill(Vec3(0.0f, 0.0f, 0.0f));
    }
    launch_render();
    const auto copy = [](std::span<const Vec3> buffer) {
        return std::vector<Vec3>(buffer.begin(), buffer.end());
    };
    return {parameters_.image_width, parameters_.image_height, copy(paths_.image.view()),
            knows_variance() ? copy(paths_.variance.view()) : std::vector<Vec3>()};
}

void Pipeline::State::launch_primary_rays(const StagePlace& place, const BatchView& batch) {
    launch(StageKind::primary_rays, place, batch.pixels, paths_.count(),
           [&, paths = reference::path_view(paths_)](std::uint32_t pixel) {
               primary_rays(pixel, batch, scene_.camera, path_, paths);
           });
}

void Pipeline::State::launch_direct_light(const StagePlace& place) {
    launch(StageKind::direct_light_rays, place, paths_.count(), paths_.count(),
           [&, paths = reference::path_view(paths_)](std::uint32_t ray) {
               direct_light_rays(ray, scene_, path_, place.bounce, place.light, paths,
                                 paths_.path_hits.data(), paths_.shadow_rays.data());
           });
}

void Pipeline::State::launch_resolve_light(const StagePlace& place) {
    launch(StageKind::resolve_light, place, paths_.count(), paths_.count(),
           [&, paths = reference::path_view(paths_)](std::uint32_t ray) {
               resolve_light(ray, paths_.shadow_rays.data(), paths_.shadow_hits.data(), paths);
           });
}

void Pipeline::State::launch_scene_rays(const StagePlace& place) {
    launch(StageKind::scene_rays, place, paths_.count(), paths_.count(),
           [&, paths = reference::path_view(paths_)](std::uint32_t ray) {
               scene_rays(ray, scene_, path_, place.bounce, paths_.path_hits.data(), paths);
           });
}

void Pipeline::State::launch_reconstruct(const StagePlace& place, const BatchView& batch) {
    launch(StageKind::reconstruct_image, place, batch.pixels, paths_.count(),
           [&](std::uint32_t pixel) {
               reconstruct_image(pixel, batch, parameters_.spp, paths_.radiance.data(),
                                 paths_.image.data(), paths_.variance.data());
           });
}

void Pipeline::State::launch_filter() {
    paths_.filtered.resize(pixel_count());
    const FilterView view{parameters_.image_width, parameters_.image_height, paths_.image.data(),
                          paths_.filtered.data()};
    launch(StageKind::filter, {}, pixel_count(), pixel_count(),
           [&](std::uint32_t pixel) { filter_image(pixel, parameters_.filter, view); });
    std::swap(paths_.image, paths_.filtered);
}

void Pipeline::State::load_image(const StageView& stage) {
    const reference::StageBuffers in(stage);
    paths_.image.assign(in.input(buffers::image, pixel_count()));
    if (!reference::reads(stage.kind, buffers::variance)) return;
    paths_.variance.assign(in.input(buffers::variance, pixel_count()));
}

void Pipeline::State::trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) {
    SCOTTY_ASSERT(rays.size(), ==, hits.size());
    expect_traceable(rays);
    StagePlace place;
    place.several_batches = rays.size() > parameters_.batch_rays;
    for (std::size_t first = 0; first < rays.size(); first += parameters_.batch_rays) {
        const std::size_t count =
            std::min<std::size_t>(parameters_.batch_rays, rays.size() - first);
        traversal_.run(rays.subspan(first, count), kind, place, hits.subspan(first, count));
        ++place.batch;
    }
}

double Pipeline::State::time_trace(std::span<const Ray> rays, TraversalKind kind, int repeats) {
    std::vector<Hit> hits(rays.size());
    std::vector<double> seconds;
    for (int round = -2; round < repeats; ++round) {
        const auto start = std::chrono::steady_clock::now();
        trace(rays, kind, hits);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        if (round >= 0) seconds.push_back(taken.count());
    }
    std::sort(seconds.begin(), seconds.end());
    return seconds[seconds.size() / 2];
}

Pipeline::Pipeline(const reference::Scene& scene, const reference::WideBvh& bvh,
                   const PipelineParameters& parameters, const DeviceOptions& device,
                   reference::StageObserver* observer)
    : state_(std::make_unique<State>(scene, bvh, parameters, device, observer)) {}
Pipeline::~Pipeline() = default;

reference::Image Pipeline::render() { return state_->render(); }
void Pipeline::look(const reference::Camera& camera, const PipelineParameters& parameters) {
    state_->look(camera, parameters);
}
void Pipeline::trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) {
    state_->trace(rays, kind, hits);
}
double Pipeline::time_trace(std::span<const Ray> rays, TraversalKind kind, int repeats) {
    return state_->time_trace(rays, kind, repeats);
}
std::vector<reference::OwnedBuffer> Pipeline::run_stage(const StageView& stage) {
    return state_->run_stage(stage);
}
const std::vector<LaunchRecord>& Pipeline::launches() { return state_->launches(); }
void Pipeline::clear_launches() { state_->clear_launches(); }
std::size_t Pipeline::device_bytes() const { return state_->device_bytes(); }

}  // namespace scotty::emulation
