/// The stages between traversals: rays are rays, light is added where it may be, pixels are whole.
#include <fmt/format.h>

#include <cstdint>

#include "verify/base/same_bits.h"
#include "verify/invariants/check_state.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records and vectors

namespace {

/// Directions are normalised in float: this is 80 units in the last place.
constexpr float kUnitTolerance = 1.0e-5f;

/// Checks that rays are finite (check_finite reports), and dead or of unit direction.
void check_ray_records(CheckState& state, const StageView& stage, std::string_view field,
                       std::span<const Ray> rays) {
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Ray& ray = rays[i];
        const float norm = dot(ray.direction, ray.direction);
        const bool unit = norm > 1.0f - kUnitTolerance && norm < 1.0f + kUnitTolerance;
        if (is_dead(ray) || (unit && ray.t_min >= 0.0f)) continue;
        Failure failure = failure_at(stage, invariant::kRayRecord,
                                     unit ? "a living ray starts behind its origin"
                                          : "a living ray's direction is not of unit length");
        failure.ray = static_cast<std::uint32_t>(i);
        failure.field = fmt::format("{}[{}]", field, i);
        failure.expected = unit ? "t_min >= 0" : "length 1";
        failure.found =
            unit ? exact(ray.t_min) : fmt::format("length {}", exact(length(ray.direction)));
        state.add(std::move(failure));
        return;
    }
}

void fail_ray(CheckState& state, const StageView& stage, const char* tag, std::size_t ray,
              std::string field, std::string sentence, std::string expected, std::string found) {
    Failure failure = failure_at(stage, tag, std::move(sentence));
    failure.ray = static_cast<std::uint32_t>(ray);
    failure.field = std::move(field);
    failure.expected = std::move(expected);
    failure.found = std::move(found);
    state.add(std::move(failure));
}

}  // namespace

void check_primary_rays(CheckState& state, const StageView& stage) {
    const auto rays = stage.get(buffers::rays);
    const std::size_t n = rays.size();
    const auto throughput = expect_buffer(state, stage, buffers::throughput, n);
    const auto radiance = expect_buffer(state, stage, buffers::radiance, n);
    const auto potential = expect_buffer(state, stage, buffers::potential, n);
    const auto pixel = expect_buffer(state, stage, buffers::pixel, n);
    const auto sample = expect_buffer(state, stage, buffers::sample, n);
    const auto depth = expect_buffer(state, stage, buffers::depth, n);
    const auto flags = expect_buffer(state, stage, buffers::flags, n);
    if (throughput.size() != n || radiance.size() != n || potential.size() != n ||
        pixel.size() != n || sample.size() != n || depth.size() != n || flags.size() != n) {
        return;
    }
    check_ray_records(state, stage, buffers::rays.name, rays);
    const std::size_t pixels =
        std::size_t{state.parameters.image_width} * state.parameters.image_height;
    auto& samples = state.image.samples;
    samples.resize(pixels, 0);
    for (std::size_t i = 0; i < n; ++i) {
        // Samples of a pixel come in order, within a batch and from batch to batch.
        const bool known = pixel[i] < pixels;
        if (!known || sample[i] != samples[pixel[i]] || sample[i] >= state.parameters.spp) {
            fail_ray(state, stage, invariant::kPixels, i, fmt::format("pixel, sample [{}]", i),
                     "not the pixel's next sample",
                     known ? fmt::format("sample {} of pixel {}", samples[pixel[i]], pixel[i])
                           : fmt::format("a pixel below {}", pixels),
                     fmt::format("sample {} of pixel {}", sample[i], pixel[i]));
            return;
        }
        ++samples[pixel[i]];
        if (!same_bits(throughput[i], Vec3(1.0f)) || !same_bits(radiance[i], Vec3(0.0f)) ||
            !same_bits(potential[i], Vec3(0.0f)) || depth[i] != 0 || flags[i] != kPathAlive ||
            is_dead(rays[i])) {
            fail_ray(state, stage, invariant::kPathState, i, fmt::format("path state [{}]", i),
                     "a path does not start fresh",
                     "a living ray, throughput 1, radiance 0, potential 0, depth 0, flags 1",
                     fmt::format("throughput {}, radiance {}, potential {}, depth {}, flags {}",
                                 exact(throughput[i]), exact(radiance[i]), exact(potential[i]),
                                 depth[i], flags[i]));
            return;
        }
    }
}

