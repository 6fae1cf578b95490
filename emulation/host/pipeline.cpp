#include "emulation/host/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "emulation/device/device_buffer.h"
#include "emulation/host/launch_log.h"
#include "emulation/host/traversal.h"
#include "emulation/kernels/direct_light_rays.h"
#include "emulation/kernels/filter_bilateral.h"
#include "emulation/kernels/filter_gaussian.h"
#include "emulation/kernels/filter_median.h"
#include "emulation/kernels/primary_rays.h"
#include "emulation/kernels/reconstruct_image.h"
#include "emulation/kernels/resolve_light.h"
#include "emulation/kernels/scene_rays.h"
#include "reference/base/assert.h"
#include "reference/base/memory.h"
#include "reference/contract/batch_plan.h"

namespace scotty::emulation {

namespace buffers = reference::buffers;
using reference::buffer_view;
using reference::Filter;
using reference::Hit;
using reference::PipelineParameters;
using reference::Ray;
using reference::StageKind;
using reference::StageView;
using reference::Vec3;

namespace {

std::uint32_t blocks_for(std::uint32_t items) { return (items + 255) / 256; }

bool finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Rays from elsewhere may hold anything; what the kernels rely on is checked here.
void check_ray(const Ray& ray, std::size_t index) {
    const char* fault = nullptr;
    if (!finite(ray.origin)) fault = "its origin is not finite";
    if (!finite(ray.direction)) fault = "its direction is not finite";
    if (reference::is_zero(ray.direction)) fault = "its direction is zero";
    if (!(ray.t_min >= 0.0f)) fault = "its t_min is negative or NaN";
    if (std::isnan(ray.t_max)) fault = "its t_max is NaN";
    if (fault != nullptr) {
        throw reference::Error::bad_input(fmt::format("ray {}", index), fault);
    }
}

}  // namespace

class Pipeline::State {
 public:
    State(const reference::Scene& scene, const reference::WideBvh& bvh,
          const PipelineParameters& parameters, const DeviceOptions& device,
          reference::StageObserver* observer)
        : scene_(reference::view_of(scene)),
          parameters_(parameters),
          path_(reference::path_parameters(parameters)),
          device_(device),
          log_(observer),
          traversal_(scene, bvh, parameters_, device_, log_) {
        reference::validate(parameters_);
        SCOTTY_ASSERT(bvh.width, ==, parameters.width);
    }

    reference::Image render();
    void trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits);
    LaunchLog& log() { return log_; }
    std::size_t device_bytes() const;

 private:
    void render_batch(StagePlace place, const BatchView& batch);
    void shade_vertex(StagePlace place);
    void launch_primary_rays(const StagePlace& place, const BatchView& batch);
    void launch_direct_light(const StagePlace& place);
    void launch_resolve_light(const StagePlace& place);
    void launch_scene_rays(const StagePlace& place);
    void launch_reconstruct(const StagePlace& place, const BatchView& batch);
    void launch_filter();
    void show_paths(StageKind kind, const StagePlace& place,
                    std::vector<reference::BufferView> inputs,
                    std::vector<reference::BufferView> outputs, std::uint32_t threads_total);
    void resize(std::size_t rays);
    PathView paths() {
        return {rays_.data(),  throughput_.data(), radiance_.data(), potential_.data(),
                pixel_.data(), sample_.data(),     depth_.data(),    flags_.data()};
    }
    std::uint32_t ray_count() const { return static_cast<std::uint32_t>(rays_.size()); }

    reference::SceneView scene_;
    PipelineParameters parameters_;
    reference::PathParameters path_;
    Device device_;
    LaunchLog log_;
    Traversal traversal_;

    DeviceBuffer<Ray> rays_{device_, "rays"}, shadow_rays_{device_, "shadow rays"};
    DeviceBuffer<Vec3> throughput_{device_, "throughput"}, radiance_{device_, "radiance"};
    DeviceBuffer<Vec3> potential_{device_, "potential radiance"};
    DeviceBuffer<std::uint32_t> pixel_{device_, "pixels"}, sample_{device_, "samples"};
    DeviceBuffer<std::uint32_t> depth_{device_, "depths"}, flags_{device_, "flags"};
    DeviceBuffer<Hit> path_hits_{device_, "path hits"}, shadow_hits_{device_, "shadow hits"};
    DeviceBuffer<Vec3> image_{device_, "the image"}, filtered_{device_, "the filtered image"};
};

