/// What is uploaded to a device against the host's tables, element by element.
#include <bit>
#include <cstring>
#include <span>
#include <variant>

#include "gpu/host/device_scene.h"
#include "reference/contract/wide_bvh.h"
#include "tests/catch.h"
#include "tests/emulation/renders.h"
#include "tests/verify/capture_tools.h"

namespace {

using namespace scotty::reference;
using scotty::emulation::test::scene_named;
using scotty::gpu::simt::DeviceScene;
using scotty::verify::test::small_parameters;

template <class T>
bool same_bytes(const T* device, std::span<const T> host) {
    return host.empty() || std::memcmp(device, host.data(), host.size_bytes()) == 0;
}

void check_scene(const SceneView& device, const Scene& scene) {
    CHECK(same_bytes<Vec3>(device.vertices, scene.vertices));
    REQUIRE((device.normals == nullptr) == scene.normals.empty());
    CHECK(same_bytes<Vec3>(device.normals, scene.normals));
    CHECK(same_bytes<std::uint32_t>(device.triangles,
                                    {scene.triangles.front().data(), 3 * scene.triangles.size()}));
    CHECK(same_bytes<std::uint32_t>(device.material_of, scene.material_of));
    CHECK(same_bytes<Material>(device.materials, scene.materials));
    CHECK(same_bytes<Light>(device.lights, scene.lights));
    // The rest is passed by value.
    const SceneView host = view_of(scene);
    CHECK(device.light_count == host.light_count);
    CHECK(std::memcmp(&device.camera, &host.camera, sizeof host.camera) == 0);
}

/// One child of a node below the queues, against the BVH's own.
template <int Width>
void check_child(const scotty::gpu::simt::SubtreeNode<Width>& node, const WideNode<Width>& host,
                 int child, const WideBvh& bvh, std::uint32_t first_subtree) {
    const float* const planes[3][2] = {
        {host.low_x, host.high_x}, {host.low_y, host.high_y}, {host.low_z, host.high_z}};
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = 0; side < 2; ++side) {
            CHECK(std::bit_cast<std::uint32_t>(node.planes[axis][side].at[child]) ==
                  std::bit_cast<std::uint32_t>(planes[axis][side][child]));
        }
    }
    const std::uint32_t id = host.child[child];
    std::uint32_t expected = kNone;
    if (id != kNone) {
        const std::uint32_t ref = bvh.node_refs[id];
        expected = is_leaf(ref) ? kLeafBit | bvh.leaves[ref_index(ref)].first : ref - first_subtree;
    }
    CHECK(node.child[child] == expected);
}

template <int Width>
void check_bvh(const DeviceScene& device, const WideBvh& bvh) {
    const auto& inner = std::get<std::vector<WideNode<Width>>>(bvh.inner);
    const auto view = device.bvh<Width>();
    const std::uint32_t nodes = bvh.level_begins.back();
    std::uint32_t inner_nodes = 0, leaves = 0;
    for (std::uint32_t id = 0; id < nodes; ++id) {
        const std::uint32_t ref = bvh.node_refs[id];
        CHECK(view.node_refs[id] == ref);
        const bool has_parent = id >= bvh.level_begins[1];
        std::uint32_t level = 0;
        while (bvh.level_begins[level + 1] <= id) ++level;
        CHECK(device.parent_positions()[id] ==
              (has_parent ? bvh.parents[id] - bvh.level_begins[level - 1] : 0));
        if (is_leaf(ref)) {
            ++leaves;
            CHECK(same_bytes<Leaf>(view.leaves + ref_index(ref), {&bvh.leaves[ref_index(ref)], 1}));
        } else {
            ++inner_nodes;
            CHECK(same_bytes<WideNode<Width>>(view.inner + ref_index(ref),
                                              {&inner[ref_index(ref)], 1}));
        }
    }
    CHECK(inner_nodes + leaves == nodes);
    for (std::size_t i = 0; i < bvh.triangles.size(); ++i) {
        const LeafTriangle& host = bvh.triangles[i];
        CHECK(view.triangles[i].primitive() == host.primitive);
        for (int axis = 0; axis < 3; ++axis) {
            const auto& row = view.triangles[i].axis[axis];
            const float expected[] = {host.v0[axis], host.v1[axis], host.v2[axis]};
            CHECK(std::memcmp(&row, expected, sizeof expected) == 0);
        }
    }
    std::vector<bool> last(bvh.triangles.size());
    for (const Leaf& leaf : bvh.leaves) last[leaf.first + leaf.count - 1] = true;
    for (std::size_t i = 0; i < last.size(); ++i) {
        for (const auto& row : view.triangles[i].axis) {
            CHECK(((row.primitive_and_last & scotty::gpu::simt::kLastBit) != 0) == last[i]);
        }
    }
    if (view.subtrees == nullptr) return;
    for (std::size_t i = view.first_subtree; i < inner.size(); ++i) {
        for (int child = 0; child < Width; ++child) {
            check_child<Width>(view.subtrees[i - view.first_subtree], inner[i], child, bvh,
                               view.first_subtree);
        }
    }
}

TEST_CASE("device scene: every table that is uploaded is the host's", "[simt][device-scene]") {
    for (const char* name : {"spheres", "metals"}) {
        for (const int width : {2, 4, 8, 16}) {
            for (const std::uint32_t queue_levels : {0u, 1u, 3u}) {
                PipelineParameters p = small_parameters();
                p.width = width;
                p.queue_levels = queue_levels;
                const Scene& scene = scene_named(name);
                const WideBvh bvh = build_wide_bvh(scene, bvh_parameters(p, 0));
                scotty::gpu::simt::MemoryBudget budget;
                const bool pairs = queue_levels != 1;
                const DeviceScene device(scene, bvh, pairs, budget);
                INFO(name << ", width " << width << ", queue levels " << queue_levels);
                CHECK(device.inner_begins() == inner_begins(bvh));
                CHECK(device.level_begins() == bvh.level_begins);
                check_scene(device.view(), scene);
                switch (width) {
                    case 2:
                        check_bvh<2>(device, bvh);
                        break;
                    case 4:
                        check_bvh<4>(device, bvh);
                        break;
                    case 8:
                        check_bvh<8>(device, bvh);
                        break;
                    default:
                        check_bvh<16>(device, bvh);
                }
            }
        }
    }
}

}  // namespace