void check_direct_light_rays(CheckState& state, const StageView& stage) {
    const auto hits = stage.get(buffers::path_hits);
    const std::size_t n = hits.size();
    const auto shadow = expect_buffer(state, stage, buffers::shadow_rays, n);
    const auto potential = expect_buffer(state, stage, buffers::potential, n);
    check_ray_records(state, stage, buffers::shadow_rays.name, shadow);
    for (std::size_t i = 0; i < shadow.size() && i < potential.size(); ++i) {
        if (!is_hit(hits[i]) && !is_dead(shadow[i])) {
            fail_ray(state, stage, invariant::kPathState, i, fmt::format("shadow_rays[{}]", i),
                     "a path that hit nothing asks for light", "a dead ray", exact(shadow[i]));
            return;
        }
        if (is_dead(shadow[i])
                ? !is_zero(potential[i])
                : !(potential[i].x >= 0 && potential[i].y >= 0 && potential[i].z >= 0)) {
            fail_ray(state, stage, invariant::kPathState, i, fmt::format("potential[{}]", i),
                     "potential radiance is zero without a shadow ray and never negative",
                     is_dead(shadow[i]) ? "0" : ">= 0", exact(potential[i]));
            return;
        }
    }
}

void check_resolve_light(CheckState& state, const StageView& stage) {
    const auto hits = stage.get(buffers::shadow_hits);
    const std::size_t n = hits.size();
    const auto potential = expect_buffer(state, stage, buffers::potential, n);
    const auto radiance = expect_buffer(state, stage, buffers::radiance, n);
    const PathState& paths = state.paths;
    if (paths.radiance.size() != n || paths.shadow_rays.size() != n) return;
    for (std::size_t i = 0; i < potential.size() && i < radiance.size(); ++i) {
        const bool lit = !is_hit(hits[i]) && !is_dead(paths.shadow_rays[i]);
        const Vec3 expected = lit ? paths.radiance[i] + potential[i] : paths.radiance[i];
        if (same_bits(expected, radiance[i])) continue;
        fail_ray(state, stage, invariant::kResolveLight, i, fmt::format("radiance[{}]", i),
                 lit ? "the light is free, but its radiance was not added"
                     : "something is in the way, but radiance was added",
                 exact(expected), exact(radiance[i]));
        return;
    }
}

void check_scene_rays(CheckState& state, const StageView& stage) {
    const auto hits = stage.get(buffers::path_hits);
    const std::size_t n = hits.size();
    const auto rays = expect_buffer(state, stage, buffers::rays, n);
    const auto throughput = expect_buffer(state, stage, buffers::throughput, n);
    const auto radiance = expect_buffer(state, stage, buffers::radiance, n);
    const auto flags = expect_buffer(state, stage, buffers::flags, n);
    const auto depth = expect_buffer(state, stage, buffers::depth, n);
    if (rays.size() != n || throughput.size() != n || radiance.size() != n || flags.size() != n ||
        depth.size() != n) {
        return;
    }
    const PathState& paths = state.paths;
    check_ray_records(state, stage, buffers::rays.name, rays);
    const bool last = stage.bounce != kNotApplicable && stage.bounce >= state.parameters.bounces;
    for (std::size_t i = 0; i < n; ++i) {
        const bool alive = (flags[i] & kPathAlive) != 0;
        if (alive == is_dead(rays[i]) || (alive && (!is_hit(hits[i]) || last))) {
            fail_ray(
                state, stage, invariant::kPathState, i, fmt::format("flags[{}], rays[{}]", i, i),
                "a path is alive exactly where its ray is, has hit something and has a "
                "bounce left",
                alive ? "a living ray from a hit before the last bounce" : "a dead ray",
                fmt::format("flags {}, hit: {}, {}", flags[i], exact(hits[i]), exact(rays[i])));
            return;
        }
        const std::uint32_t scatterings =
            i < paths.depth.size() ? paths.depth[i] + alive : depth[i];
        if (depth[i] != scatterings) {
            fail_ray(state, stage, invariant::kPathState, i, fmt::format("depth[{}]", i),
                     "depth counts the scatterings of a path, and nothing else",
                     fmt::format("{}", scatterings), fmt::format("{}", depth[i]));
            return;
        }
        const Vec3 before = i < paths.radiance.size() ? paths.radiance[i] : Vec3(0.0f);
        if (!(radiance[i].x >= before.x && radiance[i].y >= before.y &&
              radiance[i].z >= before.z)) {
            fail_ray(state, stage, invariant::kPathState, i, fmt::format("radiance[{}]", i),
                     "a path has lost radiance", fmt::format(">= {}", exact(before)),
                     exact(radiance[i]));
            return;
        }
    }
}

