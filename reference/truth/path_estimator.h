/// One path of the independent path tracer: its own sampling, its own numbers, double precision.
/// Internal to reference/.
///
/// What it estimates is what the pipeline's pictures are defined to be (docs/design.md, "Emission
/// is counted once"); how is its own affair. Where the pipeline picks one light at random and
/// samples it by area, this adds up all lights, weighs area lights' samples with the scattered
/// ray's by the balance heuristic (Veach and Guibas 1995), and leaves the sky to the scattered ray.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "reference/truth/coincident.h"
#include "reference/truth/tracers.h"

namespace scotty::reference {

using Double3 = glm::dvec3;

/// Uniform numbers in [0, 1) with 53 bits: Threefry-4x64 (Salmon et al. 2011), counted along the
/// path. Shares neither generator nor layout with rng.h.
class PathNumbers {
 public:
    PathNumbers(std::uint64_t seed, std::uint64_t pixel, std::uint64_t sample)
        : seed_(seed), pixel_(pixel), sample_(sample) {}
    double next();

 private:
    std::uint64_t seed_, pixel_, sample_;
    std::uint64_t block_ = 0;
    unsigned used_ = 4;
    std::uint64_t bits_[4] = {};
};

class PathEstimator {
 public:
    /// Keeps a reference to the scene. Of the parameters it takes image size, bounces, seed, and
    /// whether there are light samples at all: none means that paths must find lights themselves.
    PathEstimator(const Scene& scene, const PipelineParameters& parameters);

    /// Radiance that one path brings to a pixel: a pure function, for any thread.
    Double3 radiance(std::uint32_t pixel, std::uint64_t sample) const;

 private:
    /// Where a ray meets a surface, as the ray sees it.
    struct Vertex {
        double distance;  ///< along the ray
        Double3 position;
        Double3 geometric_normal, shading_normal;  ///< unit, on the viewer's side
        bool front;                                ///< the winding's outside is seen
        double offset;                             ///< how far off the surface rays start
        const Material* material;
    };
    struct Segment {
        Double3 origin, direction;
    };
    struct Scattering {
        Double3 direction;
        Double3 weight;
        bool specular;
    };

    Segment camera_segment(std::uint32_t pixel, PathNumbers& numbers) const;
    std::optional<Vertex> find(const Segment& segment) const;
    bool is_free(const Vertex& from, const Double3& to) const;
    bool is_free_towards(const Vertex& from, const Double3& direction) const;
    Segment leave(const Vertex& vertex, const Double3& direction) const;

    /// All lights but the sky, by samples of the lights; for a metal those without extent only.
    Double3 light_by_lights(const Vertex& vertex, const Double3& incoming,
                            PathNumbers& numbers) const;
    Double3 from_area_light(const Light& light, const Vertex& vertex, double u, double v) const;
    /// Area lights and sky, by the ray that leaves a vertex and what it meets. `cosine` at a
    /// diffuse vertex, which takes its share beside light_by_lights(); none where nobody else finds
    /// them.
    Double3 light_by_scattering(const Segment& segment, std::optional<double> cosine,
                                const std::optional<Vertex>& next) const;
    Double3 sky(const Double3& direction) const;
    std::optional<Scattering> scatter(const Vertex& vertex, const Double3& incoming,
                                      PathNumbers& numbers) const;

    const Scene& scene_;
    EmbreeTracer tracer_;
    PipelineParameters parameters_;
    bool samples_lights_;
    bool scattering_finds_light_;  ///< there are area lights or a sky
    CoincidentTriangles coincident_;
};

}  // namespace scotty::reference
