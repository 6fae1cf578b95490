#include "scenes/triangulate_polygon.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace scotty::scenes {

namespace {

using Triangle = std::array<std::uint32_t, 3>;
using Flat = std::array<double, 2>;

/// Above this many corners a polygon is not searched for crossing edges, which takes n^2 steps.
constexpr std::size_t kMaxCrossingSearch = 512;

/// Above this many corners holes are filled: bridges to them take n^2 steps each.
constexpr std::size_t kMaxCornersWithHoles = 4096;

/// Twice the signed area of a triangle.
double turn(const Flat& a, const Flat& b, const Flat& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Twice the areas of a ring in the three coordinate planes, by Newell's method around its first
/// corner: with signs, and without.
struct ProjectedAreas {
    Point signed_sum{};
    Point absolute_sum{};
};

ProjectedAreas projected_areas(std::span<const Point> ring) {
    ProjectedAreas areas;
    for (std::size_t i = 2; i < ring.size(); ++i) {
        Point u{};
        Point v{};
        for (std::size_t k = 0; k < 3; ++k) {
            u[k] = ring[i - 1][k] - ring[0][k];
            v[k] = ring[i][k] - ring[0][k];
        }
        for (std::size_t k = 0; k < 3; ++k) {
            const double area = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
            areas.signed_sum[k] += area;
            areas.absolute_sum[k] += std::abs(area);
        }
    }
    return areas;
}

std::size_t dominant_axis(const Point& vector) {
    std::size_t axis = 0;
    for (std::size_t k = 1; k < 3; ++k) {
        if (std::abs(vector[k]) > std::abs(vector[axis])) axis = k;
    }
    return axis;
}

/// Drops the dominant coordinate of the outline's normal, which rounds nothing. The outline comes
/// out counter-clockwise.
std::vector<Flat> flatten(std::span<const Point> corners, std::span<const Point> outline) {
    const ProjectedAreas areas = projected_areas(outline);
    std::size_t axis = dominant_axis(areas.signed_sum);
    // The two halves of a polygon that crosses itself may cancel; the plane is there all the same.
    const std::size_t widest = dominant_axis(areas.absolute_sum);
    if (std::abs(areas.signed_sum[axis]) < 1e-6 * areas.absolute_sum[widest]) axis = widest;
    std::size_t x = (axis + 1) % 3;
    std::size_t y = (axis + 2) % 3;
    if (areas.signed_sum[axis] < 0.0) std::swap(x, y);
    std::vector<Flat> flat;
    flat.reserve(corners.size());
    for (const Point& corner : corners) flat.push_back({corner[x], corner[y]});
    return flat;
}

/// Whether the fan around corner 0 covers the ring once.
bool is_fan(const std::vector<Flat>& ring) {
    bool passed_the_back = false;
    for (std::size_t i = 2; i < ring.size(); ++i) {
        if (turn(ring[0], ring[i - 1], ring[i]) < 0.0) return false;
        const double side = turn(ring[0], ring[1], ring[i]);
        if (passed_the_back && side > 0.0) return false;
        passed_the_back |= side < 0.0;
    }
    return true;
}

void append_fan(std::size_t corners, std::vector<Triangle>& triangles) {
    for (std::uint32_t i = 2; i < corners; ++i) triangles.push_back({0, i - 1, i});
}

/// Whether two segments cross in a point inside both.
bool cross_inside(const Flat& a, const Flat& b, const Flat& c, const Flat& d) {
    const double a_side = turn(c, d, a);
    const double b_side = turn(c, d, b);
    const double c_side = turn(a, b, c);
    const double d_side = turn(a, b, d);
    return ((a_side > 0.0 && b_side < 0.0) || (a_side < 0.0 && b_side > 0.0)) &&
           ((c_side > 0.0 && d_side < 0.0) || (c_side < 0.0 && d_side > 0.0));
}

/// A closed chain of corners from which ears are clipped. A corner may occur in it more than once:
/// the bridges to holes run along their two sides.
class Ring {
 public:
    Ring(const std::vector<Flat>& points, std::vector<std::uint32_t> chain)
        : points_(points), chain_(std::move(chain)), size_(chain_.size()) {
        const auto n = static_cast<std::uint32_t>(size_);
        previous_.resize(n);
        next_.resize(n);
        for (std::uint32_t i = 0; i < n; ++i) {
            previous_[i] = (i + n - 1) % n;
            next_[i] = (i + 1) % n;
        }
        place_obstacles();
    }

    /// Clips until nothing is left. Returns false where the polygon crosses itself.
    bool clip(std::vector<Triangle>& triangles) {
        const bool sound = !crosses_itself();
        bool flat_allowed = false;
        while (size_ > 2) {
            const std::size_t before = size_;
            clip_from_candidates(flat_allowed, triangles);
            if (size_ < before) continue;
            if (flat_allowed) return cover_rest(triangles);
            // Corners on a straight line are cut off only once no ear has an area.
            flat_allowed = true;
        }
        return sound;
    }

 private:
    const Flat& point(std::uint32_t i) const { return points_[chain_[i]]; }
    double turn_at(std::uint32_t i) const {
        return turn(point(previous_[i]), point(i), point(next_[i]));
    }

    bool is_ear(std::uint32_t i, bool flat_allowed) const {
        const double area = turn_at(i);
        if (area == 0.0) return flat_allowed;
        if (area < 0.0) return false;
        bool is_free = true;
        for_obstacles_near(i, [&](std::uint32_t other) {
            is_free = !obstructs(other, i);
            return is_free;
        });
        return is_free;
    }

    /// Whether corner `other` lies in the ear at `i`, or enters it from one of its corners.
    bool obstructs(std::uint32_t other, std::uint32_t i) const {
        if (next_[other] == kRemoved || other == i || other == previous_[i] || other == next_[i]) {
            return false;
        }
        const Flat& a = point(previous_[i]);
        const Flat& b = point(i);
        const Flat& c = point(next_[i]);
        const Flat& p = point(other);
        if (p == b) return inside_wedge(i, previous_[other]) || inside_wedge(i, next_[other]);
        if (p == a || p == c) return false;
        return turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
    }

    bool inside_wedge(std::uint32_t i, std::uint32_t other) const {
        return turn(point(previous_[i]), point(i), point(other)) > 0.0 &&
               turn(point(i), point(next_[i]), point(other)) > 0.0;
    }

    /// Tries each corner once, and again whenever it gets a new neighbour.
    void clip_from_candidates(bool flat_allowed, std::vector<Triangle>& triangles) {
        std::vector<std::uint32_t> candidates;
        std::uint32_t at = first_;
        for (std::size_t i = 0; i < size_; ++i, at = next_[at]) candidates.push_back(at);
        for (std::size_t i = 0; i < candidates.size() && size_ > 2; ++i) {
            const std::uint32_t corner = candidates[i];
            if (next_[corner] == kRemoved || !is_ear(corner, flat_allowed)) continue;
            triangles.push_back({chain_[previous_[corner]], chain_[corner], chain_[next_[corner]]});
            candidates.push_back(previous_[corner]);
            candidates.push_back(next_[corner]);
            remove(corner);
        }
    }

    /// Fans out what has no ear left, which happens only where the polygon crosses itself.
    bool cover_rest(std::vector<Triangle>& triangles) const {
        for (std::uint32_t i = next_[first_]; next_[i] != first_; i = next_[i]) {
            triangles.push_back({chain_[first_], chain_[i], chain_[next_[i]]});
        }
        return false;
    }

    void remove(std::uint32_t i) {
        first_ = next_[i];
        next_[previous_[i]] = next_[i];
        previous_[next_[i]] = previous_[i];
        next_[i] = kRemoved;
        --size_;
    }

    /// Corners that are not convex, in a grid: only these can lie in an ear.
    void place_obstacles() {
        low_ = high_ = point(0);
        for (std::uint32_t i = 0; i < size_; ++i) {
            for (std::size_t k = 0; k < 2; ++k) {
                low_[k] = std::min(low_[k], point(i)[k]);
                high_[k] = std::max(high_[k], point(i)[k]);
            }
        }
        side_ = 1 + static_cast<std::size_t>(std::sqrt(static_cast<double>(size_) / 4.0));
        cells_.resize(side_ * side_);
        for (std::uint32_t i = 0; i < size_; ++i) {
            if (turn_at(i) > 0.0) continue;
            cells_[cell_of(point(i)[1], 1) * side_ + cell_of(point(i)[0], 0)].push_back(i);
        }
    }

    std::size_t cell_of(double value, std::size_t k) const {
        const double extent = high_[k] - low_[k];
        if (!(extent > 0.0) || !std::isfinite(extent)) return 0;
        const double share = (value - low_[k]) / extent * static_cast<double>(side_);
        return std::min(static_cast<std::size_t>(share), side_ - 1);
    }

    /// Calls `use` for the obstacles in the cells around an ear until it returns false.
    template <class Use>
    void for_obstacles_near(std::uint32_t i, const Use& use) const {
        std::array<std::size_t, 2> first{};
        std::array<std::size_t, 2> last{};
        for (std::size_t k = 0; k < 2; ++k) {
            const auto [least, most] =
                std::minmax({point(previous_[i])[k], point(i)[k], point(next_[i])[k]});
            first[k] = cell_of(least, k);
            last[k] = cell_of(most, k);
        }
        for (std::size_t y = first[1]; y <= last[1]; ++y) {
            for (std::size_t x = first[0]; x <= last[0]; ++x) {
                for (const std::uint32_t other : cells_[y * side_ + x]) {
                    if (!use(other)) return;
                }
            }
        }
    }

    bool crosses_itself() const {
        if (size_ > kMaxCrossingSearch) return false;
        for (std::uint32_t i = 0; i < size_; ++i) {
            for (std::uint32_t k = i + 2; k < size_; ++k) {
                if (cross_inside(point(i), point(next_[i]), point(k), point(next_[k]))) return true;
            }
        }
        return false;
    }

    static constexpr std::uint32_t kRemoved = std::numeric_limits<std::uint32_t>::max();
    const std::vector<Flat>& points_;
    std::vector<std::uint32_t> chain_;
    std::size_t size_;
    std::uint32_t first_ = 0;
    std::vector<std::uint32_t> previous_;
    std::vector<std::uint32_t> next_;
    Flat low_{};
    Flat high_{};
    std::size_t side_ = 1;
    std::vector<std::vector<std::uint32_t>> cells_;
};

/// Signed area of corners first .. last - 1, doubled.
double ring_area(const std::vector<Flat>& points, const std::vector<std::uint32_t>& ring) {
    double area = 0.0;
    for (std::size_t i = 2; i < ring.size(); ++i) {
        area += turn(points[ring[0]], points[ring[i - 1]], points[ring[i]]);
    }
    return area;
}

/// Whether the segment between two corners crosses no edge of `chain`.
bool is_visible(const std::vector<Flat>& points, const std::vector<std::uint32_t>& chain,
                const Flat& from, const Flat& to) {
    for (std::size_t i = 0; i < chain.size(); ++i) {
        const Flat& a = points[chain[i]];
        const Flat& b = points[chain[(i + 1) % chain.size()]];
        if (cross_inside(from, to, a, b)) return false;
        // A bridge that runs through a third corner would touch the chain twice.
        if (a != from && a != to && turn(from, to, a) == 0.0 && std::min(from[0], to[0]) <= a[0] &&
            a[0] <= std::max(from[0], to[0]) && std::min(from[1], to[1]) <= a[1] &&
            a[1] <= std::max(from[1], to[1])) {
            return false;
        }
    }
    return true;
}

/// Whether the direction from corner `i` of `chain` to `target` starts inside the polygon.
bool starts_inside(const std::vector<Flat>& points, const std::vector<std::uint32_t>& chain,
                   std::size_t i, const Flat& target) {
    const std::size_t n = chain.size();
    const Flat& before = points[chain[(i + n - 1) % n]];
    const Flat& at = points[chain[i]];
    const Flat& after = points[chain[(i + 1) % n]];
    const bool left_of_in = turn(before, at, target) > 0.0;
    const bool left_of_out = turn(at, after, target) > 0.0;
    return turn(before, at, after) > 0.0 ? left_of_in && left_of_out : left_of_in || left_of_out;
}

/// Joins a hole to the chain by a bridge from its rightmost corner to the nearest corner of the
/// chain that it sees. Returns false where it sees none: the hole is not inside.
bool join_hole(const std::vector<Flat>& points, std::vector<std::uint32_t> hole,
               std::vector<std::uint32_t>& chain) {
    if (ring_area(points, hole) > 0.0) std::reverse(hole.begin(), hole.end());
    const auto rightmost =
        std::max_element(hole.begin(), hole.end(),
                         [&](std::uint32_t a, std::uint32_t b) { return points[a] < points[b]; });
    std::rotate(hole.begin(), rightmost, hole.end());
    const Flat& start = points[hole[0]];
    std::size_t best = chain.size();
    double best_distance = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < chain.size(); ++i) {
        const Flat& end = points[chain[i]];
        const double distance = std::hypot(end[0] - start[0], end[1] - start[1]);
        if (distance < best_distance && starts_inside(points, chain, i, start) &&
            is_visible(points, chain, start, end) && is_visible(points, hole, start, end)) {
            best = i;
            best_distance = distance;
        }
    }
    if (best == chain.size()) return false;
    hole.push_back(hole[0]);
    hole.push_back(chain[best]);
    chain.insert(chain.begin() + static_cast<std::ptrdiff_t>(best) + 1, hole.begin(), hole.end());
    return true;
}

}  // namespace

