
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <vector>

#include "reference/bvh/binary_bvh.h"
#include "reference/bvh/reinsertion.h"
#include "reference/contract/wide_bvh.h"
#include "tests/catch.h"
#include "tests/reference/hard_cases.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

Box box_of(const Scene& scene, std::uint32_t triangle) {
    const auto& index = scene.triangles[triangle];
    return Triangle{scene.vertices[index[0]], scene.vertices[index[1]], scene.vertices[index[2]]}
        .box();
}

/// The boxes of a tree whose scene has changed.
void refit(BinaryBvh& bvh, const Scene& scene) {
    for (std::size_t id = bvh.nodes.size(); id-- > 0;) {
        BinaryNode& node = bvh.nodes[id];
        if (node.right == kNone) {
            const Box box = box_of(scene, bvh.order[node.first]);
            node.low = box.low;
            node.high = box.high;
        } else {
            node.low = min_of(bvh.nodes[id + 1].low, bvh.nodes[node.right].low);
            node.high = max_of(bvh.nodes[id + 1].high, bvh.nodes[node.right].high);
        }
    }
}

/// The same nodes to the last bit, in the same order, above the same triangles.
bool are_same(const BinaryBvh& a, const BinaryBvh& b) {
    return a.order == b.order && a.nodes.size() == b.nodes.size() &&
           std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(BinaryNode)) == 0;
}

/// Every triangle below the root exactly once, leaves of one triangle with its exact box, every
/// other box the exact union of its children's, ids depth first.
void check_structure(const BinaryBvh& bvh, const Scene& scene) {
    REQUIRE(bvh.nodes.size() == 2 * scene.triangles.size() - 1);
    std::vector<std::uint32_t> order = bvh.order;
    std::sort(order.begin(), order.end());
    std::vector<std::uint32_t> all(scene.triangles.size());
    std::iota(all.begin(), all.end(), 0u);
    REQUIRE(order == all);
    REQUIRE(bvh.nodes.front().count == scene.triangles.size());
    std::size_t wrong = 0;
    for (std::uint32_t id = 0; id < bvh.nodes.size(); ++id) {
        const BinaryNode& node = bvh.nodes[id];
        if (node.right == kNone) {
            const Box box = box_of(scene, bvh.order[node.first]);
            wrong += node.count != 1 || node.low != box.low || node.high != box.high;
            continue;
        }
        const BinaryNode& left = bvh.nodes[id + 1];
        const BinaryNode& right = bvh.nodes[node.right];
        wrong += node.low != min_of(left.low, right.low) ||
                 node.high != max_of(left.high, right.high) ||
                 node.count != left.count + right.count || left.first != node.first ||
                 right.first != node.first + left.count || node.right != id + 2 * left.count;
    }
    CHECK(wrong == 0);
}

/// Optimises and checks all that is promised; returns the cost before over the cost after.
double check_optimised(const Scene& scene, BinaryBvh bvh) {
    INFO(scene.name << ", " << scene.triangles.size() << " triangles");
    check_structure(bvh, scene);
    const double before = surface_area_cost(bvh);
    optimise_by_reinsertion(bvh);
    check_structure(bvh, scene);
    const double after = surface_area_cost(bvh);
    CHECK(after <= before * (1.0 + 1.0e-12));  // sums in two orders
    return after > 0.0 ? before / after : 1.0;
}

