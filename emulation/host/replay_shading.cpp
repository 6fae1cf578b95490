/// The stages between traversals, run alone.
#include <algorithm>
#include <cstring>

#include "emulation/host/replay_stages.h"
#include "emulation/kernels/direct_light_rays.h"
#include "emulation/kernels/filter_bilateral.h"
#include "emulation/kernels/filter_gaussian.h"
#include "emulation/kernels/filter_median.h"
#include "emulation/kernels/primary_rays.h"
#include "emulation/kernels/reconstruct_image.h"
#include "emulation/kernels/resolve_light.h"
#include "emulation/kernels/scene_rays.h"

namespace scotty::emulation {

namespace buffers = reference::buffers;

using reference::Hit;
using reference::PipelineParameters;
using reference::Ray;
using reference::Vec3;

namespace {

/// Path state that a kernel works on; what it does not touch stays empty.
struct PathBuffers {
    std::vector<Ray> rays;
    std::vector<Vec3> throughput, radiance, potential;
    std::vector<std::uint32_t> pixel, sample, depth, flags;

    PathView view() {
        return {rays.data(),  throughput.data(), radiance.data(), potential.data(),
                pixel.data(), sample.data(),     depth.data(),    flags.data()};
    }
};

}  // namespace

void replay_primary_rays(ReplayStage& run) {
    const BatchView batch = batch_of(run.parameters, run.stage);
    const std::size_t n = std::size_t{batch.pixels} * batch.samples;
    PathBuffers paths{std::vector<Ray>(n),           std::vector<Vec3>(n),
                      std::vector<Vec3>(n),          std::vector<Vec3>(n),
                      std::vector<std::uint32_t>(n), std::vector<std::uint32_t>(n),
                      std::vector<std::uint32_t>(n), std::vector<std::uint32_t>(n)};
    const PathView view = paths.view();
    run.device.launch_per_item(batch.pixels, [&](std::uint32_t pixel) {
        primary_rays(pixel, batch, run.scene.camera, reference::path_parameters(run.parameters),
                     view);
    });
    run.buffers.output(buffers::rays, paths.rays);
    run.buffers.output(buffers::throughput, paths.throughput);
    run.buffers.output(buffers::radiance, paths.radiance);
    run.buffers.output(buffers::potential, paths.potential);
    run.buffers.output(buffers::pixel, paths.pixel);
    run.buffers.output(buffers::sample, paths.sample);
    run.buffers.output(buffers::depth, paths.depth);
    run.buffers.output(buffers::flags, paths.flags);
}

void replay_direct_light_rays(ReplayStage& run) {
    PathBuffers paths;
    const std::span<const Ray> rays = run.buffers.input(buffers::rays);
    const std::size_t n = rays.size();
    paths.rays.assign(rays.begin(), rays.end());
    paths.throughput = run.buffers.copy(buffers::throughput, n);
    paths.flags = run.buffers.copy(buffers::flags, n);
    paths.pixel = run.buffers.copy(buffers::pixel, n);
    paths.sample = run.buffers.copy(buffers::sample, n);
    paths.potential.resize(n);
    const std::span<const Hit> hits =
        hits_of_scene(run.buffers, "path_hits", n, run.scene.triangle_count);
    std::vector<Ray> shadow_rays(n);
    const PathView view = paths.view();
    run.device.launch_per_item(static_cast<std::uint32_t>(n), [&](std::uint32_t ray) {
        direct_light_rays(ray, run.scene, reference::path_parameters(run.parameters),
                          run.stage.bounce, run.stage.light, view, hits.data(), shadow_rays.data());
    });
    run.buffers.output(buffers::shadow_rays, shadow_rays);
    run.buffers.output(buffers::potential, paths.potential);
}

void replay_resolve_light(ReplayStage& run) {
    PathBuffers paths;
    const std::span<const Ray> shadow_rays = run.buffers.input(buffers::shadow_rays);
    const std::size_t n = shadow_rays.size();
    const std::span<const Hit> hits = run.buffers.input(buffers::shadow_hits, n);
    paths.potential = run.buffers.copy(buffers::potential, n);
    paths.radiance = run.buffers.copy(buffers::radiance, n);
    const PathView view = paths.view();
    run.device.launch_per_item(static_cast<std::uint32_t>(n), [&](std::uint32_t ray) {
        resolve_light(ray, shadow_rays.data(), hits.data(), view);
    });
    run.buffers.output(buffers::radiance, paths.radiance);
}

void replay_scene_rays(ReplayStage& run) {
    PathBuffers paths;
    const std::span<const Ray> rays = run.buffers.input(buffers::rays);
    const std::size_t n = rays.size();
    paths.rays.assign(rays.begin(), rays.end());
    paths.throughput = run.buffers.copy(buffers::throughput, n);
    paths.radiance = run.buffers.copy(buffers::radiance, n);
    paths.flags = run.buffers.copy(buffers::flags, n);
    paths.depth = run.buffers.copy(buffers::depth, n);
    paths.pixel = run.buffers.copy(buffers::pixel, n);
    paths.sample = run.buffers.copy(buffers::sample, n);
    const std::span<const Hit> hits =
        hits_of_scene(run.buffers, "path_hits", n, run.scene.triangle_count);
    const PathView view = paths.view();
    run.device.launch_per_item(static_cast<std::uint32_t>(n), [&](std::uint32_t ray) {
        scene_rays(ray, run.scene, reference::path_parameters(run.parameters), run.stage.bounce,
                   hits.data(), view);
    });
    run.buffers.output(buffers::rays, paths.rays);
    run.buffers.output(buffers::throughput, paths.throughput);
    run.buffers.output(buffers::radiance, paths.radiance);
    run.buffers.output(buffers::flags, paths.flags);
    run.buffers.output(buffers::depth, paths.depth);
}

void replay_reconstruct_image(ReplayStage& run) {
    const BatchView batch = batch_of(run.parameters, run.stage);
    const auto radiance =
        run.buffers.input(buffers::radiance, std::size_t{batch.pixels} * batch.samples);
    std::vector<Vec3> image = run.buffers.copy(
        buffers::image, std::size_t{run.parameters.image_width} * run.parameters.image_height);
    run.device.launch_per_item(batch.pixels, [&](std::uint32_t pixel) {
        reconstruct_image(pixel, batch, run.parameters.spp, radiance.data(), image.data());
    });
    run.buffers.output(buffers::image, image);
}

void replay_filter(ReplayStage& run) {
    const auto pixels = run.parameters.image_width * run.parameters.image_height;
    const std::span<const Vec3> image = run.buffers.input(buffers::image, pixels);
    std::vector<Vec3> filtered(pixels);
    const FilterView view{run.parameters.image_width, run.parameters.image_height, image.data(),
                          filtered.data()};
    run.device.launch_per_item(pixels, [&](std::uint32_t pixel) {
        switch (run.parameters.filter) {
            case reference::Filter::gaussian:
                filter_gaussian(pixel, view);
                break;
            case reference::Filter::bilateral:
                filter_bilateral(pixel, view);
                break;
            default:
                filter_median(pixel, view);
                break;
        }
    });
    run.buffers.output(buffers::filtered, filtered);
}

}  // namespace scotty::emulation
