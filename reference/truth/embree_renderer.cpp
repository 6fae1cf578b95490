#include "reference/truth/embree_renderer.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <span>
#include <vector>

#include "reference/contract/batch_plan.h"
#include "reference/numerics/intersect_triangle.h"
#include "reference/stages/path_stages.h"
#include "reference/stages/reconstruct_pixel.h"
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

/// The state of one path, as the stages' text wants it.
struct Path {
    Ray ray;
    Vec3 throughput, radiance, potential;
    std::uint32_t pixel, sample, depth, flags;

    PathView view() {
        return {&ray, &throughput, &radiance, &potential, &pixel, &sample, &depth, &flags};
    }
};

Vec3 trace_path(const SceneView& scene, const PathParameters& parameters,
                const EmbreeTracer& tracer, const CoincidentTriangles& coincident,
                std::uint32_t pixel, std::uint32_t sample) {
    Path path;
    const PathView view = path.view();
    start_path(scene.camera, parameters, pixel, sample, view, 0);
    for (std::uint32_t bounce = 0; bounce <= parameters.bounces; ++bounce) {
        const Hit hit = closest_hit(scene, tracer, coincident, path.ray);
        for (std::uint32_t light = 0; light < parameters.light_samples && is_hit(hit); ++light) {
            Ray shadow;
            ask_for_light(scene, parameters, bounce, light, hit, view, 0, shadow);
            if (!is_dead(shadow) && !tracer.occluded(shadow)) path.radiance += path.potential;
        }
        advance_path(scene, parameters, bounce, hit, view, 0);
        if ((path.flags & kPathAlive) == 0) break;
    }
    return path.radiance;
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
    const auto announce = [&](std::uint64_t done, std::uint64_t count) {
        if (observer != nullptr) observer->on_batch(done, count);
    };
    for_each_batch(batched, announce, [&](const StagePlace& place, const BatchView& batch) {
        const auto add_samples = [&](const oneapi::tbb::blocked_range<std::uint32_t>& range) {
            std::vector<Vec3> radiance(batch.samples);
            for (std::uint32_t pixel = range.begin(); pixel != range.end(); ++pixel) {
                for (std::uint32_t i = 0; i < batch.samples; ++i) {
                    radiance[i] =
                        trace_path(view, path, tracer, coincident, pixel, batch.first_sample + i);
                }
                reconstruct_pixel(batch, batched.spp, radiance.data(), image.pixels[pixel],
                                  image.variance[pixel]);
            }
        };
        arena.execute([&] {
            oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::uint32_t>(
                                          batch.first_pixel, batch.first_pixel + batch.pixels, 64),
                                      add_samples);
        });
        if (observer != nullptr) show_batch(*observer, place.batch, batch, image);
    });
    if (batched.spp == 1) image.variance.clear();
    return image;
}

}  // namespace scotty::reference
