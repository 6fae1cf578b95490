#include <random>

#include "scenes/triangulate_polygon.h"
#include "tests/catch.h"

using namespace scotty;
using scenes::Point;
using scenes::triangulate_polygon;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;
using Flat = std::array<double, 2>;

namespace {

double turn(const Flat& a, const Flat& b, const Flat& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Puts a flat polygon into space: the plane is slanted, and faces towards +z or -z.
std::vector<Point> in_space(const std::vector<Flat>& polygon, std::size_t axis = 2) {
    std::vector<Point> corners;
    for (const Flat& p : polygon) {
        Point corner{};
        corner[(axis + 1) % 3] = p[0];
        corner[(axis + 2) % 3] = p[1];
        corner[axis] = 0.25 * p[0] - 0.5 * p[1] + 3.0;
        corners.push_back(corner);
    }
    return corners;
}

double signed_area(const std::vector<Flat>& ring) {
    double area = 0.0;
    for (std::size_t i = 2; i < ring.size(); ++i) {
        area += 0.5 * turn(ring[0], ring[i - 1], ring[i]);
    }
    return area;
}

bool even_odd(const std::vector<Flat>& ring, const Flat& p) {
    bool inside = false;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Flat& a = ring[i];
        const Flat& b = ring[(i + 1) % ring.size()];
        if ((a[1] > p[1]) != (b[1] > p[1])) {
            inside ^= p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
        }
    }
    return inside;
}

/// Checks triangles against the rings they were made from: the number, the area (with no triangle
/// turned over) and, for random rays, whether each is hit once inside and never outside.
void check_cover(const std::vector<std::vector<Flat>>& rings, const Triangles& triangles) {
    std::vector<Flat> corners;
    double area = 0.0;
    for (std::size_t r = 0; r < rings.size(); ++r) {
        corners.insert(corners.end(), rings[r].begin(), rings[r].end());
        area += r == 0 ? std::abs(signed_area(rings[r])) : -std::abs(signed_area(rings[r]));
    }
    const double side = signed_area(rings[0]) < 0.0 ? -1.0 : 1.0;
    CHECK(triangles.size() == corners.size() + 2 * rings.size() - 4);
    double covered = 0.0;
    for (const auto& [a, b, c] : triangles) {
        const double part = side * 0.5 * turn(corners[a], corners[b], corners[c]);
        CHECK(part >= 0.0);
        covered += part;
    }
    CHECK(covered == Approx(area).epsilon(1e-12));
    std::mt19937 random(7);
    std::uniform_real_distribution<double> place(-4.5, 4.5);
    int wrong = 0;
    for (int ray = 0; ray < 2000; ++ray) {
        const Flat p{place(random), place(random)};
        int hits = 0;
        for (const auto& [a, b, c] : triangles) {
            hits += even_odd({corners[a], corners[b], corners[c]}, p) ? 1 : 0;
        }
        bool inside = false;
        for (const auto& ring : rings) inside ^= even_odd(ring, p);
        wrong += hits != (inside ? 1 : 0) ? 1 : 0;
    }
    CHECK(wrong == 0);
}

/// All starting corners, both windings, all three dominant axes.
void check_all_ways(const std::vector<Flat>& polygon) {
    for (std::size_t start = 0; start < polygon.size(); ++start) {
        for (const bool reversed : {false, true}) {
            std::vector<Flat> turned = polygon;
            std::rotate(turned.begin(), turned.begin() + static_cast<std::ptrdiff_t>(start),
                        turned.end());
            if (reversed) std::reverse(turned.begin(), turned.end());
            for (std::size_t axis = 0; axis < 3; ++axis) {
                INFO("from corner " << start << ", reversed " << reversed << ", axis " << axis);
                Triangles triangles;
                CHECK(triangulate_polygon(in_space(turned, axis), triangles));
                check_cover({turned}, triangles);
            }
        }
    }
}

/// A polygon around the origin whose corners lie at random distances.
std::vector<Flat> star(std::size_t corners, unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> radius(0.2, 4.0);
    std::vector<Flat> polygon;
    for (std::size_t i = 0; i < corners; ++i) {
        const double angle =
            6.283185307179586 * static_cast<double>(i) / static_cast<double>(corners);
        const double r = radius(random);
        polygon.push_back({r * std::cos(angle), r * std::sin(angle)});
    }
    return polygon;
}

const std::vector<Flat> kC = {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {4, 3}, {4, 4}, {0, 4}};

}  // namespace

