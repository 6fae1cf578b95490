/// Writes captures: the rays, queues and hits of a traversal, launch by launch, for `scotty diff`.
///
/// One header without dependencies, C++17, for anybody's breadth-first ray tracer on a CPU or in
/// CUDA: tree, node ids, ray ids and records are the caller's own. docs/your-own-code.md shows a
/// worked example, docs/captures.md the format. Every function throws capture::Error.
///
///     scotty::capture::Writer writer("mine.capture", "mine");
///     writer.triangle({{v0.x, v0.y, v0.z}, {...}, {...}});            // 0, 1, 2, ...
///     writer.inner(node.id, {{child.id, low, high}, ...});            // the tree, in any order
///     writer.leaf(node.id, {primitive, ...});
///     auto& query = writer.query();
///     query.rays(device_rays, n, [](const MyRay& r) { return scotty::capture::Ray{r.id, ...}; });
///     query.queue(node.id, device_queue, length, &MyRay::id);         // for each node
///     query.hits(id, device_hits, count, to_hit, slots);              // for each ray
///     query.closest(device_closest, n, to_hit);
///     writer.finish();
///
/// What is not given is not judged. Pointers may lead to the memory of a device where the file is
/// compiled by a CUDA compiler, or SCOTTY_CAPTURE_CUDA is defined.
#pragma once

#if __cplusplus < 201703L
#error "scotty/capture_writer.h needs C++17"
#endif

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "verify/capture/include/scotty/capture_layout.h"

#if defined(__CUDACC__) || defined(SCOTTY_CAPTURE_CUDA)
#include <cuda_runtime.h>
#define SCOTTY_CAPTURE_MEMORY any_memory
#else
#define SCOTTY_CAPTURE_MEMORY host_memory
#endif

