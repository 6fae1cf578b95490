/// Serialisation of the compacted BVH in breadth-first order.
#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "reference/base/memory.h"
#include "reference/bvh/binary_bvh.h"
#include "reference/bvh/reinsertion.h"
#include "reference/bvh/wide_bvh_compaction.h"
#include "reference/contract/wide_bvh.h"

namespace scotty::reference {
namespace {

constexpr int kMaxLeafSize = 1024;

/// The shape of the wide BVH before its nodes are written: by breadth-first id.
struct Shape {
    std::vector<std::uint32_t> binary;       ///< the binary node that this one stands for
    std::vector<std::uint32_t> parents;      ///< kNone at the root
    std::vector<std::uint32_t> first_child;  ///< children are neighbours; kNone at a leaf
    std::vector<std::uint32_t> level_begins;
    std::uint32_t inner_count = 0;

    std::uint32_t size() const { return static_cast<std::uint32_t>(binary.size()); }
    std::uint32_t add(std::uint32_t binary_node, std::uint32_t parent) {
        binary.push_back(binary_node);
        parents.push_back(parent);
        first_child.push_back(kNone);
        return size() - 1;
    }
};

Shape make_shape(const BinaryBvh& binary, int width, int max_leaf_size) {
    const Compaction compaction(binary, width, max_leaf_size);
    Shape shape;
    shape.add(0, kNone);
    std::array<std::uint32_t, kMaxWidth> children;
    for (std::uint32_t begin = 0; begin < shape.size();) {
        const std::uint32_t end = shape.size();
        shape.level_begins.push_back(begin);
        for (std::uint32_t id = begin; id < end; ++id) {
            const std::uint32_t node = shape.binary[id];
            const bool leaf = compaction.is_leaf(node);
            if (leaf && id != 0) continue;
            const std::uint32_t first = shape.size();
            if (leaf) {  // everything fits one leaf: the root is an inner node all the same
                shape.add(node, id);
            } else {
                const int count = compaction.children(node, children);
                for (int i = 0; i < count; ++i) shape.add(children[i], id);
            }
            shape.first_child[id] = first;
            ++shape.inner_count;
        }
        begin = end;
    }
    shape.level_begins.push_back(shape.size());
    return shape;
}

template <int Width>
void write_inner(const BinaryBvh& binary, const Shape& shape, std::uint32_t id,
                 WideNode<Width>& node) {
    const BinaryNode& self = binary.nodes[shape.binary[id]];
    for (int axis = 0; axis < 3; ++axis) {
        node.low[axis] = self.low[axis];
        node.high[axis] = self.high[axis];
    }
    const std::uint32_t first = shape.first_child[id];
    for (int i = 0; i < Width; ++i) {
        const std::uint32_t child = first + static_cast<std::uint32_t>(i);
        const bool exists = child < shape.size() && shape.parents[child] == id;
        const Bounds missing;
        const Vec3 low = exists ? binary.nodes[shape.binary[child]].low : missing.low;
        const Vec3 high = exists ? binary.nodes[shape.binary[child]].high : missing.high;
        node.low_x[i] = low.x;
        node.low_y[i] = low.y;
        node.low_z[i] = low.z;
        node.high_x[i] = high.x;
        node.high_y[i] = high.y;
        node.high_z[i] = high.z;
        node.child[i] = exists ? child : kNone;
    }
}

void write_leaf(const Scene& scene, const BinaryBvh& binary, const BinaryNode& node,
                LeafTriangle* triangles) {
    std::vector<std::uint32_t> ids(binary.order.begin() + node.first,
                                   binary.order.begin() + node.first + node.count);
    std::sort(ids.begin(), ids.end());
    for (const std::uint32_t id : ids) {
        const auto& index = scene.triangles[id];
        *triangles++ = {scene.vertices[index[0]], scene.vertices[index[1]],
                        scene.vertices[index[2]], id};
    }
}

template <int Width>
WideBvh serialise(const Scene& scene, const BinaryBvh& binary, Shape shape) {
    WideBvh bvh;
    bvh.width = Width;
    bvh.triangles.resize(scene.triangles.size());
    bvh.node_refs.resize(shape.size());
    bvh.leaves.reserve(shape.size() - shape.inner_count);
    std::uint32_t inner_count = 0;
    std::uint32_t triangle_count = 0;
    for (std::uint32_t id = 0; id < shape.size(); ++id) {
        if (shape.first_child[id] != kNone) {
            bvh.node_refs[id] = inner_count++;
        } else {
            const std::uint32_t count = binary.nodes[shape.binary[id]].count;
            bvh.node_refs[id] = kLeafBit | static_cast<std::uint32_t>(bvh.leaves.size());
            bvh.leaves.push_back({triangle_count, count});
            triangle_count += count;
        }
    }
    // Every slot's place is known now: the contents are written in parallel.
    std::vector<WideNode<Width>> inner(shape.inner_count);
    tbb::parallel_for(std::uint32_t{0}, shape.size(), [&](std::uint32_t id) {
        const std::uint32_t index = ref_index(bvh.node_refs[id]);
        if (is_leaf(bvh.node_refs[id])) {
            write_leaf(scene, binary, binary.nodes[shape.binary[id]],
                       bvh.triangles.data() + bvh.leaves[index].first);
        } else {
            write_inner<Width>(binary, shape, id, inner[index]);
        }
    });
    bvh.inner = std::move(inner);
    bvh.parents = std::move(shape.parents);
    bvh.level_begins = std::move(shape.level_begins);
    return bvh;
}

template <int Width>
WideBvh build(const Scene& scene, int max_leaf_size) {
    BinaryBvh binary = build_binary_bvh(scene);
    optimise_by_reinsertion(binary);
    return serialise<Width>(scene, binary, make_shape(binary, Width, max_leaf_size));
}

}  // namespace

void validate(const BvhParameters& parameters) {
    const int width = parameters.width;
    if (width != 2 && width != 4 && width != 8 && width != 16) {
        throw Error::bad_input("BVH width", fmt::format("expected 2, 4, 8 or 16, found {}", width));
    }
    if (parameters.max_leaf_size < 1 || parameters.max_leaf_size > kMaxLeafSize) {
        throw Error::bad_input("BVH leaf size",
                               fmt::format("expected 1 to {} triangles, found {}", kMaxLeafSize,
                                           parameters.max_leaf_size));
    }
}

/// At the peak, a triangle: measured on blobs of one and three million triangles.
constexpr std::uint64_t kBytesToBuild = 200;

WideBvh build_wide_bvh(const Scene& scene, const BvhParameters& parameters) {
    validate(parameters);
    if (scene.triangles.empty()) {
        throw Error::bad_input(scene.name, "expected at least one triangle, found none");
    }
    // Binary nodes, wide nodes and leaves are all fewer than twice the triangles, and ids have 31
    // bits.
    if (scene.triangles.size() >= kLeafBit / 2) {
        throw Error::bad_input(scene.name, fmt::format("expected fewer than {} triangles, found {}",
                                                       kLeafBit / 2, scene.triangles.size()));
    }
    require_memory(kBytesToBuild * scene.triangles.size(),
                   fmt::format("building the BVH of {} triangles", scene.triangles.size()),
                   "a scene of fewer triangles needs less");
    const int threads =
        parameters.threads == 0 ? tbb::task_arena::automatic : static_cast<int>(parameters.threads);
    tbb::task_arena arena(threads);
    WideBvh bvh = arena.execute([&] {
        switch (parameters.width) {
            case 2:
                return build<2>(scene, parameters.max_leaf_size);
            case 4:
                return build<4>(scene, parameters.max_leaf_size);
            case 8:
                return build<8>(scene, parameters.max_leaf_size);
            default:
                return build<16>(scene, parameters.max_leaf_size);
        }
    });
    cut_levels(bvh, parameters.queue_levels);
    return bvh;
}

}  // namespace scotty::reference
