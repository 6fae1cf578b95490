#include "reference/bvh/binary_bvh.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

#include "reference/base/assert.h"
#include "reference/base/embree_api.h"

namespace scotty::reference {
namespace {

/// Levels that Embree may use. Binned SAH needs more only for inputs that halve nothing hundreds of
/// times over; each level costs it several KiB of stack, hence not simply a huge number.
constexpr unsigned kMaxEmbreeDepth = 256;

/// What Embree's callbacks build, in its own arena: an inner node, or the header of a leaf with
/// `count` triangle indices behind it.
struct BuiltNode {
    std::array<const BuiltNode*, 2> children;
    std::uint32_t count;  ///< 0: inner node

    const std::uint32_t* triangles() const {
        return reinterpret_cast<const std::uint32_t*>(this + 1);
    }
};

void* create_node(RTCThreadLocalAllocator allocator, unsigned /*child_count*/, void* /*user*/) {
    void* memory = rtcThreadLocalAlloc(allocator, sizeof(BuiltNode), alignof(BuiltNode));
    return new (memory) BuiltNode{{nullptr, nullptr}, 0};
}

void set_children(void* node, void** children, unsigned child_count, void* /*user*/) {
    for (unsigned i = 0; i < child_count; ++i) {
        static_cast<BuiltNode*>(node)->children[i] = static_cast<const BuiltNode*>(children[i]);
    }
}

/// The builder's bounds are not used: ours are exact.
void set_bounds(void* /*node*/, const RTCBounds** /*bounds*/, unsigned /*count*/, void* /*user*/) {}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives,
                  std::size_t count, void* /*user*/) {
    void* memory =
        rtcThreadLocalAlloc(allocator, sizeof(BuiltNode) + count * sizeof(std::uint32_t), 16);
    auto* node = new (memory) BuiltNode{{nullptr, nullptr}, static_cast<std::uint32_t>(count)};
    auto* triangles = reinterpret_cast<std::uint32_t*>(node + 1);
    for (std::size_t i = 0; i < count; ++i) triangles[i] = primitives[i].primID;
    return node;
}

Bounds bounds_of_triangle(const Scene& scene, std::uint32_t triangle) {
    const auto& index = scene.triangles[triangle];
    const Vec3& a = scene.vertices[index[0]];
    const Vec3& b = scene.vertices[index[1]];
    const Vec3& c = scene.vertices[index[2]];
    return {min_of(min_of(a, b), c), max_of(max_of(a, b), c)};
}

/// Boxes and counts from the leaves upwards: children come after their parent.
void fill_bounds(BinaryBvh& bvh, const Scene& scene) {
    for (std::size_t i = bvh.nodes.size(); i-- > 0;) {
        BinaryNode& node = bvh.nodes[i];
        if (node.right == kNone) {
            Bounds bounds;
            for (std::uint32_t k = 0; k < node.count; ++k) {
                const Bounds one = bounds_of_triangle(scene, bvh.order[node.first + k]);
                bounds.low = min_of(bounds.low, one.low);
                bounds.high = max_of(bounds.high, one.high);
            }
            node.low = bounds.low;
            node.high = bounds.high;
        } else {
            const BinaryNode& left = bvh.nodes[i + 1];
            const BinaryNode& right = bvh.nodes[node.right];
            node.low = min_of(left.low, right.low);
            node.high = max_of(left.high, right.high);
            node.count = left.count + right.count;
        }
    }
}

/// Embree's pointers to our depth-first array. An explicit stack: depth is the input's to choose.
BinaryBvh flatten(const BuiltNode* root, std::size_t triangle_count) {
    struct Visit {
        const BuiltNode* node;
        std::uint32_t parent;  ///< whose right child this is; kNone for a left child
    };
    BinaryBvh bvh;
    bvh.order.reserve(triangle_count);
    std::vector<Visit> stack{{root, kNone}};
    while (!stack.empty()) {
        const Visit visit = stack.back();
        stack.pop_back();
        const auto id = static_cast<std::uint32_t>(bvh.nodes.size());
        if (visit.parent != kNone) bvh.nodes[visit.parent].right = id;
        const auto first = static_cast<std::uint32_t>(bvh.order.size());
        bvh.nodes.push_back({Vec3(0.0f), Vec3(0.0f), first, visit.node->count, kNone});
        if (visit.node->count == 0) {
            stack.push_back({visit.node->children[1], id});
            stack.push_back({visit.node->children[0], kNone});
        } else {
            const std::uint32_t* triangles = visit.node->triangles();
            bvh.order.insert(bvh.order.end(), triangles, triangles + visit.node->count);
            std::sort(bvh.order.begin() + first, bvh.order.end());
        }
    }
    SCOTTY_ASSERT(bvh.order.size(), ==, triangle_count);
    return bvh;
}

std::vector<RTCBuildPrimitive> build_primitives(const Scene& scene) {
    std::vector<RTCBuildPrimitive> primitives(scene.triangles.size());
    tbb::parallel_for(std::size_t{0}, primitives.size(), [&](std::size_t i) {
        const auto id = static_cast<std::uint32_t>(i);
        const Bounds bounds = bounds_of_triangle(scene, id);
        primitives[i] = {bounds.low.x,  bounds.low.y,  bounds.low.z,  0,
                         bounds.high.x, bounds.high.y, bounds.high.z, id};
    });
    return primitives;
}

}  // namespace

