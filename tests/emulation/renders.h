/// Small renders and comparisons for the tests of emulation/.
#pragma once

#include <cstring>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "emulation/host/pipeline.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/wide_bvh.h"
#include "scenes/scenes.h"
#include "tests/catch.h"

namespace scotty::emulation::test {

/// A built-in scene, loaded once per program.
inline const reference::Scene& scene_named(const std::string& name) {
    static std::map<std::string, reference::Scene> scenes;
    const auto place = scenes.find(name);
    if (place != scenes.end()) return place->second;
    return scenes.emplace(name, scenes::load_scene(name)).first->second;
}

/// Its BVH, built once per program and width.
inline const reference::WideBvh& bvh_of(const std::string& name, int width) {
    static std::map<std::pair<std::string, int>, reference::WideBvh> trees;
    const auto place = trees.find({name, width});
    if (place != trees.end()) return place->second;
    return trees
        .emplace(std::pair(name, width),
                 reference::build_wide_bvh(scene_named(name), {width, 4, 1}))
        .first->second;
}

inline reference::PipelineParameters tiny(std::uint32_t width, std::uint32_t height) {
    reference::PipelineParameters p;
    p.image_width = width;
    p.image_height = height;
    p.spp = 2;
    p.bounces = 2;
    return p;
}

/// Renders a built-in scene in few pixels.
inline reference::Image render(const std::string& scene, const reference::PipelineParameters& p,
                               const DeviceOptions& device = {}) {
    reference::WideBvh bvh = bvh_of(scene, p.width);
    cut_levels(bvh, p.queue_levels);
    return Pipeline(scene_named(scene), bvh, p, device).render();
}

inline reference::Image render(const reference::Scene& scene,
                               const reference::PipelineParameters& p) {
    const reference::WideBvh bvh = reference::build_wide_bvh(scene, bvh_parameters(p, 1));
    return Pipeline(scene, bvh, p).render();
}

inline std::size_t differing_pixels(const reference::Image& a, const reference::Image& b) {
    REQUIRE(a.pixels.size() == b.pixels.size());
    std::size_t count = 0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        count += std::memcmp(&a.pixels[i], &b.pixels[i], sizeof a.pixels[i]) != 0 ? 1 : 0;
    }
    return count;
}

inline bool same_bits(std::span<const reference::Hit> a, std::span<const reference::Hit> b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size_bytes()) == 0;
}

inline reference::Vec3 mean_of(const reference::Image& image) {
    double sum[3] = {0.0, 0.0, 0.0};
    for (const reference::Vec3& pixel : image.pixels) {
        for (int c = 0; c < 3; ++c) sum[c] += pixel[c];
    }
    const auto n = static_cast<double>(image.pixels.size());
    return {static_cast<float>(sum[0] / n), static_cast<float>(sum[1] / n),
            static_cast<float>(sum[2] / n)};
}

}  // namespace scotty::emulation::test
