#include "reference/contract/last_queues.h"

namespace scotty::reference {

std::vector<std::uint32_t> last_queues(const WideBvh& bvh) {
    std::vector<std::uint32_t> out(bvh.triangles.size(), kNone);
    for (std::uint32_t node = 0; node < bvh.node_count(); ++node) {
        if (!is_leaf(bvh.node_refs[node])) continue;
        std::uint32_t last = node;
        while (last >= bvh.level_begins.back()) last = bvh.parents[last];
        const Leaf& leaf = bvh.leaves[ref_index(bvh.node_refs[node])];
        for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
            const std::uint32_t primitive = bvh.triangles[i].primitive;
            if (primitive < out.size()) out[primitive] = last;
        }
    }
    return out;
}

}  // namespace scotty::reference
