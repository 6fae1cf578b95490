/// The CUDA text under the thread sanitizer: blocks on plain threads, every launch of a small
/// render. Says nothing where no two blocks touch one location with a plain write; the sanitizer
/// ends the program where two do.
#include <cstdio>

#include "reference/wide_bvh.h"
#include "scenes/scenes.h"
#include "verify/simt/simt_pipeline.h"

int main() {
    using namespace scotty;
    const reference::Scene scene = scenes::load_scene("spheres");
    for (const auto mode : {reference::HitMode::buffer, reference::HitMode::packed}) {
        for (const auto early_out : {reference::EarlyOut::level, reference::EarlyOut::immediate}) {
            reference::PipelineParameters p;
            p.image_width = 24;
            p.image_height = 17;
            p.spp = 1;
            p.bounces = 1;
            p.light_samples = 1;
            p.width = 4;
            p.rays_per_block = 32;
            p.hit_mode = mode;
            p.early_out = early_out;
            const auto bvh = reference::build_wide_bvh(scene, {p.width, p.max_leaf_size, 1});
            simt::make_simt_pipeline(scene, bvh, p)->render();
        }
    }
    std::puts("no race");
}
