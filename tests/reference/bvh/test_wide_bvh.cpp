
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "reference/bvh/binary_bvh.h"
#include "reference/bvh/reinsertion.h"
#include "reference/bvh/wide_bvh_compaction.h"
#include "reference/contract/wide_bvh.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;
using Catch::Matchers::ContainsSubstring;

namespace {

BvhParameters parameters(int width, int leaf_size, std::size_t threads = 0) {
    BvhParameters out;
    out.width = width;
    out.max_leaf_size = leaf_size;
    out.threads = threads;
    return out;
}

std::uint32_t largest_leaf(const WideBvh& bvh) {
    std::uint32_t largest = 0;
    for (const Leaf& leaf : bvh.leaves) largest = std::max(largest, leaf.count);
    return largest;
}

/// Builds with every width and two leaf sizes; all must be valid and keep the leaf size.
void check_all_shapes(const Scene& scene) {
    for (const int width : {2, 4, 8, 16}) {
        for (const int leaf_size : {1, 4, 40}) {
            INFO(scene.name << ", width " << width << ", leaf size " << leaf_size);
            const WideBvh bvh = build_wide_bvh(scene, parameters(width, leaf_size));
            CHECK(bvh.width == width);
            CHECK(validate(bvh, scene) == std::vector<std::string>{});
            CHECK(largest_leaf(bvh) <= static_cast<std::uint32_t>(leaf_size));
        }
    }
}

}  // namespace

TEST_CASE("wide bvh: every width and leaf size gives a valid tree", "[reference][bvh]") {
    check_all_shapes(soup(1000, 0.1f, 1));
    check_all_shapes(icosphere(3));
}

