#include "emulation/host/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
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
#include "reference/contract/stage_inputs.h"

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
    std::vector<reference::OwnedBuffer> run_stage(const StageView& stage);
    LaunchLog& log() { return log_; }
    std::size_t device_bytes();

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
    /// Launches it, on inputs that are read from its view.
    void launch_alone(const StageView& stage);
    /// What the stage reads of path state is taken from its view, the rest has the size of it.
    void load_paths(const StageView& stage, std::size_t rays);
    void load_image(const StageView& stage);
    /// Calls f(handle, buffer) for every buffer that has a row per ray.
    template <class F>
    void for_each_by_ray(const F& f) {
        f(buffers::rays, rays_);
        f(buffers::shadow_rays, shadow_rays_);
        f(buffers::throughput, throughput_);
        f(buffers::radiance, radiance_);
        f(buffers::potential, potential_);
        f(buffers::pixel, pixel_);
        f(buffers::sample, sample_);
        f(buffers::depth, depth_);
        f(buffers::flags, flags_);
        f(buffers::path_hits, path_hits_);
        f(buffers::shadow_hits, shadow_hits_);
    }
    void resize(std::size_t rays) {
        for_each_by_ray([&](const auto&, auto& buffer) { buffer.resize(rays); });
    }
    std::uint32_t pixel_count() const { return parameters_.image_width * parameters_.image_height; }
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
    DeviceBuffer<Vec3> image_{device_, "the image"}, variance_{device_, "the image's variance"};
    DeviceBuffer<Vec3> filtered_{device_, "the filtered image"};
};

reference::Image Pipeline::State::render() {
    const std::uint32_t pixels = pixel_count();
    reference::require_memory(  // image and variance as the device has them and as they are handed
                                // out, and filtered
        std::uint64_t{5} * sizeof(Vec3) * pixels,
        fmt::format("the image of {}x{} pixels", parameters_.image_width, parameters_.image_height),
        "a smaller one needs less");
    image_.resize(pixels);
    image_.fill(Vec3(0.0f, 0.0f, 0.0f));
    variance_.resize(pixels);
    variance_.fill(Vec3(0.0f, 0.0f, 0.0f));

    const reference::BatchPlan plan(parameters_);
    StagePlace place;
    place.several_batches = plan.size() > 1;
    for (; place.batch < plan.size(); ++place.batch) {
        log_.batch(place.batch, plan.size());
        render_batch(place, plan[place.batch]);
    }
    log_.batch(plan.size(), plan.size());
    const bool filters =
        parameters_.filter != Filter::none && parameters_.spp < parameters_.filter_threshold;
    if (filters) launch_filter();
    const auto copy = [](std::span<const Vec3> buffer) {
        return std::vector<Vec3>(buffer.begin(), buffer.end());
    };
    // Neighbours that a filter mixes share their noise: nothing is known of it.
    const bool known = !filters && parameters_.spp > 1;
    return {parameters_.image_width, parameters_.image_height, copy(image_.view()),
            known ? copy(variance_.view()) : std::vector<Vec3>()};
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
            reconstruct_image(pixel, batch, parameters_.spp, radiance_.data(), image_.data(),
                              variance_.data());
        });
    });
    show_paths(StageKind::reconstruct_image, place,
               {buffer_view(buffers::radiance, radiance_.view()),
                buffer_view(buffers::pixel, pixel_.view())},
               {buffer_view(buffers::image, image_.view()),
                buffer_view(buffers::variance, variance_.view())},
               batch.pixels);
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

std::vector<reference::OwnedBuffer> Pipeline::State::run_stage(const StageView& stage) {
    reference::StageOutputs outputs;
    reference::StageObserver* const observer = log_.exchange_observer(&outputs);
    try {
        launch_alone(stage);
    } catch (...) {
        log_.exchange_observer(observer);
        throw;
    }
    log_.exchange_observer(observer);
    return std::move(outputs).take();
}

void Pipeline::State::launch_alone(const StageView& stage) {
    const reference::StageBuffers in(stage);
    const StagePlace place = reference::place_of(stage);
    BatchView batch;
    switch (stage.kind) {
        case StageKind::primary_rays:
            batch = reference::batch_of(parameters_, stage);
            resize(std::size_t{batch.pixels} * batch.samples);
            launch_primary_rays(place, batch);
            break;
        case StageKind::direct_light_rays:
            load_paths(stage, in.input(buffers::rays).size());
            launch_direct_light(place);
            break;
        case StageKind::resolve_light:
            load_paths(stage, in.input(buffers::shadow_rays).size());
            launch_resolve_light(place);
            break;
        case StageKind::scene_rays:
            load_paths(stage, in.input(buffers::rays).size());
            launch_scene_rays(place);
            break;
        case StageKind::reconstruct_image:
            batch = reference::batch_of(parameters_, stage);
            load_paths(stage, std::size_t{batch.pixels} * batch.samples);
            load_image(stage);
            variance_.assign(in.input(buffers::variance, pixel_count()));
            launch_reconstruct(place, batch);
            break;
        case StageKind::filter:
            load_image(stage);
            launch_filter();
            break;
        default:
            traversal_.run_stage(stage);
            break;
    }
}

void Pipeline::State::load_paths(const StageView& stage, std::size_t rays) {
    const reference::StageBuffers in(stage);
    for_each_by_ray([&](const auto& buffer, auto& memory) {
        memory.resize(rays);
        if (reference::reads(stage.kind, buffer)) memory.assign(in.input(buffer, rays));
    });
    if (reference::reads(stage.kind, buffers::path_hits)) {
        reference::path_hits_of_scene(in, rays, scene_.triangle_count);
    }
}

void Pipeline::State::load_image(const StageView& stage) {
    image_.assign(reference::StageBuffers(stage).input(buffers::image, pixel_count()));
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

std::size_t Pipeline::State::device_bytes() {
    std::size_t bytes =
        traversal_.device_bytes() + image_.bytes() + variance_.bytes() + filtered_.bytes();
    for_each_by_ray([&](const auto&, const auto& buffer) { bytes += buffer.bytes(); });
    return bytes;
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

double Pipeline::time_trace(std::span<const Ray> rays, TraversalKind kind, int repeats) {
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

std::vector<reference::OwnedBuffer> Pipeline::run_stage(const StageView& stage) {
    return state_->run_stage(stage);
}

const std::vector<LaunchRecord>& Pipeline::launches() { return state_->log().records(); }
void Pipeline::clear_launches() { state_->log().clear(); }
std::size_t Pipeline::device_bytes() const { return state_->device_bytes(); }

}  // namespace scotty::emulation
