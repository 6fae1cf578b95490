/// The independent truths that traversal is held against: brute force and Embree.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "reference/contract/records.h"
#include "reference/contract/scene.h"

namespace scotty::reference {

/// Closest hits by testing every triangle, with the same intersect_triangle() and tie rule as the
/// pipelines: their answers must be these bits. O(rays x triangles); in parallel over rays.
/// `hits` has one entry per ray.
void brute_force_closest(const Scene& scene, std::span<const Ray> rays, std::span<Hit> hits);

/// Embree, robust mode: another implementation of another algorithm, by other people.
/// Throws missing_environment when Embree cannot start, internal on Embree errors.
class EmbreeTracer {
 public:
    explicit EmbreeTracer(const Scene& scene);
    ~EmbreeTracer();
    EmbreeTracer(EmbreeTracer&&) noexcept;
    EmbreeTracer& operator=(EmbreeTracer&&) noexcept;

    /// Embree's own t, u, v; single-ray queries, in parallel over rays. Half-open interval
    /// [t_min, t_max); dead rays give no_hit().
    void closest(std::span<const Ray> rays, std::span<Hit> hits) const;
    /// 1 where something is hit in [t_min, t_max), else 0.
    void occluded(std::span<const Ray> rays, std::span<std::uint8_t> results) const;
    Hit closest(const Ray& ray) const;
    bool occluded(const Ray& ray) const;

    static std::string version();  ///< "3.13.5"

 private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Why our hit and Embree's differ.
enum class Disagreement : std::uint8_t {
    none,         ///< same primitive, or both miss (t may differ by rounding)
    tie,          ///< two primitives at the same distance, within rounding of both tests
    grazing,      ///< the ray passes an edge, a vertex or an edge-on triangle within rounding
    ours_wrong,   ///< must never happen
    embree_wrong  ///< ours is right in higher precision, Embree's is not
};
const char* to_string(Disagreement verdict);

struct Adjudication {
    Disagreement verdict = Disagreement::none;
    std::string explanation;  ///< empty for none; else distances and margins as computed
};

/// Decides in double precision (or better) who is right about one ray: `embree` is what Embree
/// found, `ours` what the pipeline under test found. Ours is also held to intersect_triangle(): on
/// an edge that either may miss, what that test hits (watertight across the edge) must not be lost.
Adjudication adjudicate_closest(const Scene& scene, const Ray& ray, const Hit& ours,
                                const Hit& embree);
/// The same for occlusion queries: only whether something is hit.
Adjudication adjudicate_occluded(const Scene& scene, const Ray& ray, bool ours, bool embree,
                                 const Hit& closest_by_embree);

}  // namespace scotty::reference
