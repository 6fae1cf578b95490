/// Kernel: all of a path vertex in one launch, its light samples and its scattering, for renders
/// whose shading nobody follows. The functions are those of the stages, and so are the bits.
///
/// A path's state crosses the memory once per vertex. What no later launch reads is not written:
/// pixel and sample follow from the ray's id, and the depth is for observers.
#pragma once

#include <cstdint>

#include "gpu/kernels/dialect.h"
#include "gpu/kernels/views.h"
#include "reference/numerics/path.h"

namespace SCOTTY_DEVICE_NAMESPACE {

/// Light samples that a vertex may have here.
constexpr std::uint32_t kMostFusedLights = 2;

constexpr std::uint32_t kFusedThreads = 256;
constexpr std::uint32_t kFusedBlocks = 3;  ///< at once on a multiprocessor: 80 registers each

/// A bit of the flags, beside reference::kPathAlive: the emission that the path has met at its last
/// vertex is in `emission`. It is added when the vertex's light has been, as the stages do it: the
/// sum of floats depends on the order.
constexpr std::uint32_t kEmissionWaits = 1u << 31;

/// What shading reads of a triangle, in one piece: rays that follow no order would wait for each of
/// twenty gathers.
struct alignas(16) ShadedTriangle {
    reference::Vec3 corners[3];
    reference::Vec3 normals[3];  ///< zero where the surface is flat, as in a scene
    std::uint32_t material;
    std::uint32_t unused;
};
static_assert(sizeof(ShadedTriangle) == 80, "five 16-byte loads");

/// By primitive.
SCOTTY_KERNEL(pack_triangles)(reference::SceneView scene, ShadedTriangle* packed) {
    const std::uint32_t primitive = block_index() * block_size() + thread_index();
    if (primitive >= scene.triangle_count) SCOTTY_RETURN;
    ShadedTriangle triangle{};
    for (int i = 0; i < 3; ++i) {
        const std::uint32_t vertex =
            scene.triangles[3 * static_cast<std::size_t>(primitive) + static_cast<std::size_t>(i)];
        triangle.corners[i] = scene.vertices[vertex];
        if (scene.normals != nullptr) triangle.normals[i] = scene.normals[vertex];
    }
    triangle.material = scene.material_of[primitive];
    packed[primitive] = triangle;
}

/// reference::surface_at(), in a scene that is this triangle alone.
SCOTTY_DEVICE reference::Surface surface_on(const ShadedTriangle& triangle,
                                            const reference::SceneView& scene,
                                            const reference::Ray& ray, reference::Hit hit) {
    const std::uint32_t corners[3] = {0, 1, 2};
    reference::SceneView alone = scene;
    alone.vertices = triangle.corners;
    alone.normals = triangle.normals;
    alone.triangles = corners;
    alone.material_of = &triangle.material;
    hit.primitive = 0;
    return reference::surface_at(alone, ray, hit);
}

/// Arrays by ray id.
struct FusedPathView {
    std::uint32_t count;
    reference::Ray* rays;
    reference::Vec3* throughput;
    reference::Vec3* radiance;
    std::uint32_t* flags;
    const reference::Hit* path_hits;
    reference::Ray* shadow_rays;  ///< of light sample l: from l * count on
    reference::Vec3* potential;   ///< the same; not written where the shadow ray is dead
    reference::Vec3* emission;    ///< where kEmissionWaits
    const ShadedTriangle* triangles;
};

SCOTTY_KERNEL(start_fused_paths)
(BatchView batch, reference::Camera camera, reference::PathParameters parameters,
 FusedPathView paths) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= paths.count) SCOTTY_RETURN;
    // A function's result that goes straight to memory is not heard by the checker.
    const reference::Ray ray =
        reference::primary_ray(camera, parameters, batch.first_pixel + ray_id / batch.samples,
                               batch.first_sample + ray_id % batch.samples);
    paths.rays[ray_id] = ray;
    paths.radiance[ray_id] = reference::Vec3(0.0f, 0.0f, 0.0f);
}

