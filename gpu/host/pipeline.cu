#include <algorithm>
#include <cstring>
#include <string>

#include "gpu/host/fused_paths.h"
#include "gpu/host/path_state.h"
#include "gpu/host/pipeline_build.h"
#include "gpu/host/traversal.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/direct_light_rays.h"
#include "gpu/kernels/filter_image.h"
#include "gpu/kernels/fused_shading.h"
#include "gpu/kernels/primary_rays.h"
#include "gpu/kernels/reconstruct_image.h"
#include "gpu/kernels/resolve_light.h"
#include "gpu/kernels/scene_rays.h"
#include "reference/base/assert.h"
#include "reference/contract/staged_pipeline.h"

namespace SCOTTY_DEVICE_NAMESPACE {

using reference::Hit;
using reference::PipelineParameters;
using reference::Ray;
using reference::StageKind;
using reference::StagePlace;
using reference::StageView;
using reference::Vec3;

namespace {

constexpr std::uint32_t kSmallestBatch = 1024;

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

void plain_copy(void* to, const void* from, std::size_t bytes) { std::memcpy(to, from, bytes); }

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

class Event {
 public:
    Event() { check(cudaEventCreate(&event_), "creating an event"); }
    ~Event() { cudaEventDestroy(event_); }
    Event(const Event&) = delete;
    Event& operator=(const Event&) = delete;
    cudaEvent_t get() const { return event_; }

 private:
    cudaEvent_t event_ = nullptr;
};

class DevicePipeline final : public reference::StagedPipeline {
 public:
    DevicePipeline(const reference::Scene& scene, const reference::WideBvh& bvh,
                   const PipelineParameters& parameters, const PipelineOptions& options,
                   reference::StageObserver* observer)
        : StagedPipeline(parameters, reference::view_of(scene).triangle_count),
          budget_{options.memory_limit, 0},
          scene_(scene, bvh, parameters.queues == reference::QueueKind::pairs, budget_),
          log_(observer, options.timings),
          paths_(budget_),
          fused_(budget_),
          traversal_(scene_, parameters_, budget_, log_, stream_.get()),
          trace_rays_(budget_),
          trace_hits_(budget_),
          copy_(options.copy) {
        SCOTTY_ASSERT(bvh.width, ==, parameters.width);
        path_ = reference::path_parameters(parameters);
    }

    reference::Image render() override;
    void trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) override;
    double time_trace(std::span<const Ray> rays, TraversalKind kind, int repeats) override;
    const std::vector<LaunchRecord>& launches() override {
        log_.resolve_times();
        return log_.records();
    }
    void clear_launches() override {
        log_.resolve_times();
        log_.clear();
    }
    std::size_t device_bytes() const override { return budget_.used; }

 private:
    void render_in_batches();
    reference::Image take_picture();
    void copy_pixels(std::span<const Vec3> from, std::vector<Vec3>& to) const {
        if (from.empty()) return;
        const auto copy = copy_ != nullptr ? copy_ : plain_copy;
        copy(to.data(), from.data(), from.size_bytes());
    }
    reference::BufferView host_view(StageKind kind, const reference::BufferInfo& buffer,
                                    HostCopies& copies);
    reference::StageLog& log() override { return log_; }
    void take_view(const reference::Camera& camera) override {
        scene_.set_camera(camera);
        path_ = reference::path_parameters(parameters_);
    }
    /// Whether a vertex is shaded in one launch: nobody looks at what its stages give.
    bool is_fused() const;
    void resize_paths(std::size_t rays) override;
    void shade_vertex(StagePlace place) override;
    void launch_primary_rays(const StagePlace& place, const BatchView& batch) override;
    void launch_direct_light(const StagePlace& place) override;
    void launch_resolve_light(const StagePlace& place) override;
    void launch_scene_rays(const StagePlace& place) override;
    void launch_reconstruct(const StagePlace& place, const BatchView& batch) override;
    void launch_filter() override;
    void wait() override { check(cudaStreamSynchronize(stream_.get()), "rendering"); }
    void trace_paths(const StagePlace& place) override;
    void trace_shadow_rays(const StagePlace& place, TraversalKind kind) override;
    void load_paths(const StageView& stage, std::size_t rays) override { paths_.load(stage, rays); }
    void load_image(const StageView& stage) override;
    void run_traversal_stage(const StageView& stage) override {
        traversal_.run_stage(stage, trace_rays_, trace_hits_);
    }

    /// Runs and shows a stage with a thread for each of `threads` rays or pixels;
    /// `launch_kernel(blocks)` launches it.
    template <class Launch>
    void launch(StageKind kind, const StagePlace& place, std::uint32_t threads, std::uint64_t items,
                const Launch& launch_kernel) {
        const std::uint32_t blocks = item_blocks(threads);
        log_.run(kind, place, blocks, items, stream_.get(), [&] { launch_kernel(blocks); });
        HostCopies copies;
        log_.show(
            parameters_, kind, place, blocks, kItemThreads,
            [&](const reference::BufferInfo& buffer) { return host_view(kind, buffer, copies); });
    }

