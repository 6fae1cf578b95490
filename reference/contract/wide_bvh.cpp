#include "reference/contract/wide_bvh.h"

#include <xxhash.h>

#include <algorithm>
#include <cstddef>

namespace scotty::reference {
namespace {

template <typename T>
std::size_t bytes_of(const std::vector<T>& values) {
    return values.size() * sizeof(T);
}

/// A streaming hash; lengths are hashed too, so that no two layouts run into each other.
class BvhHasher {
 public:
    BvhHasher() : state_(XXH3_createState()) { XXH3_64bits_reset(state_); }
    ~BvhHasher() { XXH3_freeState(state_); }
    BvhHasher(const BvhHasher&) = delete;
    BvhHasher& operator=(const BvhHasher&) = delete;

    void add(const void* data, std::size_t bytes) { XXH3_64bits_update(state_, data, bytes); }
    template <typename T>
    void add_all(const std::vector<T>& values) {
        const std::uint64_t size = values.size();
        add(&size, sizeof size);
        add(values.data(), bytes_of(values));
    }
    std::uint64_t digest() const { return XXH3_64bits_digest(state_); }

 private:
    XXH3_state_t* state_;
};

/// A node's last field is followed by padding, which is nobody's.
template <int Width>
constexpr std::size_t kBytesOfFields = offsetof(WideNode<Width>, high) + sizeof(float[3]);

template <int Width>
void add_inner(BvhHasher& hasher, const std::vector<WideNode<Width>>& inner) {
    const std::uint64_t size = inner.size();
    hasher.add(&size, sizeof size);
    for (const WideNode<Width>& node : inner) hasher.add(&node, kBytesOfFields<Width>);
}

/// All levels again: ids are breadth-first, so that each level ends where its parents do.
void restore_levels(WideBvh& bvh) {
    std::vector<std::uint32_t>& begins = bvh.level_begins;
    std::uint32_t end = begins.back();
    while (end < bvh.node_count()) {
        const std::uint32_t parents_end = end;
        while (end < bvh.node_count() && bvh.parents[end] < parents_end) ++end;
        if (end == parents_end) return;  // no valid tree: validate() says so
        begins.push_back(end);
    }
}

}  // namespace

std::uint32_t WideBvh::inner_count() const {
    return std::visit([](const auto& nodes) { return static_cast<std::uint32_t>(nodes.size()); },
                      inner);
}

BvhParameters bvh_parameters(const PipelineParameters& p, std::size_t threads) {
    return {p.width, p.max_leaf_size, threads, p.queue_levels};
}

void cut_levels(WideBvh& bvh, std::uint32_t queue_levels) {
    restore_levels(bvh);
    if (queue_levels == 0) return;
    const std::uint32_t levels = bvh.level_count();
    // An inner node leaves Width - 1 others waiting; the lowest level has leaves only.
    const std::uint32_t depth = kSubtreeStack / static_cast<std::uint32_t>(bvh.width - 1);
    const std::uint32_t least = levels > depth ? levels - depth : 0;
    const std::uint32_t kept = std::max(queue_levels, least);
    if (kept < levels) bvh.level_begins.resize(kept + 1);
}

std::vector<std::uint32_t> inner_begins(const WideBvh& bvh) {
    std::vector<std::uint32_t> begins{0};
    for (std::uint32_t level = 0; level < bvh.level_count(); ++level) {
        const auto nodes = bvh.node_refs.begin();
        begins.push_back(begins.back() +
                         static_cast<std::uint32_t>(std::count_if(
                             nodes + bvh.level_begins[level], nodes + bvh.level_begins[level + 1],
                             [](std::uint32_t ref) { return !is_leaf(ref); })));
    }
    return begins;
}

std::uint64_t fingerprint(const WideBvh& bvh) {
    BvhHasher hasher;
    hasher.add(&bvh.width, sizeof bvh.width);
    std::visit([&](const auto& nodes) { add_inner(hasher, nodes); }, bvh.inner);
    hasher.add_all(bvh.leaves);
    hasher.add_all(bvh.triangles);
    hasher.add_all(bvh.node_refs);
    hasher.add_all(bvh.parents);
    hasher.add_all(bvh.level_begins);
    return hasher.digest();
}

std::size_t memory_bytes(const WideBvh& bvh) {
    const std::size_t inner =
        std::visit([](const auto& nodes) { return bytes_of(nodes); }, bvh.inner);
    return inner + bytes_of(bvh.leaves) + bytes_of(bvh.triangles) + bytes_of(bvh.node_refs) +
           bytes_of(bvh.parents) + bytes_of(bvh.level_begins);
}

}  // namespace scotty::reference
