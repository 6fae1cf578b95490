/// A transform in the file gives what the same transform of the data by hand gives.
#include <random>

#include "scenes/affine.h"
#include "tests/catch.h"
#include "tests/scenes/gltf_text.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using nlohmann::json;
using reference::Scene;
using reference::Vec3;
using scenes::Affine;
using scenes::Point;
using tests::GltfText;
using tests::TemporaryFiles;

namespace {

struct Trs {
    Point move;
    std::array<double, 4> turn;  ///< x y z w
    Point scale;
};

json node_of(const Trs& trs) {
    return {{"translation", trs.move}, {"rotation", trs.turn}, {"scale", trs.scale}};
}

/// v turned by a unit quaternion: v + 2 q x (q x v + w v).
Point turned(const std::array<double, 4>& q, const Point& v) {
    const auto cross = [](const Point& a, const Point& b) -> Point {
        return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    const Point axis = {q[0], q[1], q[2]};
    Point inner = cross(axis, v);
    for (std::size_t k = 0; k < 3; ++k) inner[k] += q[3] * v[k];
    Point out = cross(axis, inner);
    for (std::size_t k = 0; k < 3; ++k) out[k] = v[k] + 2 * out[k];
    return out;
}

Point applied(const Trs& trs, Point p) {
    for (std::size_t k = 0; k < 3; ++k) p[k] *= trs.scale[k];
    p = turned(trs.turn, p);
    for (std::size_t k = 0; k < 3; ++k) p[k] += trs.move[k];
    return p;
}

Point random_point(std::mt19937& random, double low, double high) {
    std::uniform_real_distribution<double> uniform(low, high);
    return {uniform(random), uniform(random), uniform(random)};
}

Trs random_trs(std::mt19937& random, bool mirrors) {
    const Point axis = scenes::unit(random_point(random, -1.0, 1.0));
    const double half = random_point(random, 0.0, 3.0)[0];
    Trs out{random_point(random, -5.0, 5.0),
            {axis[0] * std::sin(half), axis[1] * std::sin(half), axis[2] * std::sin(half),
             std::cos(half)},
            random_point(random, 0.2, 3.0)};
    if (mirrors) out.scale[1] *= -1.0;
    return out;
}

constexpr std::size_t kTriangles = 20;

/// Random triangles, whose normals are those of their windings.
GltfText triangles_with_normals(const std::vector<Point>& points, const json& node) {
    std::vector<float> positions;
    std::vector<float> normals;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Vec3 a = scenes::rounded(points[i / 3 * 3]);
        const Vec3 b = scenes::rounded(points[i / 3 * 3 + 1]);
        const Vec3 c = scenes::rounded(points[i / 3 * 3 + 2]);
        const Vec3 n = reference::normalize_or(reference::cross(b - a, c - a), Vec3(0.0f));
        for (int k = 0; k < 3; ++k) normals.push_back(n[k]);
        for (const double x : points[i]) positions.push_back(static_cast<float>(x));
    }
    GltfText text;
    const std::size_t p = text.accessor("VEC3", positions);
    const std::size_t n = text.accessor("VEC3", normals);
    json entry = node;
    entry["mesh"] = text.mesh({{"attributes", {{"POSITION", p}, {"NORMAL", n}}}});
    text.node(entry);
    return text;
}

void check_same_triangles(const Scene& scene, const Scene& expected) {
    REQUIRE(scene.vertices.size() == expected.vertices.size());
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        CHECK(reference::dot(tests::front_of(scene, i), tests::front_of(expected, i)) ==
              Approx(1.0).margin(1e-4));
    }
    for (std::size_t i = 0; i < scene.vertices.size(); ++i) {
        CHECK(reference::length(scene.vertices[i] - expected.vertices[i]) < 1e-4f);
        CHECK(reference::dot(scene.normals[i], expected.normals[i]) == Approx(1.0).margin(1e-3));
    }
}

}  // namespace

