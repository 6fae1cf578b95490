/// Recomputes the shading kernels' results for a path, vertex by vertex. The kernels call the same
/// functions (reference/numerics/path.h), so this checks the arguments that they pass and where
/// they put the results.
#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "reference/numerics/path.h"
#include "reference/numerics/rng.h"
#include "verify/base/same_bits.h"
#include "verify/invariants/check_state.h"

namespace scotty::verify {

using namespace reference;  // in this file only: records and vectors

namespace {

/// Reports one failure, at the first ray whose value is not the expected one.
class Expectation {
 public:
    Expectation(CheckState& state, const StageView& stage) : state_(state), stage_(stage) {}

    template <class T>
    bool equal(std::size_t ray, std::string_view field, const T& expected, const T& found) {
        if (same_bits(expected, found)) return true;
        Failure failure = failure_at(stage_, invariant::kShading,
                                     "not what this vertex of the path gives, computed again");
        failure.ray = static_cast<std::uint32_t>(ray);
        failure.field = fmt::format("{}[{}]", field, ray);
        failure.expected = text(expected);
        failure.found = text(found);
        state_.add(std::move(failure));
        return false;
    }

 private:
    template <class T>
    static std::string text(const T& value) {
        return exact(value);
    }
    static std::string text(std::uint32_t value) { return fmt::format("{}", value); }

    CheckState& state_;
    const StageView& stage_;
};

/// Whether the state of all paths of `n` rays has been seen, with hits on triangles that exist;
/// check_merge has reported others.
bool knows(const CheckState& state, std::size_t n) {
    const PathState& paths = state.paths;
    return paths.rays.size() == n && paths.throughput.size() == n && paths.pixel.size() == n &&
           paths.sample.size() == n && paths.flags.size() == n && paths.path_hits.size() == n &&
           paths.radiance.size() == n &&
           std::all_of(paths.path_hits.begin(), paths.path_hits.end(), [&](const Hit& hit) {
               return !is_hit(hit) || hit.primitive < state.scene.triangles.size();
           });
}

Random4 random_of(const CheckState& state, std::size_t ray, std::uint32_t bounce,
                  Dimension dimension, std::uint32_t offset) {
    return random4(state.parameters.seed, state.paths.pixel[ray], state.paths.sample[ray], bounce,
                   static_cast<std::uint32_t>(dimension) + offset);
}

}  // namespace

void check_primary_paths(CheckState& state, const StageView& stage) {
    const auto rays = stage.get(buffers::rays);
    const auto pixel = stage.get(buffers::pixel);
    const auto sample = stage.get(buffers::sample);
    if (pixel.size() != rays.size() || sample.size() != rays.size()) return;
    const PathParameters parameters = path_parameters(state.parameters);
    const Camera camera = view_of(state.scene).camera;
    Expectation expect(state, stage);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        const Ray ray = primary_ray(camera, parameters, pixel[i], sample[i]);
        if (!expect.equal(i, buffers::rays.name, ray, rays[i])) return;
    }
}

void check_light_paths(CheckState& state, const StageView& stage) {
    const auto shadow = stage.get(buffers::shadow_rays);
    const auto potential = stage.get(buffers::potential);
    const PathState& paths = state.paths;
    if (potential.size() != shadow.size() || !knows(state, shadow.size())) return;
    const PathParameters parameters = path_parameters(state.parameters);
    const SceneView scene = view_of(state.scene);
    Expectation expect(state, stage);
    for (std::size_t i = 0; i < shadow.size(); ++i) {
        DirectLight light{dead_ray(), Vec3(0.0f, 0.0f, 0.0f)};
        if ((paths.flags[i] & kPathAlive) != 0 && is_hit(paths.path_hits[i])) {
            light = sample_direct_light(
                scene, parameters, paths.rays[i], paths.path_hits[i], paths.throughput[i],
                random_of(state, i, stage.bounce, Dimension::light, stage.light));
        }
        if (!expect.equal(i, buffers::shadow_rays.name, light.shadow, shadow[i])) return;
        if (!expect.equal(i, buffers::potential.name, light.potential, potential[i])) return;
    }
}

void check_scattered_paths(CheckState& state, const StageView& stage) {
    const auto rays = stage.get(buffers::rays);
    const std::size_t n = rays.size();
    const auto throughput = stage.get(buffers::throughput);
    const auto radiance = stage.get(buffers::radiance);
    const auto flags = stage.get(buffers::flags);
    const PathState& paths = state.paths;
    if (throughput.size() != n || radiance.size() != n || flags.size() != n || !knows(state, n)) {
        return;
    }
    const PathParameters parameters = path_parameters(state.parameters);
    const SceneView scene = view_of(state.scene);
    Expectation expect(state, stage);
    for (std::size_t i = 0; i < n; ++i) {
        const Scattered next = scatter(scene, parameters, stage.bounce, paths.rays[i],
                                       paths.path_hits[i], paths.throughput[i], paths.flags[i],
                                       random_of(state, i, stage.bounce, Dimension::scatter, 0));
        if (!expect.equal(i, buffers::rays.name, next.ray, rays[i]) ||
            !expect.equal(i, buffers::throughput.name, next.throughput, throughput[i]) ||
            !expect.equal(i, buffers::radiance.name, paths.radiance[i] + next.emitted,
                          radiance[i]) ||
            !expect.equal(i, buffers::flags.name, next.flags, flags[i])) {
            return;
        }
    }
}

}  // namespace scotty::verify
