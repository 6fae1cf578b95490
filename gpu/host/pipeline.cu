#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "gpu/host/path_state.h"
#include "gpu/host/pipeline_build.h"
#include "gpu/host/traversal.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/direct_light_rays.h"
#include "gpu/kernels/filter_bilateral.h"
#include "gpu/kernels/filter_gaussian.h"
#include "gpu/kernels/filter_median.h"
#include "gpu/kernels/primary_rays.h"
#include "gpu/kernels/reconstruct_image.h"
#include "gpu/kernels/resolve_light.h"
#include "gpu/kernels/scene_rays.h"
#include "reference/base/assert.h"
#include "reference/contract/batch_plan.h"

namespace SCOTTY_DEVICE_NAMESPACE {

using reference::buffer_view;
using reference::Filter;
using reference::Hit;
using reference::PipelineParameters;
using reference::Ray;
using reference::StageKind;
using reference::StagePlace;
using reference::StageView;
using reference::Vec3;

namespace {

constexpr std::uint32_t kSmallestBatch = 1024;

PipelineParameters checked(const PipelineParameters& parameters) {
    reference::validate(parameters);
    return parameters;
}

/// Whether most rays go much the same way as the first of their warp: looked up in 64 warps.
bool are_coherent(std::span<const Ray> rays) {
    const std::size_t warps = rays.size() / kWarpSize;
    const std::size_t step = std::max<std::size_t>(1, warps / 64);
    std::size_t near = 0;
    std::size_t seen = 0;
    for (std::size_t warp = 0; warp < warps; warp += step) {
        const Vec3& first = rays[warp * kWarpSize].direction;
        for (std::size_t i = 0; i < kWarpSize; ++i) {
            const Vec3& direction = rays[warp * kWarpSize + i].direction;
            const float along = reference::dot(first, direction);
            near += along > 0.0f && along * along > 0.5f * reference::dot(first, first) *
                                                        reference::dot(direction, direction);
            ++seen;
        }
    }
    return 4 * near >= 3 * seen;
}

class Stream {
 public:
    Stream() { check(cudaStreamCreate(&stream_), "creating a stream"); }
    ~Stream() { cudaStreamDestroy(stream_); }
    Stream(const Stream&) = delete;
    Stream& operator=(const Stream&) = delete;
    cudaStream_t get() const { return stream_; }

 private:
    cudaStream_t stream_ = nullptr;
};

class DevicePipeline final : public Pipeline {
 public:
    DevicePipeline(const reference::Scene& scene, const reference::WideBvh& bvh,
                   const PipelineParameters& parameters, const PipelineOptions& options,
                   reference::StageObserver* observer)
        : parameters_(checked(parameters)),
          budget_{options.memory_limit, 0},
          scene_(scene, bvh, budget_),
          log_(observer, options.timings),
          paths_(budget_),
          traversal_(scene_, parameters_, budget_, log_, stream_.get()),
          trace_rays_(budget_),
          trace_hits_(budget_) {
        SCOTTY_ASSERT(bvh.width, ==, parameters.width);
        path_ = reference::path_parameters(parameters);
    }

    reference::Image render() override;
    void trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) override;
    double time_trace(std::span<const Ray> rays, TraversalKind kind, int repeats) override;
    std::vector<reference::OwnedBuffer> run_stage(const StageView& stage) override;
    const std::vector<LaunchRecord>& launches() override {
        log_.resolve_times();
        return log_.records();
    }
    void clear_launches() override {
        log_.resolve_times();
        log_.records().clear();
    }
    std::size_t device_bytes() const override { return budget_.used; }

 private:
    bool filters() const {
        return parameters_.filter != Filter::none && parameters_.spp < parameters_.filter_threshold;
    }
    void render_in_batches();
    void render_batch(StagePlace place, const BatchView& batch);
    void shade_vertex(StagePlace place);
    void launch_primary_rays(const StagePlace& place, const BatchView& batch);
    void launch_direct_light(const StagePlace& place);
    void launch_resolve_light(const StagePlace& place);
    void launch_scene_rays(const StagePlace& place);
    void launch_reconstruct(const StagePlace& place, const BatchView& batch);
    void launch_filter();
    /// Launches it, on inputs that are read from its view.
    void launch_alone(const StageView& stage);
    void load_image(const StageView& stage);
    /// Shows the buffers that the stage's table names.
    void show(StageKind kind, const StagePlace& place, std::uint32_t threads);

