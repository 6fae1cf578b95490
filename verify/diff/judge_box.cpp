#include "verify/diff/judge_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "reference/numerics/intersect_box.h"

namespace scotty::verify {

using reference::Ray;
using reference::Vec3;
using Entered = reference::Verdict;

namespace {

constexpr double kRounding = double{reference::kBoxPad};
constexpr double kFar = std::numeric_limits<double>::infinity();

/// The distances between which the ray is inside two planes, and how far they may be off.
struct Slab {
    double near = -kFar, far = kFar, margin = 0.0;
    Entered beside = Entered::hit;  ///< of a ray along the planes: where it is
};

Slab slab_of(double low, double high, double origin, double direction) {
    Slab slab;
    const double reach = kRounding * std::max({std::abs(low), std::abs(high), std::abs(origin),
                                               std::abs(low - origin), std::abs(high - origin)});
    if (direction == 0.0) {
        if (origin < low - reach || origin > high + reach)
            slab.beside = Entered::miss;
        else if (origin < low + reach || origin > high - reach)
            slab.beside = Entered::grazing;
        return slab;
    }
    const double a = (low - origin) / direction;
    const double b = (high - origin) / direction;
    slab.near = std::min(a, b);
    slab.far = std::max(a, b);
    slab.margin = reach / std::abs(direction);
    return slab;
}

}  // namespace

BoxVerdict judge_box(const Vec3& low, const Vec3& high, const Ray& ray) {
    std::array<Slab, 3> slabs;
    bool grazes = false;
    for (int axis = 0; axis < 3; ++axis) {
        Slab& slab = slabs[static_cast<std::size_t>(axis)];
        slab = slab_of(low[axis], high[axis], ray.origin[axis], ray.direction[axis]);
        if (low[axis] > high[axis] || slab.beside == Entered::miss) return {};
        grazes = grazes || slab.beside == Entered::grazing;
    }
    const double begin = ray.t_min;
    const double end = ray.t_max;
    BoxVerdict out{Entered::hit, begin, 0.0};
    for (const Slab& slab : slabs) {
        if (slab.near > out.entry) {
            out.entry = slab.near;
            out.margin = slab.margin;
        }
        if (slab.near - slab.margin > end || slab.far + slab.margin < begin) return {};
        grazes = grazes || slab.near + slab.margin > end || slab.far - slab.margin < begin;
        for (const Slab& other : slabs) {
            if (&slab == &other) continue;
            const double margin = slab.margin + other.margin;
            if (slab.near - margin > other.far) return {};
            grazes = grazes || slab.near + margin > other.far;
        }
    }
    if (grazes || begin > end) out.verdict = begin > end ? Entered::miss : Entered::grazing;
    return out;
}

}  // namespace scotty::verify