TEST_CASE("polygon: a convex one is a fan around its first corner", "[scenes][polygon]") {
    Triangles triangles;
    CHECK(triangulate_polygon(in_space({{0, 0}, {1, 0}, {2, 1}, {1, 2}, {0, 1}}), triangles));
    CHECK(triangles == Triangles{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}});
    triangles.clear();
    INFO("collinear corners and a bent quadrilateral are no reason to leave the fan");
    CHECK(triangulate_polygon(in_space({{0, 0}, {1, 0}, {2, 0}, {2, 2}}), triangles));
    CHECK(triangulate_polygon({{{0, 0, 0}, {1, 0, 0.3}, {1, 1, 0}, {0, 1, 0.3}}}, triangles));
    CHECK(triangles == Triangles{{0, 1, 2}, {0, 2, 3}, {0, 1, 2}, {0, 2, 3}});
}

TEST_CASE("polygon: concave ones are covered once, from any corner and side", "[scenes][polygon]") {
    SECTION("C") { check_all_ways(kC); }
    SECTION("arrow of four corners") { check_all_ways({{0, 0}, {3, -2}, {1, 0}, {3, 2}}); }
    SECTION("arrow with a corner in the middle of an edge") {
        check_all_ways({{0, 0}, {1.5, -1}, {3, -2}, {1, 0}, {3, 2}});
    }
    SECTION("plus") {
        check_all_ways({{-1, -3},
                        {1, -3},
                        {1, -1},
                        {3, -1},
                        {3, 1},
                        {1, 1},
                        {1, 3},
                        {-1, 3},
                        {-1, 1},
                        {-3, 1},
                        {-3, -1},
                        {-1, -1}});
    }
    SECTION("spiral") {
        check_all_ways(
            {{0, 0}, {4, 0}, {4, 4}, {1, 4}, {1, 2}, {2, 2}, {2, 3}, {3, 3}, {3, 1}, {0, 1}});
    }
    SECTION("comb with straight corners along its back") {
        check_all_ways({{0, 0},
                        {1, 0},
                        {2, 0},
                        {3, 0},
                        {4, 0},
                        {4, 2},
                        {3, 1},
                        {3, 2},
                        {2, 1},
                        {2, 2},
                        {1, 1},
                        {1, 2},
                        {0, 1}});
    }
    SECTION("a square hole joined to the outline by an edge there and back") {
        check_all_ways({{-3, -3},
                        {3, -3},
                        {3, 3},
                        {-3, 3},
                        {-3, -3},
                        {-1, -1},
                        {-1, 1},
                        {1, 1},
                        {1, -1},
                        {-1, -1}});
    }
}

TEST_CASE("polygon: random stars are covered once", "[scenes][polygon]") {
    for (unsigned seed = 0; seed < 60; ++seed) {
        const std::size_t corners = 4 + seed % 37;
        INFO("seed " << seed << ", " << corners << " corners");
        const std::vector<Flat> polygon = star(corners, seed);
        Triangles triangles;
        CHECK(triangulate_polygon(in_space(polygon, seed % 3), triangles));
        check_cover({polygon}, triangles);
    }
}

TEST_CASE("polygon: one that is not quite flat keeps all of its corners", "[scenes][polygon]") {
    std::vector<Point> corners = in_space(kC);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> bend(-0.05, 0.05);
    for (Point& corner : corners) corner[2] += bend(random);
    Triangles triangles;
    CHECK(triangulate_polygon(corners, triangles));
    check_cover({kC}, triangles);
}