TEST_CASE("gltf: nodes below each other, turned, stretched and mirrored, place what they hold",
          "[scenes][gltf]") {
    std::mt19937 random(7);
    const TemporaryFiles files;
    for (int round = 0; round < 16; ++round) {
        const bool outer_mirrors = (round & 1) != 0;
        const bool inner_mirrors = (round & 2) != 0;
        const Trs outer = random_trs(random, outer_mirrors);
        const Trs inner = random_trs(random, inner_mirrors);
        std::vector<Point> points;
        std::vector<Point> placed;
        for (std::size_t i = 0; i < kTriangles * 3; ++i) {
            points.push_back(random_point(random, -2.0, 2.0));
            placed.push_back(applied(outer, applied(inner, points.back())));
        }
        // By hand: a mirror turns the corners' order round, and fronts stay fronts.
        GltfText text = triangles_with_normals(points, node_of(inner));
        text.root["scenes"][0]["nodes"] = json::array();
        json parent = node_of(outer);
        parent["children"] = {0};
        text.node(parent);
        const Scene scene = files.load("a.gltf", text.gltf());
        if (outer_mirrors != inner_mirrors) {
            for (std::size_t i = 0; i < placed.size(); i += 3)
                std::swap(placed[i + 1], placed[i + 2]);
        }
        Scene expected =
            files.load("b.gltf", triangles_with_normals(placed, json::object()).gltf());
        if (outer_mirrors != inner_mirrors) {
            for (auto& triangle : expected.triangles) std::swap(triangle[1], triangle[2]);
            for (std::size_t i = 0; i < placed.size(); i += 3) {
                std::swap(expected.vertices[i + 1], expected.vertices[i + 2]);
            }
        }
        check_same_triangles(scene, expected);
    }
}

TEST_CASE("gltf: a matrix places as its parts do", "[scenes][gltf]") {
    std::mt19937 random(11);
    const TemporaryFiles files;
    for (const bool mirrors : {false, true}) {
        const Trs trs = random_trs(random, mirrors);
        json matrix = json::array();
        for (std::size_t c = 0; c < 4; ++c) {
            Point axis{};
            if (c < 3) axis[c] = 1.0;
            const Point at = applied(trs, axis);
            for (std::size_t r = 0; r < 3; ++r) {
                matrix.push_back(c < 3 ? at[r] - trs.move[r] : trs.move[r]);
            }
            matrix.push_back(c < 3 ? 0 : 1);
        }
        std::vector<Point> points;
        for (std::size_t i = 0; i < kTriangles * 3; ++i) {
            points.push_back(random_point(random, -2.0, 2.0));
        }
        check_same_triangles(
            files.load("a.gltf", triangles_with_normals(points, {{"matrix", matrix}}).gltf()),
            files.load("b.gltf", triangles_with_normals(points, node_of(trs)).gltf()));
    }
}

TEST_CASE("gltf: a matrix that is rounded is read, a perspective is an error", "[scenes][gltf]") {
    const auto with_row = [](const std::array<double, 4>& row) {
        const json matrix = {1, 0, 0, row[0], 0, 1, 0, row[1], 0, 0, 1, row[2], 2, 0, 0, row[3]};
        return tests::load_gltf(tests::square_gltf({{"matrix", matrix}}));
    };
    CHECK(with_row({0, 0, 0, 1}).vertices[0] == Vec3(1, -1, 0));
    CHECK(with_row({1e-9, -1e-10, 0, 1.0000002}).vertices[0] == Vec3(1, -1, 0));
    CHECK(with_row({0, 0, 0, 2}).vertices[0] == Vec3(0.5f, -0.5f, 0));
    CHECK(with_row({0, 0, 0, 0.99999994}).warnings == with_row({0, 0, 0, 1}).warnings);
    CHECK_THROWS_WITH(with_row({0.5, 0, 0, 1}), ContainsSubstring("nodes[0]") &&
                                                    ContainsSubstring("last row") &&
                                                    ContainsSubstring("0.5 0 0 1"));
    CHECK_THROWS_WITH(with_row({0, 0, 0, 0}),
                      ContainsSubstring("nodes[0]") && ContainsSubstring("last row"));
}

TEST_CASE("gltf: an identity keeps positions to the bit", "[scenes][gltf]") {
    GltfText text = tests::square_gltf();
    const float odd = 0.1f + 1e-8f;
    std::memcpy(text.bytes.data(), &odd, sizeof odd);
    CHECK(TemporaryFiles().load("a.gltf", text.gltf()).vertices[0].x == odd);
}