/// Files with and without CUDA may be parts of one program: they have names of their own.
namespace scotty::capture {
inline namespace SCOTTY_CAPTURE_MEMORY {

using NodeId = std::uint64_t;  ///< the caller's own; any numbers, in any order
using RayId = std::uint64_t;
using Point = std::array<float, 3>;

/// Hits count in [t_min, t_max); t_max < t_min is a ray that is not traced.
struct Ray {
    RayId id = 0;
    Point origin{}, direction{};
    float t_min = 0.0f, t_max = kInfinity;
};
/// Primitives count from 0 as triangles were given; kNothing where nothing is hit.
struct Hit {
    float t = kInfinity;
    std::uint32_t primitive = kNothing;
    RayId ray = 0;  ///< where closest() is told
};
/// A child of an inner node, and its box.
struct Child {
    NodeId id = 0;
    Point low{}, high{};
};

struct Settings {
    std::uint32_t rays_per_block = 64;  ///< 32..1024, a multiple of 32: reports name blocks by it
    bool culls = false;                 ///< a ray that has a hit need not be pushed on behind it
    bool any_hit = false;               ///< shadow queries ask only whether something is hit
    std::string scene = "scene";
};

/// A copy of `count` records in the host's memory; of a device's memory too where CUDA is there.
template <class Record>
std::vector<Record> to_host(const Record* records, std::size_t count) {
    std::vector<Record> out(count);
    if (count == 0) return out;
#if defined(__CUDACC__) || defined(SCOTTY_CAPTURE_CUDA)
    const cudaError_t error =
        cudaMemcpy(out.data(), records, count * sizeof(Record), cudaMemcpyDefault);
    if (error != cudaSuccess) throw Error("cudaMemcpy", cudaGetErrorString(error));
#else
    std::copy_n(records, count, out.begin());
#endif
    return out;
}

/// One traversal: rays from somewhere, the queues that they went through, the hits that they found.
/// Records are the caller's own; what reads them is a pointer to a member or a function.
class Query {
 public:
    static constexpr std::size_t kAsManyAsThereAre = ~std::size_t{0};

    Query(std::uint32_t bounce, std::uint32_t light) : bounce_(bounce), light_(light) {}

    /// Each ray once; more calls add more. `to_ray(record)` is a Ray.
    template <class Record, class ToRay>
    void rays(const Record* records, std::size_t count, ToRay to_ray) {
        for (const Record& record : to_host(records, count)) ray(std::invoke(to_ray, record));
    }
    void ray(const Ray& ray) {
        if (!numbers_.emplace(ray.id, static_cast<std::uint32_t>(rays_.size())).second) {
            throw Error("ray " + std::to_string(ray.id), "is given twice");
        }
        rays_.push_back(ray);
    }
    /// The rays that wait at a node, once for each node, empty queues too: a node without is not
    /// judged. `count` is what the queue's counter says, `capacity` how many it has room for.
    template <class Record, class ToId>
    void queue(NodeId node, const Record* records, std::size_t count, ToId to_id,
               std::size_t capacity = kAsManyAsThereAre) {
        Queue queue{count, {}};
        for (const Record& record : to_host(records, std::min(count, capacity))) {
            queue.rays.push_back(static_cast<RayId>(std::invoke(to_id, record)));
        }
        if (!queues_.emplace(node, std::move(queue)).second) {
            throw Error("queue of node " + std::to_string(node), "is given twice");
        }
    }
    /// All that one ray has gathered in leaves, in any order. `to_hit(record)` is a Hit.
    template <class Record, class ToHit>
    void hits(RayId ray, const Record* records, std::size_t count, ToHit to_hit,
              std::size_t capacity = kAsManyAsThereAre) {
        Gathered gathered{count, {}};
        for (const Record& record : to_host(records, std::min(count, capacity))) {
            gathered.hits.push_back(std::invoke(to_hit, record));
        }
        if (!hits_.emplace(ray, std::move(gathered)).second) {
            throw Error("hits of ray " + std::to_string(ray), "are given twice");
        }
    }
    /// What the traversal has answered. `to_hit(record)` is a Hit that names its ray.
    template <class Record, class ToHit>
    void closest(const Record* records, std::size_t count, ToHit to_hit) {
        for (const Record& record : to_host(records, count)) closest(std::invoke(to_hit, record));
    }
    void closest(const Hit& hit) {
        if (!closest_.emplace(hit.ray, hit).second) {
            throw Error("the closest hit of ray " + std::to_string(hit.ray), "is given twice");
        }
    }

 private:
    friend class Writer;
    struct Queue {
        std::size_t count;  ///< as its counter says
        std::vector<RayId> rays;
    };
    struct Gathered {
        std::size_t count;
        std::vector<Hit> hits;
    };

    std::uint32_t bounce_, light_;
    std::vector<Ray> rays_;
    std::unordered_map<RayId, std::uint32_t> numbers_;  ///< the rays' positions
    std::unordered_map<NodeId, Queue> queues_;
    std::unordered_map<RayId, Gathered> hits_;
    std::unordered_map<RayId, Hit> closest_;
};

class Writer {
 public:
    /// `pipeline`: a name for reports. Nothing is at `directory` before finish().
    Writer(const std::filesystem::path& directory, std::string pipeline, Settings settings = {})
        : directory_(directory), settings_(std::move(settings)) {
        index_.backend = std::move(pipeline);
        index_.foreign = true;
        const std::uint32_t threads = settings_.rays_per_block;
        if (threads < 32 || threads > 1024 || threads % 32 != 0) {
            throw Error("rays_per_block",
                        std::to_string(threads) + " is no multiple of 32 up to 1024");
        }
        std::filesystem::create_directories(directory_.path() / "buffers");
    }

    void triangle(const Point& a, const Point& b, const Point& c) {
        for (const Point& corner : {a, b, c}) corners_.push_back(corner);
    }
    /// A node with 1 to 16 children. Their order is their order in the node.
    void inner(NodeId id, std::vector<Child> children) {
        if (children.empty() || children.size() > 16) fail(id, "has no children, or more than 16");
        add(id, {std::move(children), {}});
    }
    void leaf(NodeId id, std::vector<std::uint32_t> primitives) {
        if (primitives.empty()) fail(id, "is a leaf without primitives");
        add(id, {{}, std::move(primitives)});
    }

    /// A traversal of paths' rays, or of those that look for a light. The reference stays valid.
    Query& query(std::uint32_t bounce = 0) { return shadow_query(bounce, kNothing); }
    Query& shadow_query(std::uint32_t bounce, std::uint32_t light) {
        for (const Query& other : queries_) {
            if (other.bounce_ == bounce && other.light_ == light) {
                throw Error("bounce " + std::to_string(bounce), "has that query already");
            }
        }
        return queries_.emplace_back(bounce, light);
    }

    /// Lays everything out as captures do, and moves the finished capture to its place.
    void finish() {
        lay_out_tree();
        write_input();
        for (const Query& query : queries_) write_query(query);
        write_file(directory_.path() / "index.json", text_of(index_));
        directory_.finish();
    }

 private:
    using Words = std::vector<std::uint32_t>;
    struct Node {
        std::vector<Child> children;
        Words primitives;
    };
    /// A part of a buffer, whose first elements are used, in any order.
    struct Region {
        std::size_t begin, used, claimed;
    };
    using Regions = std::vector<Region>;
    /// The queues of a level, laid out one after the other.
    struct Level {
        Words counts, offsets{0}, blocks{0}, queue, given;
        Regions regions;
        std::size_t queues = 0;  ///< that were given
    };

    [[noreturn]] static void fail(NodeId id, const std::string& what) {
        throw Error("node " + std::to_string(id), what);
    }
    void add(NodeId id, Node node) {
        if (!nodes_.emplace(id, std::move(node)).second) fail(id, "is given twice");
    }

    NodeId find_root() const {
        std::unordered_map<NodeId, NodeId> parents;
        for (const auto& [id, node] : nodes_) {
            for (const Child& child : node.children) {
                if (nodes_.count(child.id) == 0) fail(child.id, "is a child, but is not given");
                if (!parents.emplace(child.id, id).second) fail(child.id, "has two parents");
            }
        }
        std::optional<NodeId> root;
        for (const auto& [id, node] : nodes_) {
            if (parents.count(id) != 0) continue;
            if (root) fail(id, "is nobody's child, and so is node " + std::to_string(*root));
            root = id;
        }
        if (!root) throw Error("the tree", "has no root: every node is a child, or there is none");
        if (nodes_.at(*root).children.empty()) fail(*root, "is the root, and a leaf");
        return *root;
    }

    /// Breadth first: a level is a range of positions, and the children of a node are neighbours.
    void lay_out_tree() {
        order_ = {find_root()};
        parents_ = {kNothing};
        level_begins_ = {0};
        std::size_t widest = 2;
        for (std::size_t at = 0; at < order_.size();) {
            const std::size_t end = order_.size();
            level_begins_.push_back(static_cast<std::uint32_t>(end));
            for (; at < end; ++at) {
                const Node& node = nodes_.at(order_[at]);
                widest = std::max(widest, node.children.size());
                for (const Child& child : node.children) {
                    order_.push_back(child.id);
                    parents_.push_back(static_cast<std::uint32_t>(at));
                }
            }
        }
        if (order_.size() != nodes_.size()) throw Error("the tree", "has a circle");
        for (std::size_t i = 0; i < order_.size(); ++i) {
            positions_[order_[i]] = static_cast<std::uint32_t>(i);
        }
        for (index_.width = 2; static_cast<std::size_t>(index_.width) < widest;) index_.width *= 2;
        index_.levels = static_cast<std::uint32_t>(level_begins_.size() - 1);
    }

    void write_input() {
        const auto width = static_cast<std::size_t>(index_.width);
        std::vector<float> boxes, bounds;
        Words children, leaves, triangles, refs;
        std::size_t largest = 1;
        std::uint32_t inner = 0;
        for (const NodeId id : order_) {
            const Node& node = nodes_.at(id);
            if (node.children.empty()) {
                refs.push_back(0x80000000u | static_cast<std::uint32_t>(leaves.size() / 2));
                leaves.push_back(static_cast<std::uint32_t>(triangles.size() / 10));
                leaves.push_back(static_cast<std::uint32_t>(node.primitives.size()));
                largest = std::max(largest, node.primitives.size());
                for (const std::uint32_t primitive : node.primitives) {
                    if (primitive >= corners_.size() / 3) {
                        fail(id, "has primitive " + std::to_string(primitive) + " of " +
                                     std::to_string(corners_.size() / 3));
                    }
                    triangles.resize(triangles.size() + 9);
                    std::memcpy(&triangles[triangles.size() - 9], &corners_[3 * primitive], 36);
                    triangles.push_back(primitive);
                }
                continue;
            }
            refs.push_back(inner++);
            for (std::size_t side = 0; side < 6; ++side) {
                float outer = side < 3 ? kInfinity : -kInfinity;
                const std::size_t row = boxes.size();
                boxes.resize(row + width, outer);
                for (std::size_t i = 0; i < node.children.size(); ++i) {
                    const Child& child = node.children[i];
                    const float plane = side < 3 ? child.low[side] : child.high[side - 3];
                    boxes[row + i] = plane;
                    outer = side < 3 ? std::min(outer, plane) : std::max(outer, plane);
                }
                bounds.push_back(outer);
            }
            for (std::size_t i = 0; i < width; ++i) {
                const bool used = i < node.children.size();
                children.push_back(used ? positions_.at(node.children[i].id) : kNothing);
            }
        }
        if (largest > 1024) throw Error("the tree", "has a leaf of more than 1024 triangles");
        const std::size_t count = corners_.size() / 3;
        Words corners(3 * count);
        for (std::size_t i = 0; i < corners.size(); ++i) corners[i] = static_cast<std::uint32_t>(i);
        index_.scene = index_.source = settings_.scene;
        index_.culls = settings_.culls;
        index_.parameters = {{"width", std::to_string(width)},
                             {"rays_per_block", std::to_string(settings_.rays_per_block)},
                             {"max_leaf_size", std::to_string(largest)},
                             {"early_out", "\"off\""},
                             {"shadow_query", settings_.any_hit ? "\"any\"" : "\"closest\""}};
        InputFolder input(directory_.path() / "input");
        const auto words = [&](const char* name, const Words& data, std::size_t columns,
                               const char* meaning) {
            std::vector<std::size_t> shape{data.size() / columns, columns};
            if (columns == 1) shape.pop_back();
            input.add(name, Type::uint32, shape, data.data(), meaning);
        };
        input.add("vertices", Type::float32, {3 * count, 3}, corners_.data(), "positions");
        input.add("normals", Type::float32, {0, 3}, nullptr, "none");
        words("triangles", corners, 3, "vertex indices");
        words("material_of", Words(count, 0), 1, "by triangle");
        const std::array<float, 12> grey{0, .5f, .5f, .5f, 0, 0, 0, 1};
        const std::array<float, 14> camera{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -1, .5f};
        input.add("materials", Type::float32, {1, 12}, grey.data(), "none: a stand-in");
        input.add("lights", Type::float32, {0, 17}, nullptr, "none");
        input.add("camera", Type::float32, {1, 14}, camera.data(), "none: a stand-in");
        input.add("bvh_boxes", Type::float32, {inner, 6, width}, boxes.data(), "children's boxes");
        words("bvh_children", children, width, "node ids");
        input.add("bvh_bounds", Type::float32, {inner, 6}, bounds.data(), "nodes' boxes");
        words("bvh_leaves", leaves, 2, "first and count into bvh_triangles");
        words("bvh_triangles", triangles, 10, "in leaf order: v0, v1, v2 as bits, primitive");
        words("bvh_node_refs", refs, 1, "by node id: 0x80000000 | leaf, or inner node");
        words("bvh_parents", parents_, 1, "by node id");
        words("bvh_level_begins", level_begins_, 1, "level l is [begins[l], begins[l + 1])");
        input.add("node_ids", Type::uint64, {order_.size()}, order_.data(), "the program's own");
        input.finish(index_, {});
    }

    StoredBuffer store(const char* name, Type type, std::vector<std::size_t> shape,
                       const void* data, const char* meaning, const char* order = "ordered",
                       const Regions& regions = {}) {
        StoredBuffer buffer{name, type, std::move(shape), meaning, order, "", "", ""};
        std::size_t bytes = size_of(type);
        for (const std::size_t size : buffer.shape) bytes *= size;
        buffer.hash = buffer.canonical_hash = hash_text(data, bytes);
        if (!regions.empty()) buffer.canonical_hash = canonical_hash(data, order, regions);
        buffer.file = file_of(buffer);
        const std::filesystem::path file = directory_.path() / buffer.file;
        if (!std::filesystem::exists(file)) {
            write_file(file, npy_header(type, buffer.shape), data, bytes);
        }
        return buffer;
    }
    StoredBuffer store(const char* name, const Words& words, const char* meaning,
                       const char* order = "ordered", const Regions& regions = {}) {
        return store(name, Type::uint32, {words.size()}, words.data(), meaning, order, regions);
    }
    /// Of each region what its counter says and the elements in use, sorted.
    static std::string canonical_hash(const void* data, const std::string& order,
                                      const Regions& regions) {
        const auto* words = static_cast<const std::uint32_t*>(data);
        const bool pairs = order == "hit_list";
        std::vector<std::uint64_t> all, some;
        for (const Region& region : regions) {
            some.clear();
            for (std::size_t i = region.begin; i < region.begin + region.used; ++i) {
                some.push_back(pairs ? std::uint64_t{words[2 * i]} << 32 | words[2 * i + 1]
                                     : words[i]);
            }
            std::sort(some.begin(), some.end());
            all.push_back(region.claimed);
            all.insert(all.end(), some.begin(), some.end());
        }
        return hash_text(all.data(), all.size() * sizeof all[0]);
    }

    /// Entries that are no ray's id get numbers behind the rays, so that reports can name them.
    Level level_of(const Query& query, std::uint32_t level,
                   std::unordered_map<RayId, std::uint32_t>& numbers, std::vector<RayId>& ids) {
        Level out;
        for (std::uint32_t node = level_begins_[level]; node < level_begins_[level + 1]; ++node) {
            const auto found = query.queues_.find(order_[node]);
            const bool given = found != query.queues_.end();
            const std::size_t count = given ? found->second.count : 0;
            out.queues += given ? 1 : 0;
            out.given.push_back(given ? 1 : 0);
            out.counts.push_back(static_cast<std::uint32_t>(count));
            const std::size_t begin = out.queue.size();
            if (given) {
                for (const RayId ray : found->second.rays) {
                    const auto next = static_cast<std::uint32_t>(ids.size());
                    const auto [known, is_new] = numbers.emplace(ray, next);
                    if (is_new) ids.push_back(ray);
                    out.queue.push_back(known->second);
                }
            }
            out.regions.push_back({begin, out.queue.size() - begin, count});
            out.offsets.push_back(static_cast<std::uint32_t>(out.queue.size()));
            const std::size_t threads = settings_.rays_per_block;
            out.blocks.push_back(
                out.blocks.back() +
                static_cast<std::uint32_t>((out.queue.size() - begin + threads - 1) / threads));
        }
        return out;
    }

    void write_query(const Query& query) {
        const std::size_t n = query.rays_.size();
        if (n == 0) throw Error("bounce " + std::to_string(query.bounce_), "has no rays");
        for (const auto& [node, queue] : query.queues_) {
            if (positions_.count(node) == 0) fail(node, "has a queue, but is not in the tree");
        }
        std::string prefix = "bounce" + std::to_string(query.bounce_) + "/";
        if (query.light_ != kNothing) prefix += "light" + std::to_string(query.light_) + "/";
        std::vector<RayId> ids;
        std::vector<float> rays;
        for (const Ray& r : query.rays_) {
            ids.push_back(r.id);
            rays.insert(rays.end(), {r.origin[0], r.origin[1], r.origin[2], r.t_min});
            rays.insert(rays.end(), {r.direction[0], r.direction[1], r.direction[2], r.t_max});
        }
        std::unordered_map<RayId, std::uint32_t> numbers = query.numbers_;
        std::vector<Level> levels;
        for (std::uint32_t l = 0; l < index_.levels; ++l) {
            levels.push_back(level_of(query, l, numbers, ids));
        }
        const std::vector<StoredBuffer> all{
            store("rays", Type::float32, {n, 8}, rays.data(), "origin, t_min, direction, t_max"),
            store("ray_ids", Type::uint64, {ids.size()}, ids.data(), "the program's own")};
        const auto stage = [&](const std::string& name, const char* kind, std::uint32_t level) {
            Stage out;
            out.name = prefix + name + kind;
            out.kind = kind;
            out.launch = static_cast<std::uint32_t>(index_.stages.size());
            out.bounce = query.bounce_;
            out.light = query.light_;
            out.level = level;
            out.threads = settings_.rays_per_block;
            out.inputs = all;
            return out;
        };
        for (std::uint32_t l = 0; l < index_.levels; ++l) {
            const Level& level = levels[l];
            if (level.queues == 0 && l != 0) continue;
            Stage out = stage("level" + std::to_string(l) + "/",
                              l == 0 ? "intersect_root" : "intersect", l);
            out.blocks = level.blocks.back();
            out.inputs.push_back(store("node_counts", level.counts, "queue length by node"));
            out.inputs.push_back(store("queue_offsets", level.offsets, "first queue slot by node"));
            out.inputs.push_back(store("block_offsets", level.blocks, "first block by node"));
            out.inputs.push_back(store("queue", level.queue, "ray ids", "queue", level.regions));
            out.inputs.push_back(store("queue_given", level.given, "1: the queue is given"));
            if (l + 1 < index_.levels && levels[l + 1].queues != 0) {
                const Level& next = levels[l + 1];
                out.inputs.push_back(
                    store("child_offsets", next.offsets, "first queue slot by child node"));
                out.outputs.push_back(store("child_counts", next.counts, "queue length by child"));
                out.outputs.push_back(
                    store("child_queue", next.queue, "ray ids", "queue", next.regions));
                out.outputs.push_back(
                    store("child_queue_given", next.given, "1: the queue is given"));
            }
            index_.stages.push_back(std::move(out));
        }
        if (query.hits_.empty() && query.closest_.empty()) return;
        Stage merge = stage("", "merge_intersections", kNothing);
        if (!query.hits_.empty()) add_hits(query, merge);
        if (!query.closest_.empty()) add_closest(query, merge);
        index_.stages.push_back(std::move(merge));
    }

    static void expect_ray(const Query& query, RayId ray) {
        if (query.numbers_.count(ray) == 0) {
            throw Error("ray " + std::to_string(ray), "has hits, but is none of the query's rays");
        }
    }

    void add_hits(const Query& query, Stage& merge) {
        const std::size_t n = query.rays_.size();
        std::size_t slots = 1;
        for (const auto& [ray, gathered] : query.hits_) {
            expect_ray(query, ray);
            slots = std::max(slots, gathered.hits.size());
        }
        Words counts(n, 0), given(n, 0), pairs(2 * n * slots, kNothing);
        Regions regions(n);
        for (std::size_t r = 0; r < n; ++r) {
            const auto found = query.hits_.find(query.rays_[r].id);
            regions[r] = {r * slots, 0, 0};
            for (std::size_t s = 0; s < slots; ++s) put(pairs, 2 * (r * slots + s), Hit{});
            if (found == query.hits_.end()) continue;
            const auto& gathered = found->second;
            given[r] = 1;
            counts[r] = static_cast<std::uint32_t>(gathered.count);
            regions[r] = {r * slots, gathered.hits.size(), gathered.count};
            for (std::size_t s = 0; s < gathered.hits.size(); ++s) {
                put(pairs, 2 * (r * slots + s), gathered.hits[s]);
            }
        }
        merge.inputs.push_back(store("hit_counts", counts, "hits gathered by ray"));
        merge.inputs.push_back(store("hits", Type::uint32, {n, slots, 2}, pairs.data(),
                                     "t, primitive", "hit_list", regions));
        merge.inputs.push_back(store("hits_given", given, "1: the hits are given"));
    }

    void add_closest(const Query& query, Stage& merge) {
        const std::size_t n = query.rays_.size();
        Words merged(4 * n, 0), given(n, 0);
        for (std::size_t r = 0; r < n; ++r) put(merged, 4 * r, Hit{});
        for (const auto& [ray, hit] : query.closest_) {
            expect_ray(query, ray);
            const std::uint32_t number = query.numbers_.at(ray);
            put(merged, 4 * std::size_t{number}, hit);
            given[number] = 1;
        }
        merge.outputs.push_back(store("merged", Type::uint32, {n, 4}, merged.data(),
                                      "closest hit: t, primitive; u, v are not given"));
        merge.outputs.push_back(store("merged_given", given, "1: the hit is given"));
    }
    static void put(Words& words, std::size_t at, const Hit& hit) {
        std::memcpy(&words[at], &hit.t, sizeof hit.t);
        words[at + 1] = hit.primitive;
    }

    Directory directory_;
    Settings settings_;
    Index index_;
    std::vector<Point> corners_;
    std::unordered_map<NodeId, Node> nodes_;
    std::deque<Query> queries_;
    std::vector<NodeId> order_;  ///< breadth first
    std::unordered_map<NodeId, std::uint32_t> positions_;
    Words parents_, level_begins_;
};

}  // namespace SCOTTY_CAPTURE_MEMORY
}  // namespace scotty::capture