TEST_CASE("polygon: holes are cut out, however they are wound", "[scenes][polygon]") {
    const std::vector<Flat> outline = {{-4, -4}, {4, -4}, {4, 4}, {0, 2}, {-4, 4}};
    const std::vector<Flat> square = {{-3, -3}, {-1, -3}, {-1, -1}, {-3, -1}};
    const std::vector<Flat> triangle = {{1, -1}, {2, 1}, {0, 1}};
    for (const bool reversed : {false, true}) {
        std::vector<std::vector<Flat>> rings = {
            outline, square, triangle, {{1, -3}, {2, -3}, {2, -2}}};
        if (reversed) {
            for (auto& ring : rings) std::reverse(ring.begin(), ring.end());
            std::reverse(rings[2].begin(), rings[2].end());
        }
        std::vector<Flat> corners;
        std::vector<std::uint32_t> sizes;
        for (const auto& ring : rings) {
            corners.insert(corners.end(), ring.begin(), ring.end());
            sizes.push_back(static_cast<std::uint32_t>(ring.size()));
        }
        Triangles triangles;
        CHECK(triangulate_polygon(in_space(corners), sizes, triangles));
        check_cover(rings, triangles);
    }
    Triangles triangles;
    const std::vector<std::uint32_t> sizes = {4, 3};
    INFO("a hole outside the outline is no hole");
    CHECK_FALSE(triangulate_polygon(
        in_space({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {5, 5}, {6, 5}, {5, 6}}), sizes, triangles));
}

TEST_CASE("polygon: one that crosses itself is told", "[scenes][polygon]") {
    Triangles triangles;
    CHECK_FALSE(triangulate_polygon(in_space({{0, 0}, {2, 0}, {0, 3}, {2, 3}}), triangles));
    CHECK(triangles.size() == 2);
    std::vector<Flat> pentagram;
    for (const int k : {0, 2, 4, 1, 3}) {
        pentagram.push_back({std::cos(1.2566370614 * k), std::sin(1.2566370614 * k)});
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        Triangles bow;
        CHECK_FALSE(triangulate_polygon(in_space({{0, 0}, {2, 0}, {0, 3}, {2, 3}}, axis), bow));
    }
    Triangles bow;
    CHECK_FALSE(triangulate_polygon({{{0, 0, 0}, {2, 0, 0}, {0, 3, 0}, {2, 3, 0}}}, bow));
    CHECK_FALSE(triangulate_polygon(in_space(pentagram), triangles));
    CHECK(triangles.size() == 5);
}

TEST_CASE("polygon: degenerate ones give triangles without area, or none", "[scenes][polygon]") {
    Triangles triangles;
    CHECK(triangulate_polygon({}, triangles));
    CHECK(triangulate_polygon(in_space({{0, 0}, {1, 0}}), triangles));
    CHECK(triangles.empty());
    CHECK(triangulate_polygon(std::vector<Point>(6, Point{1, 2, 3}), triangles));
    CHECK(triangles.size() == 4);
    CHECK(triangulate_polygon(in_space({{0, 0}, {1, 0}, {2, 0}, {3, 0}}), triangles));
    CHECK(triangles.size() == 6);
    const double huge = 1e300;
    triangulate_polygon(
        {{{0, 0, 0}, {huge, -huge, 0}, {1, 0, 0}, {huge, huge, huge}, {-huge, 0, 1}}}, triangles);
    CHECK(triangles.size() == 9);
}

TEST_CASE("polygon: twenty thousand corners are no matter of patience", "[scenes][polygon]") {
    std::vector<Flat> comb;
    constexpr int kTeeth = 10'000;
    for (int i = 0; i < kTeeth; ++i) {
        comb.push_back({static_cast<double>(i), 1.0});
        comb.push_back({i + 0.5, 2.0});
    }
    comb.push_back({kTeeth, 0.0});
    comb.push_back({0.0, 0.0});
    Triangles triangles;
    CHECK(triangulate_polygon(in_space(comb), triangles));
    double covered = 0.0;
    for (const auto& [a, b, c] : triangles) covered -= 0.5 * turn(comb[a], comb[b], comb[c]);
    CHECK(covered == Approx(-signed_area(comb)).epsilon(1e-9));
}