    reference::PathParameters path_;
    MemoryBudget budget_;
    Stream stream_;
    DeviceScene scene_;
    LaunchLog log_;
    PathState paths_;
    FusedPaths fused_;
    BatchView batch_{};  ///< in flight
    Traversal traversal_;
    DeviceMemory<Ray> trace_rays_;
    DeviceMemory<Hit> trace_hits_;
    void (*copy_)(void* to, const void* from, std::size_t bytes);
    PinnedMemory<Vec3> image_, variance_;
    Event image_is_here_;
};

reference::Image DevicePipeline::render() {
    for (;;) {
        try {
            render_in_batches();
            return take_picture();
        } catch (const OutOfDeviceMemory& error) {
            if (parameters_.batch_rays <= kSmallestBatch) throw;
            cudaStreamSynchronize(stream_.get());
            traversal_.release();
            paths_.release();
            fused_.release();
            halve_batches();
            log_.retry("", std::string(error.what()) + "; again with batches of " +
                               std::to_string(parameters_.batch_rays) + " rays");
        }
    }
}

void DevicePipeline::render_in_batches() {
    // Observers see all of both after every batch.
    paths_.image.resize(pixel_count(), "the image");
    paths_.variance.resize(pixel_count(), "the image's variance");
    for (auto* buffer : {&paths_.image, &paths_.variance}) {
        check(cudaMemsetAsync(buffer->data(), 0, pixel_count() * sizeof(Vec3), stream_.get()),
              "clearing the image");
    }
    launch_render();
}

/// The host makes room while the device still renders, and copies the image while the variance is
/// on its way.
reference::Image DevicePipeline::take_picture() {
    const std::size_t variances = knows_variance() ? pixel_count() : 0;
    const auto image =
        image_.start_download(paths_.image.data(), pixel_count(), stream_.get(), "the image");
    check(cudaEventRecord(image_is_here_.get(), stream_.get()), "recording an event");
    const auto variance = variance_.start_download(paths_.variance.data(), variances, stream_.get(),
                                                   "the image's variance");
    reference::Image picture{parameters_.image_width, parameters_.image_height, {}, {}};
    picture.pixels.resize(image.size());
    picture.variance.resize(variance.size());
    check(cudaEventSynchronize(image_is_here_.get()), "rendering");
    copy_pixels(image, picture.pixels);
    wait();
    copy_pixels(variance, picture.variance);
    return picture;
}

/// The picture's own buffers are shown where the device copies them to. Whoever does not follow
/// launches is not shown what a picture is made of: the paths' radiance is many times as large.
reference::BufferView DevicePipeline::host_view(StageKind kind, const reference::BufferInfo& buffer,
                                                HostCopies& copies) {
    namespace buffers = reference::buffers;
    const auto of_picture = [&](const reference::Buffer<Vec3>& of, const DeviceMemory<Vec3>& from,
                                PinnedMemory<Vec3>& to) {
        const auto host =
            to.start_download(from.data(), from.size(), stream_.get(), of.name.data());
        wait();
        return reference::buffer_view(of, host);
    };
    if (buffer.name == buffers::image.name) return of_picture(buffers::image, paths_.image, image_);
    if (buffer.name == buffers::variance.name) {
        return of_picture(buffers::variance, paths_.variance, variance_);
    }
    if (kind == StageKind::reconstruct_image && !log_.observed()) {
        if (buffer.name == buffers::radiance.name)
            return reference::buffer_view(buffers::radiance, {});
        if (buffer.name == buffers::pixel.name) return reference::buffer_view(buffers::pixel, {});
    }
    return paths_.view(buffer, copies);
}

void DevicePipeline::trace_paths(const StagePlace& place) {
    const bool coherent = place.bounce == 0;
    traversal_.run({paths_.rays.data(), paths_.count(), TraversalKind::closest, coherent}, place,
                   {paths_.path_hits.data()});
}

void DevicePipeline::trace_shadow_rays(const StagePlace& place, TraversalKind kind) {
    const bool coherent = place.bounce == 0;
    const TracedRays shadow{paths_.shadow_rays.data(), paths_.count(), kind, coherent};
    if (traversal_.is_one_launch()) {
        traversal_.run(shadow, place, {nullptr, paths_.potential.data(), paths_.radiance.data()});
        return;
    }
    traversal_.run(shadow, place, {paths_.shadow_hits.data()});
    launch_resolve_light(place);
}

bool DevicePipeline::is_fused() const {
    for (const StageKind kind : {StageKind::primary_rays, StageKind::direct_light_rays,
                                 StageKind::resolve_light, StageKind::scene_rays}) {
        if (log_.wants(kind)) return false;
    }
    return traversal_.is_one_launch() && FusedPaths::can_have(parameters_.light_samples);
}

void DevicePipeline::resize_paths(std::size_t rays) {
    if (is_fused()) {
        fused_.resize(paths_, rays, parameters_.light_samples);
        fused_.pack(scene_.view(), stream_.get());
    } else {
        paths_.resize(rays);
    }
}

void DevicePipeline::shade_vertex(StagePlace place) {
    if (!is_fused()) {
        StagedPipeline::shade_vertex(place);
        return;
    }
    const std::uint32_t count = paths_.count();
    const FusedPathView view = fused_.view(paths_);
    static_assert(kMostFusedLights == 2);
    launch(StageKind::direct_light_rays, place, count, count, [&](std::uint32_t blocks) {
        if (parameters_.light_samples == 1) {
            SCOTTY_LAUNCH(shade_fused_paths<1>, blocks, kItemThreads, stream_.get(), batch_,
                          scene_.view(), path_, place.bounce, view);
        } else {
            SCOTTY_LAUNCH(shade_fused_paths<2>, blocks, kItemThreads, stream_.get(), batch_,
                          scene_.view(), path_, place.bounce, view);
        }
    });
    const bool coherent = place.bounce == 0;
    for (place.light = 0; place.light < parameters_.light_samples; ++place.light) {
        const std::size_t first = std::size_t{place.light} * count;
        traversal_.run({view.shadow_rays + first, count, shadow_query(), coherent}, place,
                       {nullptr, view.potential + first, view.radiance});
    }
    place.light = reference::kNotApplicable;
    if (place.bounce < parameters_.bounces) {
        ++place.bounce;
        trace_paths(place);
        return;
    }
    launch(StageKind::scene_rays, place, count, count, [&](std::uint32_t blocks) {
        SCOTTY_LAUNCH(end_fused_paths, blocks, kItemThreads, stream_.get(), view);
    });
}

void DevicePipeline::launch_primary_rays(const StagePlace& place, const BatchView& batch) {
    batch_ = batch;
    if (is_fused()) {
        launch(StageKind::primary_rays, place, paths_.count(), paths_.count(),
               [&](std::uint32_t blocks) {
                   SCOTTY_LAUNCH(start_fused_paths, blocks, kItemThreads, stream_.get(), batch,
                                 scene_.view().camera, path_, fused_.view(paths_));
               });
        return;
    }
    launch(StageKind::primary_rays, place, batch.pixels, paths_.count(), [&](std::uint32_t blocks) {
        SCOTTY_LAUNCH(primary_rays, blocks, kItemThreads, stream_.get(), batch,
                      scene_.view().camera, path_, reference::path_view(paths_));
    });
}

void DevicePipeline::launch_direct_light(const StagePlace& place) {
    const std::uint32_t count = paths_.count();
    launch(StageKind::direct_light_rays, place, count, count, [&](std::uint32_t blocks) {
        SCOTTY_LAUNCH(direct_light_rays, blocks, kItemThreads, stream_.get(), count, scene_.view(),
                      path_, place.bounce, place.light, reference::path_view(paths_),
                      paths_.path_hits.data(), paths_.shadow_rays.data());
    });
}

void DevicePipeline::launch_resolve_light(const StagePlace& place) {
    const std::uint32_t count = paths_.count();
    launch(StageKind::resolve_light, place, count, count, [&](std::uint32_t blocks) {
        SCOTTY_LAUNCH(resolve_light, blocks, kItemThreads, stream_.get(), count,
                      paths_.shadow_rays.data(), paths_.shadow_hits.data(),
                      reference::path_view(paths_));
    });
}

void DevicePipeline::launch_scene_rays(const StagePlace& place) {
    const std::uint32_t count = paths_.count();
    launch(StageKind::scene_rays, place, count, count, [&](std::uint32_t blocks) {
        SCOTTY_LAUNCH(scene_rays, blocks, kItemThreads, stream_.get(), count, scene_.view(), path_,
                      place.bounce, paths_.path_hits.data(), reference::path_view(paths_));
    });
}

void DevicePipeline::launch_reconstruct(const StagePlace& place, const BatchView& batch) {
    launch(StageKind::reconstruct_image, place, batch.pixels, paths_.count(),
           [&](std::uint32_t blocks) {
               SCOTTY_LAUNCH(reconstruct_image, blocks, kItemThreads, stream_.get(), batch,
                             parameters_.spp, paths_.radiance.data(), paths_.image.data(),
                             paths_.variance.data());
           });
}

void DevicePipeline::launch_filter() {
    paths_.filtered.resize(pixel_count(), "the filtered image");
    const FilterView view{parameters_.image_width, parameters_.image_height, paths_.image.data(),
                          paths_.filtered.data()};
    launch(StageKind::filter, {}, pixel_count(), pixel_count(), [&](std::uint32_t blocks) {
        SCOTTY_LAUNCH(filter_image, blocks, kItemThreads, stream_.get(), view, parameters_.filter);
    });
    swap(paths_.image, paths_.filtered);
}

void DevicePipeline::load_image(const StageView& stage) {
    const reference::StageBuffers in(stage);
    paths_.image.upload(in.input(reference::buffers::image, pixel_count()), "the image");
    if (!reference::reads(stage.kind, reference::buffers::variance)) return;
    paths_.variance.upload(in.input(reference::buffers::variance, pixel_count()),
                           "the image's variance");
}

void DevicePipeline::trace(std::span<const Ray> rays, TraversalKind kind, std::span<Hit> hits) {
    SCOTTY_ASSERT(rays.size(), ==, hits.size());
    expect_traceable(rays);
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
