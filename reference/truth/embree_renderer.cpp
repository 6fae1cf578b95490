#include "reference/truth/embree_renderer.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <span>
#include <vector>

#include "reference/contract/batch_plan.h"
#include "reference/numerics/intersect_triangle.h"
#include "reference/numerics/path.h"
#include "reference/numerics/pixel_sums.h"
#include "reference/truth/coincident.h"

namespace scotty::reference {

namespace {

/// Embree's primitive with our distance; Embree's own record where we would call that a miss.
Hit closest_hit(const SceneView& scene, const EmbreeTracer& tracer,
                const CoincidentTriangles& coincident, const Ray& ray) {
    if (is_dead(ray)) return no_hit();
    Hit found = tracer.closest(ray);
    if (!is_hit(found)) return found;
    const std::uint32_t* corner = scene.triangles + 3 * static_cast<std::size_t>(found.primitive);
    intersect_triangle(ray, safe_inverse(ray.direction), ray_shear(ray.direction),
                       scene.vertices[corner[0]], scene.vertices[corner[1]],
                       scene.vertices[corner[2]], found);
    return coincident.seen(ray, found);
}

Vec3 trace_path(const SceneView& scene, const PathParameters& parameters,
                const EmbreeTracer& tracer, const CoincidentTriangles& coincident,
                std::uint32_t pixel, std::uint32_t sample) {
    Vec3 radiance(0.0f, 0.0f, 0.0f);
    Vec3 throughput(1.0f, 1.0f, 1.0f);
    std::uint32_t flags = kPathAlive;
    Ray ray = primary_ray(scene.camera, parameters, pixel, sample);
    for (std::uint32_t bounce = 0; bounce <= parameters.bounces; ++bounce) {
        const Hit hit = closest_hit(scene, tracer, coincident, ray);
        for (std::uint32_t light = 0; light < parameters.light_samples && is_hit(hit); ++light) {
            const DirectLight direct =
                sample_direct_light(scene, parameters, ray, hit, throughput,
                                    random4(parameters.seed, pixel, sample, bounce,
                                            static_cast<std::uint32_t>(Dimension::light) + light));
            if (!is_dead(direct.shadow) && !tracer.occluded(direct.shadow)) {
                radiance += direct.potential;
            }
        }
        const Scattered next = scatter(scene, parameters, bounce, ray, hit, throughput, flags,
                                       random4(parameters.seed, pixel, sample, bounce,
                                               static_cast<std::uint32_t>(Dimension::scatter)));
        radiance += next.emitted;
        ray = next.ray;
        throughput = next.throughput;
        flags = next.flags;
        if ((flags & kPathAlive) == 0) break;
    }
    return radiance;
}

void show_batch(StageObserver& observer, std::uint32_t number, const BatchView& batch,
                const Image& image) {
    if (!observer.wants(StageKind::reconstruct_image)) return;
    std::vector<std::uint32_t> pixel;
    pixel.reserve(std::size_t{batch.pixels} * batch.samples);
    for (std::uint32_t i = 0; i < batch.pixels; ++i) {
        pixel.insert(pixel.end(), batch.samples, batch.first_pixel + i);
    }
    StageView stage;
    stage.kind = StageKind::reconstruct_image;
    stage.name = stage_name(stage.kind, number, kNotApplicable, kNotApplicable, kNotApplicable,
                            /*several_batches=*/true);
    stage.launch = stage.batch = number;
    stage.inputs = {buffer_view(reference::buffers::pixel, std::span<const std::uint32_t>(pixel))};
    stage.outputs = {
        buffer_view(reference::buffers::image, std::span<const Vec3>(image.pixels)),
        buffer_view(reference::buffers::variance, std::span<const Vec3>(image.variance))};
    observer.on_stage(stage);
}

}  // namespace

Image render_with_embree(const Scene& scene, const PipelineParameters& parameters,
                         const EmbreeTracer& tracer, std::size_t threads, StageObserver* observer) {
    validate(parameters);
    PipelineParameters batched = parameters;
    if (observer == nullptr) {  // fewer waits for the last thread of a batch
        batched.batch_rays = 1u << 28;
        batched.samples_per_pass = 0;
    }
    const SceneView view = view_of(scene);
    const CoincidentTriangles coincident(scene);
    const PathParameters path = path_parameters(batched);
    const std::uint32_t pixels = batched.image_width * batched.image_height;
    Image image{batched.image_width, batched.image_height,
                std::vector<Vec3>(pixels, Vec3(0.0f, 0.0f, 0.0f)),
                std::vector<Vec3>(pixels, Vec3(0.0f, 0.0f, 0.0f))};
    oneapi::tbb::task_arena arena(threads == 0 ? oneapi::tbb::task_arena::automatic
                                               : static_cast<int>(threads));
    const BatchPlan plan(batched);
    for (std::uint32_t number = 0; number < plan.size(); ++number) {
        if (observer != nullptr) observer->on_batch(number, plan.size());
        const BatchView batch = plan[number];
        const std::uint32_t end_sample = batch.first_sample + batch.samples;
        const auto add_samples = [&](const oneapi::tbb::blocked_range<std::uint32_t>& range) {
            for (std::uint32_t pixel = range.begin(); pixel != range.end(); ++pixel) {
                PixelSums sums{image.pixels[pixel], image.variance[pixel]};
                for (std::uint32_t sample = batch.first_sample; sample < end_sample; ++sample) {
                    add_sample(sums, sample,
                               trace_path(view, path, tracer, coincident, pixel, sample));
                }
                if (end_sample == batched.spp) finish(sums, batched.spp);
                image.pixels[pixel] = sums.image;
                image.variance[pixel] = sums.variance;
            }
        };
        arena.execute([&] {
            oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::uint32_t>(
                                          batch.first_pixel, batch.first_pixel + batch.pixels, 64),
                                      add_samples);
        });
        if (observer != nullptr) show_batch(*observer, number, batch, image);
    }
    if (observer != nullptr) observer->on_batch(plan.size(), plan.size());
    if (batched.spp == 1) image.variance.clear();
    return image;
}

}  // namespace scotty::reference
