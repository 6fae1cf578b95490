#include "scenes/geodesic.h"

#include <cmath>

#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Scene;

namespace {

using Face = std::array<std::uint32_t, 3>;

// Counter-clockwise seen from outside.
constexpr std::array<Face, 20> kFaces = {
    {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
     {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
     {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};

std::array<Direction, 12> corners() {
    const double g = (1.0 + std::sqrt(5.0)) / 2.0;
    std::array<Direction, 12> points = {{{-1, g, 0},
                                         {1, g, 0},
                                         {-1, -g, 0},
                                         {1, -g, 0},
                                         {0, -1, g},
                                         {0, 1, g},
                                         {0, -1, -g},
                                         {0, 1, -g},
                                         {g, 0, -1},
                                         {g, 0, 1},
                                         {-g, 0, -1},
                                         {-g, 0, 1}}};
    const double norm = std::sqrt(1.0 + g * g);
    for (auto& point : points) {
        for (double& coordinate : point) coordinate /= norm;
    }
    return points;
}

/// Index arithmetic of the grid: 12 corners, then 30 edges, then 20 face interiors.
class Grid {
 public:
    explicit Grid(std::uint32_t frequency) : n_(frequency) {
        std::uint32_t edges = 0;
        for (auto& row : edge_of_) row.fill(reference::kNone);
        for (const auto& face : kFaces) {
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t low = std::min(face[k], face[(k + 1) % 3]);
                const std::uint32_t high = std::max(face[k], face[(k + 1) % 3]);
                if (edge_of_[low][high] != reference::kNone) continue;
                edge_of_[low][high] = edges;
                edge_ends_[edges++] = {low, high};
            }
        }
    }

    /// Vertex at i steps towards the face's second corner and j towards its third.
    std::uint32_t vertex(std::uint32_t face, std::uint32_t i, std::uint32_t j) const {
        const auto& [a, b, c] = kFaces[face];
        if (i == n_) return b;
        if (j == n_) return c;
        if (i == 0 && j == 0) return a;
        if (j == 0) return on_edge(a, b, i);
        if (i == 0) return on_edge(a, c, j);
        if (i + j == n_) return on_edge(b, c, j);
        return 12 + 30 * (n_ - 1) + face * ((n_ - 1) * (n_ - 2) / 2) + (i - 1) * (n_ - 1) -
               (i - 1) * i / 2 + j - 1;
    }

    const std::array<std::uint32_t, 2>& edge_ends(std::uint32_t edge) const {
        return edge_ends_[edge];
    }

 private:
    std::uint32_t on_edge(std::uint32_t from, std::uint32_t to, std::uint32_t step) const {
        if (from > to) {
            std::swap(from, to);
            step = n_ - step;
        }
        return 12 + edge_of_[from][to] * (n_ - 1) + step - 1;
    }

    std::uint32_t n_;
    std::array<std::array<std::uint32_t, 12>, 12> edge_of_{};
    std::array<std::array<std::uint32_t, 2>, 30> edge_ends_{};
};

Direction blend(const Direction& a, double wa, const Direction& b, double wb, const Direction& c,
                double wc) {
    Direction point{};
    double square = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
        point[k] = a[k] * wa + b[k] * wb + c[k] * wc;
        square += point[k] * point[k];
    }
    const double norm = std::sqrt(square);
    for (double& coordinate : point) coordinate /= norm;
    return point;
}

}  // namespace

std::uint32_t geodesic_frequency(double triangles) {
    auto frequency = static_cast<std::uint32_t>(std::sqrt(std::max(triangles, 20.0) / 20.0));
    while (static_cast<double>(geodesic_triangles(frequency)) < triangles) ++frequency;
    return frequency;
}

void add_geodesic(Scene& scene, std::uint32_t frequency, std::uint32_t material,
                  const std::function<Vec3(const Direction&)>& position_of) {
    const std::uint32_t n = frequency;
    const auto base = static_cast<std::uint32_t>(scene.vertices.size());
    scene.vertices.reserve(base + geodesic_vertices(n));
    scene.normals.reserve(base + geodesic_vertices(n));
    scene.triangles.reserve(scene.triangles.size() + geodesic_triangles(n));
    scene.material_of.reserve(scene.material_of.size() + geodesic_triangles(n));

    // The order in which Grid counts: corners, edges, interiors.
    const Grid grid(n);
    const auto corner = corners();
    for (const auto& point : corner) add_vertex(scene, position_of(point));
    for (std::uint32_t edge = 0; edge < 30; ++edge) {
        const auto& [a, b] = grid.edge_ends(edge);
        for (std::uint32_t i = 1; i < n; ++i) {
            add_vertex(scene, position_of(blend(corner[a], n - i, corner[b], i, corner[b], 0.0)));
        }
    }
    for (const auto& [a, b, c] : kFaces) {
        for (std::uint32_t i = 1; i + 1 < n; ++i) {
            for (std::uint32_t j = 1; i + j < n; ++j) {
                add_vertex(scene,
                           position_of(blend(corner[a], n - i - j, corner[b], i, corner[c], j)));
            }
        }
    }
    for (std::uint32_t face = 0; face < kFaces.size(); ++face) {
        for (std::uint32_t i = 0; i < n; ++i) {
            for (std::uint32_t j = 0; i + j < n; ++j) {
                const std::uint32_t p = base + grid.vertex(face, i, j);
                const std::uint32_t q = base + grid.vertex(face, i + 1, j);
                const std::uint32_t r = base + grid.vertex(face, i, j + 1);
                add_triangle(scene, p, q, r, material);
                if (i + j + 1 == n) continue;
                add_triangle(scene, q, base + grid.vertex(face, i + 1, j + 1), r, material);
            }
        }
    }
}

void add_sphere(Scene& scene, const Vec3& centre, float radius, std::uint32_t frequency,
                std::uint32_t material) {
    const std::size_t first = scene.vertices.size();
    std::vector<Vec3> normals;
    normals.reserve(geodesic_vertices(frequency));
    add_geodesic(scene, frequency, material, [&](const Direction& d) {
        const Vec3 normal(static_cast<float>(d[0]), static_cast<float>(d[1]),
                          static_cast<float>(d[2]));
        normals.push_back(normal);
        return centre + normal * radius;
    });
    for (std::size_t i = 0; i < normals.size(); ++i) scene.normals[first + i] = normals[i];
}

}  // namespace scotty::scenes