reference::Image Pipeline::State::render() {
    const std::uint32_t pixels = parameters_.image_width * parameters_.image_height;
    reference::require_memory(  // as the device has it, filtered, and as it is handed out
        std::uint64_t{3} * sizeof(Vec3) * pixels,
        fmt::format("the image of {}x{} pixels", parameters_.image_width, parameters_.image_height),
        "a smaller one needs less");
    image_.resize(pixels);
    image_.fill(Vec3(0.0f, 0.0f, 0.0f));

    const reference::BatchPlan plan(parameters_);
    StagePlace place;
    place.several_batches = plan.size() > 1;
    for (; place.batch < plan.size(); ++place.batch) render_batch(place, plan[place.batch]);
    if (parameters_.filter != Filter::none && parameters_.spp < parameters_.filter_threshold) {
        launch_filter();
    }
    return {parameters_.image_width, parameters_.image_height,
            std::vector<Vec3>(image_.view().begin(), image_.view().end())};
}

void Pipeline::State::render_batch(StagePlace place, const BatchView& batch) {
    resize(std::size_t{batch.pixels} * batch.samples);
    launch_primary_rays(place, batch);
    place.bounce = 0;
    traversal_.run(rays_.view(), TraversalKind::closest, place, path_hits_.span());
    for (; place.bounce <= parameters_.bounces; ++place.bounce) shade_vertex(place);
    place.bounce = reference::kNotApplicable;
    launch_reconstruct(place, batch);
}

void Pipeline::State::shade_vertex(StagePlace place) {
    const TraversalKind query = parameters_.shadow_query == reference::ShadowQuery::any
                                    ? TraversalKind::any
                                    : TraversalKind::closest;
    for (std::uint32_t light = 0; light < parameters_.light_samples; ++light) {
        place.light = light;
        launch_direct_light(place);
        traversal_.run(shadow_rays_.view(), query, place, shadow_hits_.span());
        launch_resolve_light(place);
    }
    place.light = reference::kNotApplicable;
    launch_scene_rays(place);
    if (place.bounce == parameters_.bounces) return;
    ++place.bounce;
    traversal_.run(rays_.view(), TraversalKind::closest, place, path_hits_.span());
}

void Pipeline::State::launch_primary_rays(const StagePlace& place, const BatchView& batch) {
    log_.timed(StageKind::primary_rays, place, blocks_for(batch.pixels), ray_count(), [&] {
        device_.launch_per_item(batch.pixels, [&](std::uint32_t pixel) {
            primary_rays(pixel, batch, scene_.camera, path_, paths());
        });
    });
    show_paths(
        StageKind::primary_rays, place, {},
        {buffer_view(buffers::rays, rays_.view()),
         buffer_view(buffers::throughput, throughput_.view()),
         buffer_view(buffers::radiance, radiance_.view()),
         buffer_view(buffers::potential, potential_.view()),
         buffer_view(buffers::pixel, pixel_.view()), buffer_view(buffers::sample, sample_.view()),
         buffer_view(buffers::depth, depth_.view()), buffer_view(buffers::flags, flags_.view())},
        batch.pixels);
}

void Pipeline::State::launch_direct_light(const StagePlace& place) {
    log_.timed(StageKind::direct_light_rays, place, blocks_for(ray_count()), ray_count(), [&] {
        device_.launch_per_item(ray_count(), [&](std::uint32_t ray) {
            direct_light_rays(ray, scene_, path_, place.bounce, place.light, paths(),
                              path_hits_.data(), shadow_rays_.data());
        });
    });
    show_paths(StageKind::direct_light_rays, place,
               {buffer_view(buffers::rays, rays_.view()),
                buffer_view(buffers::path_hits, path_hits_.view()),
                buffer_view(buffers::throughput, throughput_.view()),
                buffer_view(buffers::flags, flags_.view())},
               {buffer_view(buffers::shadow_rays, shadow_rays_.view()),
                buffer_view(buffers::potential, potential_.view())},
               ray_count());
}

void Pipeline::State::launch_resolve_light(const StagePlace& place) {
    log_.timed(StageKind::resolve_light, place, blocks_for(ray_count()), ray_count(), [&] {
        device_.launch_per_item(ray_count(), [&](std::uint32_t ray) {
            resolve_light(ray, shadow_rays_.data(), shadow_hits_.data(), paths());
        });
    });
    show_paths(StageKind::resolve_light, place,
               {buffer_view(buffers::shadow_rays, shadow_rays_.view()),
                buffer_view(buffers::shadow_hits, shadow_hits_.view()),
                buffer_view(buffers::potential, potential_.view())},
               {buffer_view(buffers::radiance, radiance_.view())}, ray_count());
}

void Pipeline::State::launch_scene_rays(const StagePlace& place) {
    log_.timed(StageKind::scene_rays, place, blocks_for(ray_count()), ray_count(), [&] {
        device_.launch_per_item(ray_count(), [&](std::uint32_t ray) {
            scene_rays(ray, scene_, path_, place.bounce, path_hits_.data(), paths());
        });
    });
    show_paths(
        StageKind::scene_rays, place, {buffer_view(buffers::path_hits, path_hits_.view())},
        {buffer_view(buffers::rays, rays_.view()),
         buffer_view(buffers::throughput, throughput_.view()),
         buffer_view(buffers::radiance, radiance_.view()),
         buffer_view(buffers::flags, flags_.view()), buffer_view(buffers::depth, depth_.view())},
        ray_count());
}

