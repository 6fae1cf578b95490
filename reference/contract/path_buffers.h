/// Lists of the buffers that the shading stages read and write, over any back end's memory.
#pragma once

#include "reference/contract/buffers.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/views.h"

namespace scotty::reference {

/// Calls f(handle, buffer) for every buffer that has a row per ray. `state` has a member for each,
/// named like its handle.
template <class State, class F>
void for_each_by_ray(State& state, const F& f) {
    f(buffers::rays, state.rays);
    f(buffers::shadow_rays, state.shadow_rays);
    f(buffers::throughput, state.throughput);
    f(buffers::radiance, state.radiance);
    f(buffers::potential, state.potential);
    f(buffers::pixel, state.pixel);
    f(buffers::sample, state.sample);
    f(buffers::depth, state.depth);
    f(buffers::flags, state.flags);
    f(buffers::path_hits, state.path_hits);
    f(buffers::shadow_hits, state.shadow_hits);
}

/// The same for all of them: with those that have a row per pixel.
template <class State, class F>
void for_each_path_buffer(State& state, const F& f) {
    for_each_by_ray(state, f);
    f(buffers::image, state.image);
    f(buffers::variance, state.variance);
    f(buffers::filtered, state.filtered);
}

/// What the kernels are handed of it.
template <class State>
PathView path_view(State& state) {
    return {state.rays.data(),      state.throughput.data(), state.radiance.data(),
            state.potential.data(), state.pixel.data(),      state.sample.data(),
            state.depth.data(),     state.flags.data()};
}

}  // namespace scotty::reference
