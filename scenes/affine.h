/// Node transforms in double precision: points are rounded to float once, at the end.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "reference/base/vec3.h"

namespace scotty::scenes {

using Point = std::array<double, 3>;

constexpr double kDegree = 3.14159265358979323846 / 180.0;  ///< in radians

inline reference::Vec3 rounded(const Point& p) {
    return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}
inline Point widened(const reference::Vec3& v) { return {v.x, v.y, v.z}; }

/// Unit vector, zero where there is no direction.
inline Point unit(const Point& p) {
    const double norm = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
    if (!(norm > 0.0) || !std::isfinite(norm)) return {0.0, 0.0, 0.0};
    return {p[0] / norm, p[1] / norm, p[2] / norm};
}

/// Three rows of four: p' = M p + t.
struct Affine {
    std::array<std::array<double, 4>, 3> m = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

    Point vector(const Point& v) const {
        Point out{};
        for (std::size_t r = 0; r < 3; ++r) {
            out[r] = m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2];
        }
        return out;
    }
    Point point(const Point& p) const {
        Point out = vector(p);
        for (std::size_t r = 0; r < 3; ++r) out[r] += m[r][3];
        return out;
    }
    /// Minor with its sign: the matrix of these carries normals (as the inverse transpose does, but
    /// without dividing by a determinant that may be zero).
    double cofactor(std::size_t r, std::size_t c) const {
        const std::size_t r1 = (r + 1) % 3;
        const std::size_t r2 = (r + 2) % 3;
        const std::size_t c1 = (c + 1) % 3;
        const std::size_t c2 = (c + 2) % 3;
        return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
    }
    double determinant() const {
        return m[0][0] * cofactor(0, 0) + m[0][1] * cofactor(0, 1) + m[0][2] * cofactor(0, 2);
    }
    /// Unit normal of the transformed surface, on the side that the transformed normal is on; zero
    /// where the surface collapses.
    Point normal(const Point& n) const {
        const double sign = determinant() < 0.0 ? -1.0 : 1.0;
        Point out{};
        for (std::size_t r = 0; r < 3; ++r) {
            out[r] = sign * (cofactor(r, 0) * n[0] + cofactor(r, 1) * n[1] + cofactor(r, 2) * n[2]);
        }
        return unit(out);
    }
};

/// How far the last row of a matrix may be from 0 0 0 w and still be that, rounded by an exporter.
constexpr double kLastRowTolerance = 1e-6;

/// The transform of a matrix whose four rows are written one behind the other, divided by the last
/// number. Nothing where its last row is not 0 0 0 w with w other than 0: that is a perspective.
inline std::optional<Affine> affine_of_rows(const std::array<double, 16>& rows) {
    const double w = rows[15];
    if (w == 0.0) return std::nullopt;
    for (const std::size_t k : {12u, 13u, 14u}) {
        if (!(std::abs(rows[k]) <= kLastRowTolerance * std::abs(w))) return std::nullopt;
    }
    // What is as good as 1 stays out of the numbers, so that they keep their bits.
    const double divisor = std::abs(w - 1.0) <= kLastRowTolerance ? 1.0 : w;
    Affine out;
    for (std::size_t k = 0; k < 12; ++k) out.m[k / 4][k % 4] = rows[k] / divisor;
    return out;
}

/// `a` after `b`.
inline Affine operator*(const Affine& a, const Affine& b) {
    Affine out;
    for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 4; ++c) {
            out.m[r][c] = a.m[r][0] * b.m[0][c] + a.m[r][1] * b.m[1][c] + a.m[r][2] * b.m[2][c] +
                          (c == 3 ? a.m[r][3] : 0.0);
        }
    }
    return out;
}

}  // namespace scotty::scenes
