/// Whether a float ray-box test may, must or must not let a ray in: the judge of other programs'
/// queues.
#pragma once

#include "reference/base/vec3.h"
#include "reference/contract/records.h"
#include "reference/truth/ray_triangle_double.h"

namespace scotty::verify {

struct BoxVerdict {
    reference::Verdict verdict = reference::Verdict::miss;
    double entry = 0.0;   ///< distance where the ray enters the box, at least t_min
    double margin = 0.0;  ///< how far float rounding may move it
};

/// In double precision. A plane's distance may be off by kBoxPad of the largest length that the
/// test rounds, as in intersect_box.h; where that decides, the ray grazes the box. The two planes
/// of one axis are never confused, so that a flat box that is crossed must be entered.
BoxVerdict judge_box(const reference::Vec3& low, const reference::Vec3& high,
                     const reference::Ray& ray);

}  // namespace scotty::verify