BinaryBvh build_binary_bvh(const Scene& scene) {
    SCOTTY_ASSERT(scene.triangles.size(), >, 0u);
    std::vector<RTCBuildPrimitive> primitives = build_primitives(scene);
    const EmbreeOwner<RTCDevice> device = make_embree_device();
    const EmbreeOwner<RTCBVH> bvh(rtcNewBVH(device.get()));
    check_embree(device.get(), "rtcNewBVH");

    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxDepth = kMaxEmbreeDepth;
    arguments.maxLeafSize = 1;
    arguments.bvh = bvh.get();
    arguments.primitives = primitives.data();
    arguments.primitiveCount = primitives.size();
    arguments.primitiveArrayCapacity = primitives.size();
    arguments.createNode = create_node;
    arguments.setNodeChildren = set_children;
    arguments.setNodeBounds = set_bounds;
    arguments.createLeaf = create_leaf;
    const auto* root = static_cast<const BuiltNode*>(rtcBuildBVH(&arguments));
    if (root == nullptr) {
        const RTCError error = rtcGetDeviceError(device.get());
        if (error == RTC_ERROR_OUT_OF_MEMORY) {
            throw Error::internal(fmt::format(
                "Embree: out of memory while building a BVH of {} triangles", primitives.size()));
        }
        return build_median_bvh(scene);  // "depth limit reached"
    }
    BinaryBvh binary = flatten(root, primitives.size());
    fill_bounds(binary, scene);
    return binary;
}

BinaryBvh build_median_bvh(const Scene& scene) {
    struct Range {
        std::uint32_t begin, end;
        std::uint32_t parent;  ///< whose right child this is; kNone for a left child
    };
    const auto triangle_count = static_cast<std::uint32_t>(scene.triangles.size());
    SCOTTY_ASSERT(triangle_count, >, 0u);
    std::vector<Vec3> centroids(triangle_count);
    for (std::uint32_t i = 0; i < triangle_count; ++i) {
        const Bounds bounds = bounds_of_triangle(scene, i);
        centroids[i] = 0.5f * bounds.low + 0.5f * bounds.high;
    }
    BinaryBvh bvh;
    bvh.order.resize(triangle_count);
    std::iota(bvh.order.begin(), bvh.order.end(), 0u);
    std::vector<Range> stack{{0, triangle_count, kNone}};
    while (!stack.empty()) {
        const Range range = stack.back();
        stack.pop_back();
        const auto id = static_cast<std::uint32_t>(bvh.nodes.size());
        if (range.parent != kNone) bvh.nodes[range.parent].right = id;
        const std::uint32_t count = range.end - range.begin;
        bvh.nodes.push_back({Vec3(0.0f), Vec3(0.0f), range.begin, count, kNone});
        const auto begin = bvh.order.begin() + range.begin;
        const auto end = bvh.order.begin() + range.end;
        if (count == 1) continue;
        Bounds bounds;
        std::for_each(begin, end, [&](std::uint32_t i) {
            bounds.low = min_of(bounds.low, centroids[i]);
            bounds.high = max_of(bounds.high, centroids[i]);
        });
        const Vec3 size = bounds.high - bounds.low;
        const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
        const std::uint32_t middle = range.begin + count / 2;
        std::nth_element(begin, begin + count / 2, end, [&](std::uint32_t a, std::uint32_t b) {
            return centroids[a][axis] != centroids[b][axis]
                       ? centroids[a][axis] < centroids[b][axis]
                       : a < b;
        });
        stack.push_back({middle, range.end, id});
        stack.push_back({range.begin, middle, kNone});
    }
    fill_bounds(bvh, scene);
    return bvh;
}

}  // namespace scotty::reference