SCOTTY_DEVICE void add_waiting_emission(const FusedPathView& paths, std::uint32_t ray_id,
                                        std::uint32_t flags) {
    if ((flags & kEmissionWaits) != 0) paths.radiance[ray_id] += paths.emission[ray_id];
}

/// Of paths that have met their last vertex.
SCOTTY_KERNEL(end_fused_paths)(FusedPathView paths) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= paths.count) SCOTTY_RETURN;
    add_waiting_emission(paths, ray_id, paths.flags[ray_id]);
}

SCOTTY_DEVICE void ask_for_fused_light(const FusedPathView& paths, std::uint32_t light,
                                       std::uint32_t ray_id, const reference::DirectLight& asked) {
    const std::size_t slot = static_cast<std::size_t>(light) * paths.count + ray_id;
    paths.shadow_rays[slot] = asked.shadow;
    if (!reference::is_zero(asked.potential)) paths.potential[slot] = asked.potential;
}

template <std::uint32_t Lights>
SCOTTY_KERNEL_SIZED(kFusedThreads, kFusedBlocks, shade_fused_paths)
(BatchView batch, reference::SceneView scene, reference::PathParameters parameters,
 std::uint32_t bounce, FusedPathView paths) {
    const std::uint32_t ray_id = block_index() * block_size() + thread_index();
    if (ray_id >= paths.count) SCOTTY_RETURN;
    const bool first = bounce == 0;
    const std::uint32_t before = first ? reference::kPathAlive : paths.flags[ray_id];
    if (!first) add_waiting_emission(paths, ray_id, before);
    const std::uint32_t flags = before & ~kEmissionWaits;
    const bool alive = (flags & reference::kPathAlive) != 0;
    reference::Hit hit = reference::no_hit();
    if (alive) hit = load_record(paths.path_hits + ray_id);
    if (!reference::is_hit(hit)) {
        SCOTTY_UNROLL
        for (std::uint32_t light = 0; light < Lights; ++light) {
            ask_for_fused_light(paths, light, ray_id, reference::no_direct_light());
        }
        if (!alive) {  // and so is its ray
            if (before != 0) paths.flags[ray_id] = 0;
            SCOTTY_RETURN;
        }
    }

    const reference::Ray ray = paths.rays[ray_id];
    reference::Vec3 throughput(1.0f, 1.0f, 1.0f);
    if (!first) throughput = paths.throughput[ray_id];
    reference::Scattered next;
    bool is_lit = false;
    if (!reference::is_hit(hit)) {
        next = reference::leave_scene(scene, parameters, bounce, ray.direction, throughput, flags);
    } else {
        const ShadedTriangle triangle = load_record(paths.triangles + hit.primitive);
        const reference::Surface surface = surface_on(triangle, scene, ray, hit);
        const std::uint32_t pixel = batch.first_pixel + ray_id / batch.samples;
        const std::uint32_t sample = batch.first_sample + ray_id % batch.samples;
        SCOTTY_UNROLL
        for (std::uint32_t light = 0; light < Lights; ++light) {
            const auto dimension = static_cast<std::uint32_t>(reference::Dimension::light) + light;
            const reference::DirectLight asked = reference::sample_light_at(
                scene, parameters, surface, ray.direction, throughput,
                reference::random4(parameters.seed, pixel, sample, bounce, dimension));
            ask_for_fused_light(paths, light, ray_id, asked);
            is_lit = is_lit || !reference::is_zero(asked.potential);
        }
        next = reference::scatter_at(
            scene, parameters, bounce, surface, ray.direction, throughput, flags,
            reference::random4(parameters.seed, pixel, sample, bounce,
                               static_cast<std::uint32_t>(reference::Dimension::scatter)));
    }

    if (!reference::is_zero(next.emitted)) {
        if (is_lit) {
            paths.emission[ray_id] = next.emitted;
            next.flags |= kEmissionWaits;
        } else {
            paths.radiance[ray_id] += next.emitted;
        }
    }
    if (bounce < parameters.bounces) {
        paths.rays[ray_id] = next.ray;
        if ((next.flags & reference::kPathAlive) != 0) paths.throughput[ray_id] = next.throughput;
    }
    if (first || next.flags != before) paths.flags[ray_id] = next.flags;
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
