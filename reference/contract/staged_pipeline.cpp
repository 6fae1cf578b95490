#include "reference/contract/staged_pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "reference/base/assert.h"
#include "reference/contract/batch_plan.h"
#include "reference/contract/parameter_table.h"
#include "reference/contract/stage_inputs.h"

namespace scotty::reference {

namespace {

/// Lets the log show to another observer, as long as this lives.
class ShownTo {
 public:
    ShownTo(StageLog& log, StageObserver& observer)
        : log_(log), before_(log.exchange_observer(&observer)) {}
    ~ShownTo() { log_.exchange_observer(before_); }
    ShownTo(const ShownTo&) = delete;
    ShownTo& operator=(const ShownTo&) = delete;

 private:
    StageLog& log_;
    StageObserver* before_;
};

bool finite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

StagedPipeline::StagedPipeline(const PipelineParameters& parameters, std::uint32_t triangle_count)
    : parameters_(parameters), triangle_count_(triangle_count) {
    validate(parameters_);
}

void StagedPipeline::look(const Camera& camera, const PipelineParameters& parameters) {
    validate(parameters);
    for (const ParameterInfo& info : kParameters) {
        const bool is_of_making = info.group == ParameterGroup::tree ||
                                  info.group == ParameterGroup::arithmetic ||
                                  (info.group == ParameterGroup::pipeline &&
                                   info.name != "batch_rays" && info.name != "samples_per_pass");
        if (is_of_making) SCOTTY_ASSERT(info.get(parameters), ==, info.get(parameters_));
    }
    parameters_ = parameters;
    parameters_.batch_rays = std::min(parameters.batch_rays, most_batch_rays_);
    take_view(camera);
}

bool StagedPipeline::filters() const {
    return parameters_.filter != Filter::none && parameters_.spp < parameters_.filter_threshold;
}

void StagedPipeline::expect_traceable(std::span<const Ray> rays) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Ray& ray = rays[i];
        const char* fault = nullptr;
        if (!finite(ray.origin)) fault = "its origin is not finite";
        if (!finite(ray.direction)) fault = "its direction is not finite";
        if (is_zero(ray.direction)) fault = "its direction is zero";
        if (!(ray.t_min >= 0.0f)) fault = "its t_min is negative or NaN";
        if (std::isnan(ray.t_max)) fault = "its t_max is NaN";
        if (fault != nullptr) throw Error::bad_input(fmt::format("ray {}", i), fault);
    }
}

void StagedPipeline::launch_render() {
    const auto announce = [&](std::uint64_t done, std::uint64_t count) {
        if (log().observer() == nullptr) return;
        wait();
        log().observer()->on_batch(done, count);
    };
    for_each_batch(parameters_, announce, [&](const StagePlace& place, const BatchView& batch) {
        launch_batch(place, batch);
    });
    if (filters()) launch_filter();
}

void StagedPipeline::launch_batch(StagePlace place, const BatchView& batch) {
    resize_paths(std::size_t{batch.pixels} * batch.samples);
    launch_primary_rays(place, batch);
    place.bounce = 0;
    trace_paths(place);
    for (; place.bounce <= parameters_.bounces; ++place.bounce) shade_vertex(place);
    place.bounce = kNotApplicable;
    launch_reconstruct(place, batch);
}

void StagedPipeline::shade_vertex(StagePlace place) {
    for (place.light = 0; place.light < parameters_.light_samples; ++place.light) {
        launch_direct_light(place);
        trace_shadow_rays(place, shadow_query());
    }
    place.light = kNotApplicable;
    launch_scene_rays(place);
    if (place.bounce == parameters_.bounces) return;
    ++place.bounce;
    trace_paths(place);
}

std::vector<OwnedBuffer> StagedPipeline::run_stage(const StageView& stage) {
    StageOutputs outputs;
    {
        const ShownTo shown(log(), outputs);
        launch_alone(stage);
    }
    return std::move(outputs).take();
}

void StagedPipeline::launch_alone(const StageView& stage) {
    const StagePlace place = place_of(stage);
    BatchView batch{};
    switch (stage.kind) {
        case StageKind::primary_rays:
            batch = batch_of(parameters_, stage);
            load_paths(stage, std::size_t{batch.pixels} * batch.samples);
            launch_primary_rays(place, batch);
            break;
        case StageKind::direct_light_rays:
            load_paths_of(stage, buffers::rays);
            launch_direct_light(place);
            break;
        case StageKind::resolve_light:
            load_paths_of(stage, buffers::shadow_rays);
            launch_resolve_light(place);
            break;
        case StageKind::scene_rays:
            load_paths_of(stage, buffers::rays);
            launch_scene_rays(place);
            break;
        case StageKind::reconstruct_image:
            batch = batch_of(parameters_, stage);
            load_paths(stage, std::size_t{batch.pixels} * batch.samples);
            load_image(stage);
            launch_reconstruct(place, batch);
            break;
        case StageKind::filter:
            load_image(stage);
            launch_filter();
            break;
        default:
            if (stage.kind == StageKind::scan_counts && parameters_.queues == QueueKind::pairs) {
                throw Error::bad_input(stage.name, "with queues of pairs nothing is scanned");
            }
            run_traversal_stage(stage);
            break;
    }
}

void StagedPipeline::load_paths_of(const StageView& stage, const Buffer<Ray>& rays) {
    const StageBuffers in(stage);
    const std::size_t count = in.input(rays).size();
    load_paths(stage, count);
    if (reads(stage.kind, buffers::path_hits)) path_hits_of_scene(in, count, triangle_count_);
}

}  // namespace scotty::reference
