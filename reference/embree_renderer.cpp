#include "reference/embree_renderer.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include "reference/intersect_triangle.h"
#include "reference/path.h"

namespace scotty::reference {

namespace {

/// Embree's primitive with our distance; Embree's own record where we would call that a miss.
Hit closest_hit(const SceneView& scene, const EmbreeTracer& tracer, const Ray& ray) {
    if (is_dead(ray)) return no_hit();
    Hit found = tracer.closest(ray);
    if (!is_hit(found)) return found;
    const std::uint32_t* corner = scene.triangles + 3 * static_cast<std::size_t>(found.primitive);
    intersect_triangle(ray, safe_inverse(ray.direction), ray_shear(ray.direction),
                       scene.vertices[corner[0]], scene.vertices[corner[1]],
                       scene.vertices[corner[2]], found);
    return found;
}

Vec3 trace_path(const SceneView& scene, const PathParameters& parameters,
                const EmbreeTracer& tracer, std::uint32_t pixel, std::uint32_t sample) {
    Vec3 radiance(0.0f, 0.0f, 0.0f);
    Vec3 throughput(1.0f, 1.0f, 1.0f);
    std::uint32_t flags = kPathAlive;
    Ray ray = primary_ray(scene.camera, parameters, pixel, sample);
    for (std::uint32_t bounce = 0; bounce <= parameters.bounces; ++bounce) {
        const Hit hit = closest_hit(scene, tracer, ray);
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

}  // namespace

Image render_with_embree(const Scene& scene, const PipelineParameters& parameters,
                         const EmbreeTracer& tracer, std::size_t threads) {
    validate(parameters);
    const SceneView view = view_of(scene);
    const PathParameters path = path_parameters(parameters);
    const std::uint32_t pixels = parameters.image_width * parameters.image_height;
    Image image{parameters.image_width, parameters.image_height, std::vector<Vec3>(pixels)};
    oneapi::tbb::task_arena arena(threads == 0 ? oneapi::tbb::task_arena::automatic
                                               : static_cast<int>(threads));
    arena.execute([&] {
        oneapi::tbb::parallel_for(
            oneapi::tbb::blocked_range<std::uint32_t>(0, pixels, 64),
            [&](const oneapi::tbb::blocked_range<std::uint32_t>& range) {
                for (std::uint32_t pixel = range.begin(); pixel != range.end(); ++pixel) {
                    Vec3 sum(0.0f, 0.0f, 0.0f);
                    for (std::uint32_t sample = 0; sample < parameters.spp; ++sample) {
                        sum += trace_path(view, path, tracer, pixel, sample);
                    }
                    image.pixels[pixel] = sum / static_cast<float>(parameters.spp);
                }
            });
    });
    return image;
}

}  // namespace scotty::reference