bool triangulate_polygon(std::span<const Point> corners, std::vector<Triangle>& triangles) {
    if (corners.size() <= 3) {
        append_fan(corners.size(), triangles);
        return true;
    }
    const std::vector<Flat> flat = flatten(corners, corners);
    if (is_fan(flat)) {
        append_fan(corners.size(), triangles);
        return true;
    }
    std::vector<std::uint32_t> chain(corners.size());
    std::iota(chain.begin(), chain.end(), 0u);
    return Ring(flat, std::move(chain)).clip(triangles);
}

bool triangulate_polygon(std::span<const Point> corners, std::span<const std::uint32_t> ring_sizes,
                         std::vector<Triangle>& triangles) {
    if (ring_sizes.size() == 1) return triangulate_polygon(corners, triangles);
    if (ring_sizes.empty() || ring_sizes[0] < 3) return true;
    if (corners.size() > kMaxCornersWithHoles) {
        triangulate_polygon(corners.first(ring_sizes[0]), triangles);
        return false;
    }
    const std::vector<Flat> flat = flatten(corners, corners.first(ring_sizes[0]));
    std::vector<std::uint32_t> chain(ring_sizes[0]);
    std::iota(chain.begin(), chain.end(), 0u);
    // Holes further right are joined first: those to their left may need a bridge to them.
    std::vector<std::vector<std::uint32_t>> holes;
    std::uint32_t first = ring_sizes[0];
    for (const std::uint32_t size : ring_sizes.subspan(1)) {
        std::vector<std::uint32_t>& hole = holes.emplace_back(size);
        std::iota(hole.begin(), hole.end(), first);
        first += size;
    }
    const auto rightmost = [&](const std::vector<std::uint32_t>& hole) {
        double most = -std::numeric_limits<double>::infinity();
        for (const std::uint32_t corner : hole) most = std::max(most, flat[corner][0]);
        return most;
    };
    std::stable_sort(holes.begin(), holes.end(),
                     [&](const auto& a, const auto& b) { return rightmost(a) > rightmost(b); });
    bool sound = true;
    for (auto& hole : holes) {
        if (hole.size() < 3) continue;
        sound &= join_hole(flat, std::move(hole), chain);
    }
    return Ring(flat, std::move(chain)).clip(triangles) && sound;
}

}  // namespace scotty::scenes