void Pipeline::State::launch_reconstruct(const StagePlace& place, const BatchView& batch) {
    log_.timed(StageKind::reconstruct_image, place, blocks_for(batch.pixels), ray_count(), [&] {
        device_.launch_per_item(batch.pixels, [&](std::uint32_t pixel) {
            reconstruct_image(pixel, batch, parameters_.spp, radiance_.data(), image_.data());
        });
    });
    show_paths(StageKind::reconstruct_image, place,
               {buffer_view(buffers::radiance, radiance_.view()),
                buffer_view(buffers::pixel, pixel_.view())},
               {buffer_view(buffers::image, image_.view())}, batch.pixels);
}

void Pipeline::State::launch_filter() {
    filtered_.resize(image_.size());
    const FilterView view{parameters_.image_width, parameters_.image_height, image_.data(),
                          filtered_.data()};
    const auto pixels = static_cast<std::uint32_t>(image_.size());
    log_.timed(StageKind::filter, {}, blocks_for(pixels), pixels, [&] {
        device_.launch_per_item(pixels, [&](std::uint32_t pixel) {
            switch (parameters_.filter) {
                case Filter::gaussian:
                    filter_gaussian(pixel, view);
                    break;
                case Filter::bilateral:
                    filter_bilateral(pixel, view);
                    break;
                default:
                    filter_median(pixel, view);
                    break;
            }
        });
    });
    if (log_.wants(StageKind::filter)) {
        StageView stage = log_.stage(StageKind::filter, {}, blocks_for(pixels), 256);
        stage.name = std::string("filter_") + reference::to_string(parameters_.filter);
        stage.inputs = {buffer_view(buffers::image, image_.view())};
        stage.outputs = {buffer_view(buffers::filtered, filtered_.view())};
        log_.show(stage);
    }
    std::swap(image_, filtered_);
}

void Pipeline::State::show_paths(StageKind kind, const StagePlace& place,
                                 std::vector<reference::BufferView> inputs,
                                 std::vector<reference::BufferView> outputs,
                                 std::uint32_t threads_total) {
    if (!log_.wants(kind)) return;
    StageView stage = log_.stage(kind, place, blocks_for(threads_total), 256);
    stage.inputs = std::move(inputs);
    stage.outputs = std::move(outputs);
    log_.show(stage);
}

void Pipeline::State::resize(std::size_t rays) {
    rays_.resize(rays);
    shadow_rays_.resize(rays);
    throughput_.resize(rays);
    radiance_.resize(rays);
    potential_.resize(rays);
    pixel_.resize(rays);
    sample_.resize(rays);
    depth_.resize(rays);
    flags_.resize(rays);
    path_hits_.resize(rays);
    shadow_hits_.resize(rays);
}

void Pipeline::State::trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) {
    SCOTTY_ASSERT(rays.size(), ==, hits.size());
    for (std::size_t i = 0; i < rays.size(); ++i) check_ray(rays[i], i);
    StagePlace place;
    place.several_batches = rays.size() > parameters_.batch_rays;
    for (std::size_t first = 0; first < rays.size(); first += parameters_.batch_rays) {
        const std::size_t count =
            std::min<std::size_t>(parameters_.batch_rays, rays.size() - first);
        traversal_.run(rays.subspan(first, count), kind, place, hits.subspan(first, count));
        ++place.batch;
    }
}

std::size_t Pipeline::State::device_bytes() const {
    return traversal_.device_bytes() + rays_.bytes() + shadow_rays_.bytes() + throughput_.bytes() +
           radiance_.bytes() + potential_.bytes() + pixel_.bytes() + sample_.bytes() +
           depth_.bytes() + flags_.bytes() + path_hits_.bytes() + shadow_hits_.bytes() +
           image_.bytes() + filtered_.bytes();
}

Pipeline::Pipeline(const reference::Scene& scene, const reference::WideBvh& bvh,
                   const PipelineParameters& parameters, const DeviceOptions& device,
                   reference::StageObserver* observer)
    : state_(std::make_unique<State>(scene, bvh, parameters, device, observer)) {}
Pipeline::~Pipeline() = default;

reference::Image Pipeline::render() { return state_->render(); }

void Pipeline::trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) {
    state_->trace(rays, kind, hits);
}

const std::vector<LaunchRecord>& Pipeline::launches() const { return state_->log().records(); }
void Pipeline::clear_launches() { state_->log().clear(); }
std::size_t Pipeline::device_bytes() const { return state_->device_bytes(); }

}  // namespace scotty::emulation