namespace {

Failure pixel_failure(const CheckState& state, const StageView& stage, std::string_view buffer,
                      std::size_t pixel, const char* sentence, const Vec3& expected,
                      const Vec3& found) {
    Failure failure = failure_at(stage, invariant::kPixels, sentence);
    failure.field =
        fmt::format("{}[{}] (x {}, y {})", buffer, pixel, pixel % state.parameters.image_width,
                    pixel / state.parameters.image_width);
    failure.expected = exact(expected);
    failure.found = exact(found);
    return failure;
}

}  // namespace

void check_image(CheckState& state, const StageView& stage) {
    const auto radiance = stage.get(buffers::radiance);
    const auto pixel = expect_buffer(state, stage, buffers::pixel, radiance.size());
    const std::size_t pixels =
        std::size_t{state.parameters.image_width} * state.parameters.image_height;
    const auto image = expect_buffer(state, stage, buffers::image, pixels);
    const auto variance = expect_buffer(state, stage, buffers::variance, pixels);
    if (pixel.size() != radiance.size() || image.size() != pixels || variance.size() != pixels) {
        return;
    }
    ImageState& sums = state.image;
    sums.summed.resize(pixels, 0);
    sums.sum.resize(pixels, Vec3(0.0f, 0.0f, 0.0f));
    sums.deviations.resize(pixels, Vec3(0.0f, 0.0f, 0.0f));
    for (std::size_t i = 0; i < radiance.size(); ++i) {
        if (pixel[i] >= pixels) return;  // primary_rays has reported it
        const auto before = static_cast<float>(sums.summed[pixel[i]]);
        for (int c = 0; c < 3 && before > 0.0f; ++c) {
            const float mean = sums.sum[pixel[i]][c] / before;
            const float off = radiance[i][c] - mean;
            sums.deviations[pixel[i]][c] += off * off * (before / (before + 1.0f));
        }
        sums.sum[pixel[i]] += radiance[i];
        ++sums.summed[pixel[i]];
    }
    // Sums until a pixel has all its samples, then the mean; in sample order, so bit for bit.
    const auto n = static_cast<float>(state.parameters.spp);
    for (std::size_t p = 0; p < pixels; ++p) {
        const bool complete = sums.summed[p] == state.parameters.spp;
        const Vec3 mean = complete ? sums.sum[p] / n : sums.sum[p];
        Vec3 of_mean = sums.deviations[p];
        if (complete && n > 1.0f) of_mean = of_mean * (1.0f / (n * (n - 1.0f)));
        if (!same_bits(mean, image[p])) {
            state.add(pixel_failure(state, stage, buffers::image.name, p,
                                    complete ? "a pixel is not the mean of its samples"
                                             : "a pixel is not the sum of its samples so far",
                                    mean, image[p]));
            return;
        }
        if (same_bits(of_mean, variance[p])) continue;
        state.add(pixel_failure(
            state, stage, buffers::variance.name, p,
            complete ? "a pixel's variance is not that of its samples' mean"
                     : "a pixel's squared deviations are not those of its samples so far",
            of_mean, variance[p]));
        return;
    }
}

void follow_shading(CheckState& state, const StageView& stage) {
    PathState& paths = state.paths;
    const bool shadow = stage.light != kNotApplicable;
    if (stage.kind == StageKind::merge_intersections) {
        (shadow ? paths.shadow_hits : paths.path_hits) = copy_of(stage.get(buffers::merged));
        return;
    }
    if (stage.kind == StageKind::direct_light_rays) {
        paths.shadow_rays = copy_of(stage.get(buffers::shadow_rays));
        paths.potential = copy_of(stage.get(buffers::potential));
        return;
    }
    paths.radiance = copy_of(stage.get(buffers::radiance));
    if (stage.kind == StageKind::resolve_light) return;
    paths.rays = copy_of(stage.get(buffers::rays));
    paths.throughput = copy_of(stage.get(buffers::throughput));
    paths.flags = copy_of(stage.get(buffers::flags));
    paths.depth = copy_of(stage.get(buffers::depth));
    if (stage.kind == StageKind::scene_rays) return;
    paths.pixel = copy_of(stage.get(buffers::pixel));
    paths.sample = copy_of(stage.get(buffers::sample));
}

}  // namespace scotty::verify
