/// One ray and one triangle in double precision, with what float rounding may change: the judge
/// between two float tracers. Internal to reference/.
///
/// Geometry is Woop's (the triangle is sheared so that the ray is the z axis), but every result
/// comes with a margin that covers the rounding of *both* float tests: Woop's, whose products round
/// relative to the sheared vertices, and Embree's Pluecker test, whose products round relative to
/// the vertices as seen from the origin. Both therefore shift an edge by a few units in the last
/// place of `reach`, the distance to the farthest vertex; 2^-20 of it is allowed.
#pragma once

#include <string>

#include "reference/contract/records.h"
#include "reference/contract/scene.h"

namespace scotty::reference {

/// What a float test may say.
enum class Verdict {
    miss,     ///< must miss
    grazing,  ///< may hit or miss: an edge, an edge-on triangle, or an end of the ray is too near
    hit       ///< must hit
};

/// Lengths, here and below, are distances along or from the ray in the scene's unit.
struct TriangleVerdict {
    Verdict verdict = Verdict::miss;
    double t = 0.0;  ///< where the line meets the triangle's plane, in the ray's t
    /// How far t may be off in float; bounded by the triangle's own extent along the ray, because
    /// intersect_triangle() keeps t within the triangle's box.
    double t_margin = 0.0;
    double u = 0.0, v = 0.0;
    double uv_margin = 0.0;      ///< infinite for edge-on triangles
    double edge_distance = 0.0;  ///< how far inside the nearest edge; negative: outside
    double edge_margin = 0.0;    ///< below this, the edge is grazed
    double edge_on = 0.0;        ///< doubled projected area over its margin; below 1: edge-on
};

/// `triangle` is an index into scene.triangles. A ray without direction misses.
TriangleVerdict judge_triangle(const Scene& scene, std::uint32_t triangle, const Ray& ray);

/// The figures of a verdict in words, for explanations.
std::string describe(const TriangleVerdict& verdict);

}  // namespace scotty::reference
