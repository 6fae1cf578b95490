// A breadth-first ray tracer of its own, in the style of the code of 2018: whole ray records in
// queues, one queue with a fixed capacity for each node, nodes numbered depth first, ray ids with
// gaps, and 16 slots a ray for hits. It shares no line with CUDA-Scotty but the header that writes
// its capture.
//
//     pipeline sound DIRECTORY [overflow DIRECTORY] [box DIRECTORY]
//
// writes a capture, and others with one of two faults of that code.
#include <scotty/capture_writer.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

constexpr int kWidth = 4, kThreads = 64, kLeafSize = 4;
constexpr int kImage = 16, kRays = kImage * kImage, kQueue = kRays, kSlots = 16;
constexpr float kFar = 1e30f;

struct Vector {
    float x, y, z;
};
struct RayRecord {
    Vector origin, direction, weight;
    int slot, id;
    float unused[7];
};
struct Intersection {
    float t, u, v;
    int triangle;
};
struct Node {
    Vector low[kWidth], high[kWidth];
    int child[kWidth];  // -1: none
    int first, count;   // triangles of a leaf
};
struct Triangle {
    Vector a, b, c;
    int number;
};

__host__ __device__ inline Vector operator-(Vector a, Vector b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
__host__ __device__ inline float dot(Vector a, Vector b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
__host__ __device__ inline Vector cross(Vector a, Vector b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Where a ray enters a box; kFar where it does not.
__device__ float enter_box(const RayRecord& ray, Vector low, Vector high) {
    float near = 0.0f, far = kFar;
    const float from[3] = {ray.origin.x, ray.origin.y, ray.origin.z};
    const float along[3] = {ray.direction.x, ray.direction.y, ray.direction.z};
    const float least[3] = {low.x, low.y, low.z}, most[3] = {high.x, high.y, high.z};
    for (int axis = 0; axis < 3; ++axis) {
        const float a = (least[axis] - from[axis]) / along[axis];
        const float b = (most[axis] - from[axis]) / along[axis];
        near = fmaxf(near, fminf(a, b));
        far = fminf(far, fmaxf(a, b));
    }
    return near <= far ? near : kFar;
}

// Moeller and Trumbore's test; t is kFar where the ray misses.
__device__ Intersection hit_triangle(const RayRecord& ray, const Triangle& triangle) {
    const Vector ab = triangle.b - triangle.a, ac = triangle.c - triangle.a,
                 from = ray.origin - triangle.a;
    const Vector p = cross(ray.direction, ac), q = cross(from, ab);
    const float scale = 1.0f / dot(ab, p);
    const float u = dot(from, p) * scale, v = dot(ray.direction, q) * scale, t = dot(ac, q) * scale;
    const bool inside = u >= 0.0f && v >= 0.0f && u + v <= 1.0f && t > 0.0f;
    return {inside ? t : kFar, u, v, triangle.number};
}

__device__ float minimum_of(int* minimum, int slot) {
    return __int_as_float(atomicAdd(&minimum[slot], 0));
}

__global__ void primary_rays(RayRecord* queue, int* count, int* minimum) {
    const int pixel = blockIdx.x * blockDim.x + threadIdx.x;
    if (pixel >= kRays) return;
    const float x = (pixel % kImage + 0.53f) / kImage * 2.0f - 1.0f,
                y = (pixel / kImage + 0.47f) / kImage * 2.0f - 1.0f;
    minimum[pixel] = __float_as_int(kFar);
    if (x * x + y * y > 0.9f) return;  // a round image: not every pixel has a ray
    RayRecord& ray = queue[atomicAdd(count, 1)];
    ray.origin = {0.0f, 0.0f, -4.0f};
    ray.direction = {x * 0.4f, y * 0.4f, 1.0f};
    ray.weight = {1.0f, 1.0f, 1.0f};
    ray.slot = pixel;
    ray.id = 5000 + 8 * pixel;
}

// One level: block y has a node, block x kThreads of its rays.
__global__ void intersect(const Node* nodes, const Triangle* triangles, const int* level,
                          RayRecord* queues, int* counts, int* minimum, Intersection* hits,
                          int* hit_counts, int slots, bool box_distance) {
    __shared__ Node node;
    __shared__ Triangle local[kLeafSize];
    __shared__ int marks[kThreads], base;
    const int id = level[blockIdx.y], lane = threadIdx.x;
    const int count = counts[id], first = blockIdx.x * kThreads;
    if (first >= count) return;
    if (lane == 0) node = nodes[id];
    __syncthreads();
    if (lane < node.count) local[lane] = triangles[node.first + lane];
    __syncthreads();
    const bool has_ray = first + lane < count;
    RayRecord ray;
    if (has_ray) ray = queues[id * kQueue + first + lane];
    if (node.count != 0) {
        if (!has_ray) return;
        Intersection nearest = {kFar, 0.0f, 0.0f, -1};
        for (int i = 0; i < node.count; ++i) {
            const Intersection hit = hit_triangle(ray, local[i]);
            if (hit.t < nearest.t) nearest = hit;
        }
        if (nearest.t == kFar || nearest.t > minimum_of(minimum, ray.slot)) return;
        atomicMin(&minimum[ray.slot], __float_as_int(nearest.t));
        const int token = atomicAdd(&hit_counts[ray.slot], 1);
        hits[ray.slot * slots + token] = nearest;
        return;
    }
    for (int c = 0; c < kWidth && node.child[c] >= 0; ++c) {
        const float entry = has_ray ? enter_box(ray, node.low[c], node.high[c]) : kFar;
        const bool enters = entry < kFar && entry <= minimum_of(minimum, ray.slot);
        if (enters && box_distance && nodes[node.child[c]].count != 0) {
            atomicMin(&minimum[ray.slot], __float_as_int(entry));  // the fault: a box is no hit
        }
        marks[lane] = enters ? 1 : 0;
        for (int step = 1; step < kThreads; step *= 2) {  // an inclusive scan
            __syncthreads();
            const int before = lane >= step ? marks[lane - step] : 0;
            __syncthreads();
            marks[lane] += before;
        }
        __syncthreads();
        if (lane == kThreads - 1) base = atomicAdd(&counts[node.child[c]], marks[lane]);
        __syncthreads();
        if (enters) queues[node.child[c] * kQueue + base + marks[lane] - 1] = ray;
        __syncthreads();
    }
}

__global__ void merge(const Intersection* hits, const int* hit_counts, int slots,
                      Intersection* closest) {
    const int ray = blockIdx.x * blockDim.x + threadIdx.x;
    if (ray >= kRays) return;
    Intersection nearest = {kFar, 0.0f, 0.0f, -1};
    for (int i = 0; i < hit_counts[ray] && i < slots; ++i) {
        if (hits[ray * slots + i].t < nearest.t) nearest = hits[ray * slots + i];
    }
    closest[ray] = nearest;
}

// The tree, on the host: each range of triangles is halved twice, nodes are numbered as they are
// met, depth first.
struct Tree {
    std::vector<Triangle> triangles;
    std::vector<Node> nodes;
    std::vector<std::vector<int>> levels;

    int add(int first, int count, size_t level, Vector* low, Vector* high) {
        const int id = static_cast<int>(nodes.size());
        nodes.push_back(Node{});
        if (levels.size() <= level) levels.emplace_back();
        levels[level].push_back(id);
        *low = {kFar, kFar, kFar};
        *high = {-kFar, -kFar, -kFar};
        Node node = {};
        for (int& child : node.child) child = -1;
        if (count <= kLeafSize) {
            node.first = first;
            node.count = count;
            for (int i = first; i < first + count; ++i) {
                for (const Vector& v : {triangles[i].a, triangles[i].b, triangles[i].c})
                    include(v, v, low, high);
            }
        }
        for (int c = 0, used = 0; c < kWidth && count > kLeafSize; ++c) {
            const int begin = count * c / kWidth, end = count * (c + 1) / kWidth;
            if (begin == end) continue;
            node.child[used] =
                add(first + begin, end - begin, level + 1, &node.low[used], &node.high[used]);
            include(node.low[used], node.high[used], low, high);
            ++used;
        }
        nodes[id] = node;
        return id;
    }
    static void include(Vector a, Vector b, Vector* low, Vector* high) {
        *low = {fminf(low->x, a.x), fminf(low->y, a.y), fminf(low->z, a.z)};
        *high = {fmaxf(high->x, b.x), fmaxf(high->y, b.y), fmaxf(high->z, b.z)};
    }
};

// Three curtains of tilted tiles, one in front of the other: a ray meets the farthest first.
std::vector<Triangle> make_scene() {
    std::vector<Triangle> triangles;
    for (int layer = 0; layer < 3; ++layer) {
        for (int tile = 0; tile < 36; ++tile) {
            const float x = (tile % 6 - 3) * 0.6f + 0.07f * layer, y = (tile / 6 - 3) * 0.6f,
                        z = (2 - layer) * 1.5f + 0.1f * (tile % 5);
            const Vector a = {x, y, z}, b = {x + 0.55f, y, z + 0.2f},
                         c = {x + 0.55f, y + 0.55f, z + 0.3f}, d = {x, y + 0.55f, z};
            const int number = static_cast<int>(triangles.size());
            triangles.push_back({a, b, c, number});
            triangles.push_back({a, c, d, number + 1});
        }
    }
    return triangles;
}

template <class T>
T* on_device(size_t count, const T* from = nullptr) {
    T* memory = nullptr;
    cudaMalloc(&memory, count * sizeof(T));
    if (from != nullptr) cudaMemcpy(memory, from, count * sizeof(T), cudaMemcpyHostToDevice);
    if (from == nullptr) cudaMemset(memory, 0, count * sizeof(T));
    return memory;
}

namespace capture = scotty::capture;

capture::Point point(Vector v) { return {v.x, v.y, v.z}; }

void describe(capture::Writer& writer, const Tree& tree) {
    std::vector<Triangle> by_number(tree.triangles.size());
    for (const Triangle& triangle : tree.triangles) by_number[triangle.number] = triangle;
    for (const Triangle& t : by_number) writer.triangle(point(t.a), point(t.b), point(t.c));
    for (size_t id = 0; id < tree.nodes.size(); ++id) {
        const Node& node = tree.nodes[id];
        std::vector<capture::Child> children;
        for (int c = 0; c < kWidth && node.child[c] >= 0; ++c) {
            children.push_back({static_cast<capture::NodeId>(node.child[c]), point(node.low[c]),
                                point(node.high[c])});
        }
        std::vector<std::uint32_t> primitives;
        for (int i = node.first; i < node.first + node.count; ++i)
            primitives.push_back(tree.triangles[i].number);
        if (node.count != 0) writer.leaf(id, primitives);
        if (node.count == 0) writer.inner(id, children);
    }
}

bool run(const std::string& fault, const std::string& directory) {
    const int slots = fault == "overflow"
                          ? 2
                          : kSlots;  // the fault: nobody asks whether a token is below the capacity

    Tree tree;
    tree.triangles = make_scene();
    Vector low, high;
    tree.add(0, static_cast<int>(tree.triangles.size()), 0, &low, &high);
    const size_t nodes = tree.nodes.size();

    capture::Settings settings;
    settings.culls = true;
    settings.rays_per_block = kThreads;
    settings.scene = "curtains";
    capture::Writer writer(directory, "pipeline of 2018", settings);
    describe(writer, tree);

    Node* device_nodes = on_device(nodes, tree.nodes.data());
    Triangle* device_triangles = on_device(tree.triangles.size(), tree.triangles.data());
    RayRecord* queues = on_device<RayRecord>(nodes * kQueue);
    int* counts = on_device<int>(nodes);
    int* minimum = on_device<int>(kRays);
    Intersection* hits = on_device<Intersection>(kRays * kSlots);
    int* hit_counts = on_device<int>(kRays);
    Intersection* closest = on_device<Intersection>(kRays);

    primary_rays<<<kRays / kThreads, kThreads>>>(queues, counts, minimum);
    for (const std::vector<int>& level : tree.levels) {
        int* device_level = on_device(level.size(), level.data());
        const dim3 grid(kRays / kThreads, static_cast<unsigned>(level.size()));
        intersect<<<grid, kThreads>>>(device_nodes, device_triangles, device_level, queues, counts,
                                      minimum, hits, hit_counts, slots, fault == "box");
        cudaFree(device_level);
    }
    merge<<<kRays / kThreads, kThreads>>>(hits, hit_counts, slots, closest);
    if (cudaDeviceSynchronize() != cudaSuccess) return false;

    // The capture: buffers stay where they are, on the device.
    std::vector<int> lengths = capture::to_host(counts, nodes);
    capture::Query& query = writer.query();
    query.rays(queues, lengths[0], [](const RayRecord& ray) {
        return capture::Ray{static_cast<capture::RayId>(ray.id), point(ray.origin),
                            point(ray.direction)};
    });
    for (size_t id = 0; id < nodes; ++id)
        query.queue(id, queues + id * kQueue, lengths[id], &RayRecord::id, kQueue);
    const std::vector<int> tokens = capture::to_host(hit_counts, kRays);
    const std::vector<Intersection> answers = capture::to_host(closest, kRays);
    const auto hit_of = [](const Intersection& hit) {
        return hit.triangle < 0 ? capture::Hit{}
                                : capture::Hit{hit.t, static_cast<std::uint32_t>(hit.triangle)};
    };
    for (const RayRecord& ray : capture::to_host(queues, lengths[0])) {
        query.hits(ray.id, hits + ray.slot * slots, tokens[ray.slot], hit_of, slots);
        capture::Hit answer = hit_of(answers[ray.slot]);
        answer.ray = ray.id;
        query.closest(answer);
    }
    writer.finish();
    std::printf("%s: %d rays, %zu nodes in %zu levels\n", directory.c_str(), lengths[0], nodes,
                tree.levels.size());

    cudaFree(device_nodes);
    cudaFree(device_triangles);
    cudaFree(queues);
    cudaFree(counts);
    cudaFree(minimum);
    cudaFree(hits);
    cudaFree(hit_counts);
    cudaFree(closest);
    return true;
}

int main(int count, char** words) {
    for (int i = 1; i + 1 < count; i += 2) {
        if (!run(words[i], words[i + 1])) return 1;
    }
    return count > 2 ? 0 : 2;
}