    PipelineParameters parameters_;
    reference::PathParameters path_;
    MemoryBudget budget_;
    Stream stream_;
    DeviceScene scene_;
    LaunchLog log_;
    PathState paths_;
    Traversal traversal_;
    DeviceMemory<Ray> trace_rays_;
    DeviceMemory<Hit> trace_hits_;
    PinnedMemory<Vec3> picture_;
};

reference::Image DevicePipeline::render() {
    for (;;) {
        try {
            render_in_batches();
            break;
        } catch (const OutOfDeviceMemory& error) {
            if (parameters_.batch_rays <= kSmallestBatch) throw;
            cudaStreamSynchronize(stream_.get());
            traversal_.release();
            paths_.release();
            parameters_.batch_rays /= 2;
            log_.retry("", std::string(error.what()) + "; again with batches of " +
                               std::to_string(parameters_.batch_rays) + " rays");
        }
    }
    const std::size_t pixels = std::size_t{parameters_.image_width} * parameters_.image_height;
    // Neighbours that a filter mixes share their noise: nothing is known of it.
    const bool known = !filters() && parameters_.spp > 1;
    return {parameters_.image_width, parameters_.image_height,
            picture_.download(paths_.image.data(), pixels, "the image"),
            picture_.download(paths_.variance.data(), known ? pixels : 0, "the image's variance")};
}

void DevicePipeline::render_in_batches() {
    const std::uint32_t pixels = parameters_.image_width * parameters_.image_height;
    const reference::BatchPlan plan(parameters_);
    StagePlace place;
    place.several_batches = plan.size() > 1;
    paths_.image.resize(pixels, "the image");
    // Observers see all of it after every batch.
    paths_.variance.resize(pixels, "the image's variance");
    check(cudaMemsetAsync(paths_.image.data(), 0, pixels * sizeof(Vec3), stream_.get()),
          "clearing the image");
    check(cudaMemsetAsync(paths_.variance.data(), 0, pixels * sizeof(Vec3), stream_.get()),
          "clearing the image's variance");
    for (; place.batch < plan.size(); ++place.batch) {
        log_.batch(place.batch, plan.size(), stream_.get());
        render_batch(place, plan[place.batch]);
    }
    log_.batch(plan.size(), plan.size(), stream_.get());
    if (filters()) launch_filter();
    check(cudaStreamSynchronize(stream_.get()), "rendering");
}

void DevicePipeline::render_batch(StagePlace place, const BatchView& batch) {
    paths_.resize(batch.pixels * batch.samples);
    launch_primary_rays(place, batch);
    place.bounce = 0;
    traversal_.run({paths_.rays.data(), paths_.count(), TraversalKind::closest, true}, place,
                   {paths_.path_hits.data()});
    for (; place.bounce <= parameters_.bounces; ++place.bounce) shade_vertex(place);
    place.bounce = reference::kNotApplicable;
    launch_reconstruct(place, batch);
}

void DevicePipeline::shade_vertex(StagePlace place) {
    const TraversalKind query = parameters_.shadow_query == reference::ShadowQuery::any
                                    ? TraversalKind::any
                                    : TraversalKind::closest;
    for (std::uint32_t light = 0; light < parameters_.light_samples; ++light) {
        place.light = light;
        launch_direct_light(place);
        const TracedRays shadow{paths_.shadow_rays.data(), paths_.count(), query,
                                place.bounce == 0};
        if (traversal_.is_one_launch()) {
            traversal_.run(shadow, place,
                           {nullptr, paths_.potential.data(), paths_.radiance.data()});
        } else {
            traversal_.run(shadow, place, {paths_.shadow_hits.data()});
            launch_resolve_light(place);
        }
    }
    place.light = reference::kNotApplicable;
    launch_scene_rays(place);
    if (place.bounce == parameters_.bounces) return;
    ++place.bounce;
    traversal_.run({paths_.rays.data(), paths_.count(), TraversalKind::closest, false}, place,
                   {paths_.path_hits.data()});
}

void DevicePipeline::launch_primary_rays(const StagePlace& place, const BatchView& batch) {
    log_.run(StageKind::primary_rays, place, item_blocks(batch.pixels), paths_.count(),
             stream_.get(), [&] {
                 SCOTTY_LAUNCH(primary_rays, item_blocks(batch.pixels), kItemThreads, stream_.get(),
                               batch, scene_.view().camera, path_, paths_.view());
             });
    show(StageKind::primary_rays, place, batch.pixels);
}

void DevicePipeline::launch_direct_light(const StagePlace& place) {
    const std::uint32_t count = paths_.count();
    log_.run(StageKind::direct_light_rays, place, item_blocks(count), count, stream_.get(), [&] {
        SCOTTY_LAUNCH(direct_light_rays, item_blocks(count), kItemThreads, stream_.get(), count,
                      scene_.view(), path_, place.bounce, place.light, paths_.view(),
                      paths_.path_hits.data(), paths_.shadow_rays.data());
    });
    show(StageKind::direct_light_rays, place, count);
}

void DevicePipeline::launch_resolve_light(const StagePlace& place) {
    const std::uint32_t count = paths_.count();
    log_.run(StageKind::resolve_light, place, item_blocks(count), count, stream_.get(), [&] {
        SCOTTY_LAUNCH(resolve_light, item_blocks(count), kItemThreads, stream_.get(), count,
                      paths_.shadow_rays.data(), paths_.shadow_hits.data(), paths_.view());
    });
    show(StageKind::resolve_light, place, count);
}

void DevicePipeline::launch_scene_rays(const StagePlace& place) {
    const std::uint32_t count = paths_.count();
    log_.run(StageKind::scene_rays, place, item_blocks(count), count, stream_.get(), [&] {
        SCOTTY_LAUNCH(scene_rays, item_blocks(count), kItemThreads, stream_.get(), count,
                      scene_.view(), path_, place.bounce, paths_.path_hits.data(), paths_.view());
    });
    show(StageKind::scene_rays, place, count);
}

void DevicePipeline::launch_reconstruct(const StagePlace& place, const BatchView& batch) {
    log_.run(StageKind::reconstruct_image, place, item_blocks(batch.pixels), paths_.count(),
             stream_.get(), [&] {
                 SCOTTY_LAUNCH(reconstruct_image, item_blocks(batch.pixels), kItemThreads,
                               stream_.get(), batch, parameters_.spp, paths_.radiance.data(),
                               paths_.image.data(), paths_.variance.data());
             });
    show(StageKind::reconstruct_image, place, batch.pixels);
}

void DevicePipeline::launch_filter() {
    const auto pixels = static_cast<std::uint32_t>(paths_.image.size());
    paths_.filtered.resize(pixels, "the filtered image");
    const FilterView view{parameters_.image_width, parameters_.image_height, paths_.image.data(),
                          paths_.filtered.data()};
    log_.run(StageKind::filter, {}, item_blocks(pixels), pixels, stream_.get(), [&] {
        switch (parameters_.filter) {
            case Filter::gaussian:
                SCOTTY_LAUNCH(filter_gaussian, item_blocks(pixels), kItemThreads, stream_.get(),
                              view);
                break;
            case Filter::bilateral:
                SCOTTY_LAUNCH(filter_bilateral, item_blocks(pixels), kItemThreads, stream_.get(),
                              view);
                break;
            default:
                SCOTTY_LAUNCH(filter_median, item_blocks(pixels), kItemThreads, stream_.get(),
                              view);
                break;
        }
    });
    show(StageKind::filter, {}, pixels);
    swap(paths_.image, paths_.filtered);
}

void DevicePipeline::show(StageKind kind, const StagePlace& place, std::uint32_t threads) {
    if (!log_.wants(kind)) return;
    StageView stage = log_.stage(kind, place, item_blocks(threads), kItemThreads);
    if (kind == StageKind::filter) {
        stage.name = std::string("filter_") + reference::to_string(parameters_.filter);
    }
    HostPathState host(paths_);
    const reference::StageInfo& info = reference::stage_info(kind);
    for (const auto& input : info.inputs) stage.inputs.push_back(host.view(*input.buffer));
    for (const auto& output : info.outputs) stage.outputs.push_back(host.view(*output.buffer));
    log_.show(stage);
}

std::vector<reference::OwnedBuffer> DevicePipeline::run_stage(const StageView& stage) {
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

void DevicePipeline::launch_alone(const StageView& stage) {
    const reference::StageBuffers in(stage);
    const StagePlace place = reference::place_of(stage);
    BatchView batch;
    switch (stage.kind) {
        case StageKind::primary_rays:
            batch = reference::batch_of(parameters_, stage);
            paths_.load(stage, std::size_t{batch.pixels} * batch.samples);
            launch_primary_rays(place, batch);
            break;
        case StageKind::direct_light_rays:
        case StageKind::scene_rays:
            paths_.load(stage, in.input(reference::buffers::rays).size());
            reference::path_hits_of_scene(in, paths_.count(), scene_.view().triangle_count);
            if (stage.kind == StageKind::scene_rays) {
                launch_scene_rays(place);
            } else {
                launch_direct_light(place);
            }
            break;
        case StageKind::resolve_light:
            paths_.load(stage, in.input(reference::buffers::shadow_rays).size());
            launch_resolve_light(place);
            break;
        case StageKind::reconstruct_image:
            batch = reference::batch_of(parameters_, stage);
            paths_.load(stage, std::size_t{batch.pixels} * batch.samples);
            load_image(stage);
            paths_.variance.upload(in.input(reference::buffers::variance, paths_.image.size()),
                                   "the image's variance");
            launch_reconstruct(place, batch);
            break;
        case StageKind::filter:
            load_image(stage);
            launch_filter();
            break;
        default:
            traversal_.run_stage(stage, trace_rays_, trace_hits_);
            break;
    }
}

void DevicePipeline::load_image(const StageView& stage) {
    const std::size_t pixels = std::size_t{parameters_.image_width} * parameters_.image_height;
    paths_.image.upload(reference::StageBuffers(stage).input(reference::buffers::image, pixels),
                        "the image");
}

void DevicePipeline::trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) {
    SCOTTY_ASSERT(rays.size(), ==, hits.size());
    StagePlace place;
    place.several_batches = rays.size() > parameters_.batch_rays;
    const bool coherent = are_coherent(rays);
    for (std::size_t first = 0; first < rays.size(); first += parameters_.batch_rays) {
        const std::size_t count =
            std::min<std::size_t>(parameters_.batch_rays, rays.size() - first);
        trace_rays_.upload(rays.subspan(first, count), "rays");
        trace_hits_.resize(count, "hits");
        traversal_.run({trace_rays_.data(), static_cast<std::uint32_t>(count), kind, coherent},
                       place, {trace_hits_.data()});
        check(cudaMemcpy(hits.data() + first, trace_hits_.data(), count * sizeof(Hit),
                         cudaMemcpyDeviceToHost),
              "copying hits");
        ++place.batch;
    }
}

double DevicePipeline::time_trace(std::span<const Ray> rays, TraversalKind kind, int repeats) {
    trace_rays_.upload(rays, "rays");
    trace_hits_.resize(rays.size(), "hits");
    const TracedRays traced{trace_rays_.data(), static_cast<std::uint32_t>(rays.size()), kind,
                            are_coherent(rays)};
    log_.keep_records(false);
    std::vector<double> seconds;
    cudaEvent_t begin = nullptr;
    cudaEvent_t end = nullptr;
    check(cudaEventCreate(&begin), "creating an event");
    check(cudaEventCreate(&end), "creating an event");
    for (int round = -2; round < repeats; ++round) {
        if (round < 0) {
            traversal_.run(traced, {}, {trace_hits_.data()});
            continue;
        }
        float milliseconds = 0.0f;
        check(cudaEventRecord(begin, stream_.get()), "recording an event");
        traversal_.enqueue(traced, {}, {trace_hits_.data()});
        check(cudaEventRecord(end, stream_.get()), "recording an event");
        check(cudaEventSynchronize(end), "tracing");
        check(cudaEventElapsedTime(&milliseconds, begin, end), "timing");
        seconds.push_back(1e-3 * static_cast<double>(milliseconds));
    }
    cudaEventDestroy(begin);
    cudaEventDestroy(end);
    log_.keep_records(true);
    std::sort(seconds.begin(), seconds.end());
    return seconds[seconds.size() / 2];
}

}  // namespace

std::unique_ptr<Pipeline> make_pipeline(const reference::Scene& scene,
                                        const reference::WideBvh& bvh,
                                        const PipelineParameters& parameters,
                                        const PipelineOptions& options,
                                        reference::StageObserver* observer) {
    return std::make_unique<DevicePipeline>(scene, bvh, parameters, options, observer);
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