TEST_CASE("wide bvh: one triangle is a root with one leaf", "[reference][bvh]") {
    const Scene scene = triangle_scene({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    for (const int width : {2, 4, 8, 16}) {
        const WideBvh bvh = build_wide_bvh(scene, parameters(width, 4));
        CHECK(bvh.node_count() == 2);
        CHECK(bvh.inner_count() == 1);
        CHECK(bvh.level_count() == 2);
        CHECK_FALSE(is_leaf(bvh.node_refs[0]));
        CHECK(validate(bvh, scene).empty());
    }
}

TEST_CASE("wide bvh: a thousand identical triangles are split by index", "[reference][bvh]") {
    Scene scene = triangle_scene({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    scene.name = "coincident";
    while (scene.triangles.size() < 1000) scene.triangles.push_back(scene.triangles.front());
    check_all_shapes(scene);
}

TEST_CASE("wide bvh: collinear centroids give a valid tree", "[reference][bvh]") {
    Scene scene;
    scene.name = "collinear";
    for (int i = 0; i < 500; ++i) {
        const auto x = static_cast<float>(i);
        add_triangle(scene, {x, 0, 0}, {x + 1, 0, 0}, {x, 1, 0});
    }
    check_all_shapes(scene);
}

TEST_CASE("wide bvh: zero-area triangles are kept", "[reference][bvh]") {
    Scene scene;
    scene.name = "zero area";
    for (int i = 0; i < 100; ++i) {
        const auto x = static_cast<float>(i % 10);
        add_triangle(scene, {x, 0, 0}, {x, 0, 0}, {x, 0, 0});
        add_triangle(scene, {x, 1, 0}, {x + 1, 1, 0}, {x + 2, 1, 0});
    }
    check_all_shapes(scene);
}

TEST_CASE("wide bvh: huge and tiny coordinates give a valid tree", "[reference][bvh]") {
    for (const float scale : {1.0e12f, 1.0e-30f}) {
        Scene scene = soup(300, 0.1f, 2);
        scene.name = "scaled";
        for (Vec3& vertex : scene.vertices) vertex *= 0.9f * scale;
        check_all_shapes(scene);
    }
}

TEST_CASE("wide bvh: triangles at every scale down to denormals make a deep, valid tree",
          "[reference][bvh]") {
    Scene scene;
    scene.name = "nested";
    for (int octave = 30; octave > -140; --octave) {
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 at(0.0f);
            at[axis] = std::ldexp(1.0f, octave);
            add_triangle(scene, at, 1.5f * at, 1.25f * at);
        }
    }
    check_all_shapes(scene);
    CHECK(build_wide_bvh(scene, parameters(2, 1)).level_count() > 20);
}

TEST_CASE("wide bvh: a level may have more than 6000 nodes", "[reference][bvh]") {
    const Scene scene = height_field(200);
    const WideBvh bvh = build_wide_bvh(scene, parameters(8, 1));
    std::uint32_t widest = 0;
    for (std::uint32_t level = 0; level < bvh.level_count(); ++level) {
        widest = std::max(widest, bvh.level_begins[level + 1] - bvh.level_begins[level]);
    }
    CHECK(widest > 6000);
    CHECK(validate(bvh, scene).empty());
}

TEST_CASE("wide bvh: is the same on every run and for every thread count", "[reference][bvh]") {
    const Scene scene = height_field(120);
    // More threads than this machine may have: TBB would keep to its cores otherwise.
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 4);
    const std::uint64_t expected = fingerprint(build_wide_bvh(scene, parameters(8, 4, 1)));
    for (const std::size_t threads : {1, 2, 4, 0}) {
        for (int run = 0; run < 2; ++run) {
            CHECK(fingerprint(build_wide_bvh(scene, parameters(8, 4, threads))) == expected);
        }
    }
}

TEST_CASE("wide bvh: the fingerprint sees a moved vertex and another width", "[reference][bvh]") {
    Scene scene = soup(100, 0.1f, 3);
    const std::uint64_t original = fingerprint(build_wide_bvh(scene, parameters(8, 4)));
    CHECK(fingerprint(build_wide_bvh(scene, parameters(4, 4))) != original);
    scene.vertices[7].x = std::nextafter(scene.vertices[7].x, 10.0f);
    CHECK(fingerprint(build_wide_bvh(scene, parameters(8, 4))) != original);
}

TEST_CASE("wide bvh: triangles of a leaf are in ascending order", "[reference][bvh]") {
    const WideBvh bvh = build_wide_bvh(soup(500, 0.2f, 4), parameters(4, 8));
    for (const Leaf& leaf : bvh.leaves) {
        for (std::uint32_t k = leaf.first + 1; k < leaf.first + leaf.count; ++k) {
            CHECK(bvh.triangles[k - 1].primitive < bvh.triangles[k].primitive);
        }
    }
}

TEST_CASE("wide bvh: missing children come after the others", "[reference][bvh]") {
    const WideBvh bvh = build_wide_bvh(soup(500, 0.2f, 4), parameters(8, 4));
    for (const WideNode<8>& node : std::get<std::vector<WideNode<8>>>(bvh.inner)) {
        for (int i = 1; i < 8; ++i) {
            if (node.child[i] != kNone) CHECK(node.child[i] == node.child[i - 1] + 1);
        }
    }
}

TEST_CASE("wide bvh: memory is in proportion to triangles", "[reference][bvh]") {
    const std::size_t small = memory_bytes(build_wide_bvh(height_field(30), parameters(8, 4)));
    const std::size_t large = memory_bytes(build_wide_bvh(height_field(60), parameters(8, 4)));
    CHECK(large > 3 * small);
    CHECK(large < 5 * small);
}

TEST_CASE("wide bvh: parameters out of range are named", "[reference][bvh]") {
    const Scene scene = soup(10, 0.1f, 5);
    CHECK_THROWS_WITH(build_wide_bvh(scene, parameters(3, 4)),
                      ContainsSubstring("BVH width") && ContainsSubstring("found 3"));
    CHECK_THROWS_WITH(build_wide_bvh(scene, parameters(8, 0)),
                      ContainsSubstring("leaf size") && ContainsSubstring("found 0"));
    CHECK_THROWS_WITH(build_wide_bvh(scene, parameters(8, 1025)), ContainsSubstring("found 1025"));
    Scene empty;
    empty.name = "nothing.obj";
    CHECK_THROWS_WITH(build_wide_bvh(empty, parameters(8, 4)),
                      ContainsSubstring("nothing.obj") && ContainsSubstring("found none"));
}

TEST_CASE("median bvh: is valid depth-first order with logarithmic depth", "[reference][bvh]") {
    const Scene scene = soup(1000, 0.1f, 6);
    const BinaryBvh bvh = build_median_bvh(scene);
    std::vector<std::uint32_t> depth(bvh.nodes.size(), 1);
    std::vector<int> seen(scene.triangles.size());
    for (std::size_t i = 0; i < bvh.nodes.size(); ++i) {
        const BinaryNode& node = bvh.nodes[i];
        CHECK(depth[i] <= 11);
        if (node.right == kNone) {
            CHECK(node.count == 1);
            for (std::uint32_t k = 0; k < node.count; ++k) ++seen[bvh.order[node.first + k]];
        } else {
            depth[i + 1] = depth[i] + 1;
            depth[node.right] = depth[i] + 1;
            CHECK(node.count == bvh.nodes[i + 1].count + bvh.nodes[node.right].count);
            CHECK(node.low == min_of(bvh.nodes[i + 1].low, bvh.nodes[node.right].low));
        }
    }
    for (const int times : seen) CHECK(times == 1);
}

namespace {

/// What a ray that enters the root is expected to pay, from the finished tree.
template <int Width>
double cost_of(const WideBvh& bvh) {
    const auto area = [](const Vec3& low, const Vec3& high) {
        const Vec3 size = high - low;
        return double{size.x} * size.y + double{size.y} * size.z + double{size.z} * size.x;
    };
    double cost = 0.0;
    double root_area = 0.0;
    for (const WideNode<Width>& node : std::get<std::vector<WideNode<Width>>>(bvh.inner)) {
        const double own = area({node.low[0], node.low[1], node.low[2]},
                                {node.high[0], node.high[1], node.high[2]});
        if (root_area == 0.0) root_area = own;
        cost += kNodeCost * own;
        for (int i = 0; i < Width; ++i) {
            if (node.child[i] == kNone || !is_leaf(bvh.node_refs[node.child[i]])) continue;
            const Leaf& leaf = bvh.leaves[ref_index(bvh.node_refs[node.child[i]])];
            cost += (kLeafCost + kTriangleCost * leaf.count) *
                    area({node.low_x[i], node.low_y[i], node.low_z[i]},
                         {node.high_x[i], node.high_y[i], node.high_z[i]});
        }
    }
    return cost / root_area;
}

/// The least cost of a subtree as at most `roots` nodes, by trying everything.
double least_cost(const BinaryBvh& bvh, std::uint32_t id, int width, int leaf_size, int roots) {
    const BinaryNode& node = bvh.nodes[id];
    const auto area = [](const BinaryNode& n) {
        const Vec3 size = n.high - n.low;
        return double{size.x} * size.y + double{size.y} * size.z + double{size.z} * size.x;
    };
    const double relative = area(node) / area(bvh.nodes.front());
    const auto split = [&](int into) {
        double best = std::numeric_limits<double>::infinity();
        for (int k = 1; k < into; ++k) {
            best = std::min(best, least_cost(bvh, id + 1, width, leaf_size, k) +
                                      least_cost(bvh, node.right, width, leaf_size, into - k));
        }
        return best;
    };
    double best = std::numeric_limits<double>::infinity();
    if (node.count <= static_cast<std::uint32_t>(leaf_size)) {
        best = relative * (kLeafCost + kTriangleCost * node.count);
    }
    if (node.right == kNone) return best;
    best = std::min(best, relative * kNodeCost + split(width));
    for (int into = 2; into <= roots; ++into) best = std::min(best, split(into));
    return best;
}

}  // namespace

TEST_CASE("compaction: no other choice of nodes and leaves is cheaper", "[reference][bvh]") {
    for (const int width : {2, 4}) {
        for (const int leaf_size : {1, 3}) {
            const BinaryBvh binary = build_binary_bvh(soup(10, 0.4f, 8));
            CHECK(Compaction(binary, width, leaf_size).cost() ==
                  Approx(least_cost(binary, 0, width, leaf_size, 1)));
        }
    }
}

TEST_CASE("compaction: the tree that is written has the cost that was found", "[reference][bvh]") {
    const Scene scene = soup(2000, 0.1f, 9);
    BinaryBvh binary = build_binary_bvh(scene);
    optimise_by_reinsertion(binary);
    CHECK(cost_of<2>(build_wide_bvh(scene, parameters(2, 4))) ==
          Approx(Compaction(binary, 2, 4).cost()));
    CHECK(cost_of<8>(build_wide_bvh(scene, parameters(8, 4))) ==
          Approx(Compaction(binary, 8, 4).cost()));
    CHECK(cost_of<16>(build_wide_bvh(scene, parameters(16, 64))) ==
          Approx(Compaction(binary, 16, 64).cost()));
}

TEST_CASE("compaction: width 2 with single triangles is the binary tree", "[reference][bvh]") {
    const Scene scene = soup(300, 0.1f, 10);
    const WideBvh bvh = build_wide_bvh(scene, parameters(2, 1));
    CHECK(bvh.inner_count() == 299);
    CHECK(bvh.leaves.size() == 300);
}

TEST_CASE("compaction: triangles without any area fill leaves and nodes", "[reference][bvh]") {
    Scene scene;
    for (int i = 0; i < 512; ++i) add_triangle(scene, Vec3(1.0f), Vec3(1.0f), Vec3(1.0f));
    const WideBvh bvh = build_wide_bvh(scene, parameters(8, 4));
    CHECK(bvh.leaves.size() == 128);
    CHECK(bvh.inner_count() < 30);
}

namespace {

/// Builds, breaks one thing, and expects the sentence that names it.
template <typename Tamper>
void expect_violation(const std::string& sentence, Tamper tamper) {
    const Scene scene = soup(200, 0.2f, 7);
    WideBvh bvh = build_wide_bvh(scene, parameters(4, 2));
    REQUIRE(validate(bvh, scene).empty());
    tamper(bvh, std::get<std::vector<WideNode<4>>>(bvh.inner));
    const std::vector<std::string> found = validate(bvh, scene);
    REQUIRE_FALSE(found.empty());
    CHECK(found.size() <= 20);
    CHECK_THAT(found.front(), ContainsSubstring(sentence));
}
using Nodes = std::vector<WideNode<4>>;

std::uint32_t first_leaf_node(const WideBvh& bvh) {
    std::uint32_t id = 0;
    while (!is_leaf(bvh.node_refs[id])) ++id;
    return id;
}

}  // namespace

TEST_CASE("validate: each broken invariant is named with node and element", "[reference][bvh]") {
    SECTION("width") {
        expect_violation("width says 8, but the nodes have 4 children",
                         [](WideBvh& bvh, Nodes&) { bvh.width = 8; });
    }
    SECTION("no nodes") {
        expect_violation("the tree has 0 nodes", [](WideBvh& bvh, Nodes& inner) {
            bvh.node_refs.clear();
            inner.clear();
        });
    }
    SECTION("a node too few") {
        expect_violation("node_refs has", [](WideBvh& bvh, Nodes&) { bvh.node_refs.pop_back(); });
    }
    SECTION("a parent too few") {
        expect_violation("parents has", [](WideBvh& bvh, Nodes&) { bvh.parents.pop_back(); });
    }
    SECTION("levels end early") {
        expect_violation("is below the levels, but its parent",
                         [](WideBvh& bvh, Nodes&) { --bvh.level_begins.back(); });
    }
    SECTION("levels end late") {
        expect_violation("level_begins has",
                         [](WideBvh& bvh, Nodes&) { ++bvh.level_begins.back(); });
    }
    SECTION("empty level") {
        expect_violation("level 1 begins at node 1 and ends at 1",
                         [](WideBvh& bvh, Nodes&) { bvh.level_begins[2] = 1; });
    }
    SECTION("crowded root level") {
        expect_violation("level 0 has 2 nodes",
                         [](WideBvh& bvh, Nodes&) { bvh.level_begins[1] = 2; });
    }
    SECTION("reference out of range") {
        expect_violation("node 1: refers to inner node 12345",
                         [](WideBvh& bvh, Nodes&) { bvh.node_refs[1] = 12345; });
    }
    SECTION("reference twice") {
        expect_violation("node 2: refers to",
                         [](WideBvh& bvh, Nodes&) { bvh.node_refs[2] = bvh.node_refs[1]; });
    }
    SECTION("root is a leaf") {
        expect_violation("node 0: the root is a leaf", [](WideBvh& bvh, Nodes&) {
            std::swap(bvh.node_refs[0], bvh.node_refs[first_leaf_node(bvh)]);
        });
    }
    SECTION("child out of range") {
        expect_violation("node 0 child 1: is node 99999",
                         [](WideBvh&, Nodes& inner) { inner[0].child[1] = 99999; });
    }
    SECTION("child on a wrong level") {
        expect_violation("is on level 0, its parent on level 0",
                         [](WideBvh&, Nodes& inner) { inner[0].child[0] = 0; });
    }
    SECTION("wrong parent") {
        expect_violation("node 0 child 1: node 2 names 7 as its parent",
                         [](WideBvh& bvh, Nodes&) { bvh.parents[2] = 7; });
    }
    SECTION("root with a parent") {
        expect_violation("the root names 3 as its parent",
                         [](WideBvh& bvh, Nodes&) { bvh.parents[0] = 3; });
    }
    SECTION("no children") {
        expect_violation("node 0: has no children", [](WideBvh&, Nodes& inner) {
            for (int i = 0; i < 4; ++i) {
                inner[0].child[i] = kNone;
                inner[0].low_x[i] = inner[0].low_y[i] = inner[0].low_z[i] = kInfinity;
                inner[0].high_x[i] = inner[0].high_y[i] = inner[0].high_z[i] = -kInfinity;
            }
        });
    }
    SECTION("missing child with a box") {
        expect_violation("node 0 child 3: is missing, but its box is",
                         [](WideBvh&, Nodes& inner) { inner[0].child[3] = kNone; });
    }
    SECTION("node reached twice") {
        expect_violation("node 1: is the child of 2 nodes, expected 1",
                         [](WideBvh&, Nodes& inner) { inner[0].child[1] = inner[0].child[0]; });
    }
    SECTION("leaf range with a gap") {
        expect_violation("leaf 3: has", [](WideBvh& bvh, Nodes&) { ++bvh.leaves[3].first; });
    }
    SECTION("empty leaf") {
        expect_violation("leaf 0: has 0 triangles",
                         [](WideBvh& bvh, Nodes&) { bvh.leaves[0].count = 0; });
    }
    SECTION("leaf beyond the end") {
        expect_violation("ends at triangle",
                         [](WideBvh& bvh, Nodes&) { bvh.leaves.back().count += 9; });
    }
    SECTION("leaves end early") {
        expect_violation(
            "the leaves end at triangle 200, but there are 201",
            [](WideBvh& bvh, Nodes&) { bvh.triangles.push_back(bvh.triangles.back()); });
    }
    SECTION("unknown primitive") {
        expect_violation("triangle 5: is primitive 777, but the scene has 200",
                         [](WideBvh& bvh, Nodes&) { bvh.triangles[5].primitive = 777; });
    }
    SECTION("primitive twice") {
        expect_violation("leaves, expected 1",  // the doubled one or, if first, the one now gone
                         [](WideBvh& bvh, Nodes&) { bvh.triangles[0] = bvh.triangles[1]; });
    }
    SECTION("changed vertex") {
        expect_violation("triangle 5: its vertices are not those of primitive",
                         [](WideBvh& bvh, Nodes&) { bvh.triangles[5].v1.x += 1.0f; });
    }
    SECTION("child box one ulp too small") {
        expect_violation("does not contain the vertices below", [](WideBvh&, Nodes& inner) {
            inner.back().high_x[0] = std::nextafter(inner.back().high_x[0], -10.0f);
        });
    }
    SECTION("child box not a number") {
        expect_violation("does not contain the vertices below", [](WideBvh&, Nodes& inner) {
            inner[0].low_y[2] = std::numeric_limits<float>::quiet_NaN();
        });
    }
    SECTION("child box beyond the node's own") {
        expect_violation("node 0 child 0: its box", [](WideBvh&, Nodes& inner) {
            inner[0].high_z[0] = inner[0].high[2] + 1.0f;
        });
    }
}