Scene coincident(std::size_t count) {
    Scene scene = triangle_scene({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    while (scene.triangles.size() < count) scene.triangles.push_back(scene.triangles.front());
    return scene;
}

}  // namespace

TEST_CASE("reinsertion: the cost never rises and the tree stays a tree", "[reference][bvh]") {
    for (const Scene& scene : {soup(3000, 0.1f, 21), soup(500, 2.0f, 22), icosphere(4),
                               height_field(40), soup(2, 1.0f, 23), soup(3, 1.0f, 24)}) {
        check_optimised(scene, build_binary_bvh(scene));
        check_optimised(scene, build_median_bvh(scene));
    }
}

TEST_CASE("reinsertion: hard scenes", "[reference][bvh]") {
    Random random(25);
    for (std::uint32_t kind = 0; kind < kHardScenes; ++kind) {
        for (const std::size_t triangles : {1, 2, 3, 4, 5, 17, 400}) {
            const Scene scene = hard_scene(static_cast<HardScene>(kind), triangles, random);
            check_optimised(scene, build_binary_bvh(scene));
            check_optimised(scene, build_median_bvh(scene));
        }
    }
}

TEST_CASE("reinsertion: triangles that all coincide, and a single one", "[reference][bvh]") {
    for (const std::size_t count : {1, 2, 3, 1000}) {
        const Scene scene = coincident(count);
        const BinaryBvh bvh = build_binary_bvh(scene);
        check_optimised(scene, bvh);
        BinaryBvh optimised = bvh;
        optimise_by_reinsertion(optimised);
        CHECK(are_same(optimised, bvh));  // nothing to gain: nothing moves
    }
}

TEST_CASE("reinsertion: a subtree in a wrong place goes home", "[reference][bvh]") {
    // Two clusters far apart, in an order that median splits by index would not mend: a triangle of
    // the right cluster sits in the left one.
    Scene scene;
    for (const float x : {0.0f, 1.0f, 2.0f, 3.0f, 100.0f, 101.0f, 102.0f, 103.0f}) {
        add_triangle(scene, {x, 0, 0}, {x + 0.5f, 0, 1}, {x, 1, 0});
    }
    BinaryBvh bvh = build_median_bvh(scene);
    const double right = surface_area_cost(bvh);
    std::swap(scene.vertices[0], scene.vertices[21]);  // triangles 0 and 7 change places,
    std::swap(scene.vertices[1], scene.vertices[22]);  // the tree does not
    std::swap(scene.vertices[2], scene.vertices[23]);
    refit(bvh, scene);
    CHECK(surface_area_cost(bvh) > 1.5 * right);
    check_optimised(scene, bvh);
    optimise_by_reinsertion(bvh);
    CHECK(surface_area_cost(bvh) < 1.1 * right);
}

TEST_CASE("reinsertion: bad trees become much better", "[reference][bvh]") {
    const Scene scene = soup(4000, 0.05f, 26);
    CHECK(check_optimised(scene, build_median_bvh(scene)) > 1.05);
    Random random(27);
    BinaryBvh shuffled = build_median_bvh(scene);
    Scene other = scene;  // the same tree above triangles that have nothing to do with it
    for (std::size_t i = other.triangles.size(); i-- > 1;) {
        std::swap(other.triangles[i], other.triangles[random() % (i + 1)]);
    }
    refit(shuffled, other);
    CHECK(check_optimised(other, shuffled) > 3.0);
}

TEST_CASE("reinsertion: the same bits for 1, 2 and 8 threads, on every run", "[reference][bvh]") {
    const tbb::global_control allow(tbb::global_control::max_allowed_parallelism, 8);
    // The second has more nodes than one round tries.
    for (const Scene& scene : {soup(5000, 0.1f, 28), height_field(200)}) {
        const BinaryBvh built = build_binary_bvh(scene);
        BinaryBvh expected = built;
        tbb::task_arena(1).execute([&] { optimise_by_reinsertion(expected); });
        CHECK_FALSE(are_same(expected, built));
        for (const int threads : {1, 2, 8, 8}) {
            BinaryBvh bvh = built;
            tbb::task_arena(threads).execute([&] { optimise_by_reinsertion(bvh); });
            CHECK(are_same(bvh, expected));
        }
    }
}

TEST_CASE("reinsertion: the tree of the pipelines is optimised", "[reference][bvh]") {
    const Scene scene = soup(300, 0.1f, 29);
    BvhParameters parameters;
    parameters.width = 2;
    parameters.max_leaf_size = 1;
    const WideBvh wide = build_wide_bvh(scene, parameters);
    double sum = 0.0;
    double root = 0.0;
    for (const WideNode<2>& node : std::get<std::vector<WideNode<2>>>(wide.inner)) {
        const Vec3 size = Vec3(node.high[0], node.high[1], node.high[2]) -
                          Vec3(node.low[0], node.low[1], node.low[2]);
        const double area =
            double{size.x} * size.y + double{size.y} * size.z + double{size.z} * size.x;
        if (root == 0.0) root = area;
        sum += area;
    }
    BinaryBvh binary = build_binary_bvh(scene);
    const double before = surface_area_cost(binary);
    optimise_by_reinsertion(binary);
    CHECK(surface_area_cost(binary) < 0.99 * before);
    CHECK(sum / root == Approx(surface_area_cost(binary)).epsilon(1.0e-5));
}
