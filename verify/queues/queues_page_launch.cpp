#include "verify/queues/queues_page_launch.h"

#include <nlohmann/json.hpp>

#include "verify/queues/queues_diff.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using nlohmann::json;
using reference::StageKind;

namespace {

template <class T>
std::span<const float> as_floats(std::span<const T> records) {
    static_assert(sizeof(T) % 4 == 0);
    // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): records are float32 throughout
    return {reinterpret_cast<const float*>(records.data()), records.size_bytes() / 4};
}

/// Entries in use, node by node.
std::vector<std::uint32_t> without_gaps(std::span<const std::uint32_t> queue,
                                        const Regions& regions) {
    std::vector<std::uint32_t> out;
    for (const Regions::Region& region : regions.regions) {
        const auto begin = queue.begin() + static_cast<std::ptrdiff_t>(region.begin);
        out.insert(out.end(), begin, begin + static_cast<std::ptrdiff_t>(region.count));
    }
    return out;
}

template <class Field>
std::vector<std::uint32_t> of_regions(const Regions& regions, const Field& field) {
    std::vector<std::uint32_t> out;
    for (const Regions::Region& region : regions.regions) {
        out.push_back(static_cast<std::uint32_t>(field(region)));
    }
    return out;
}

json level_arrays(PageArrays& pool, const Queues& queues, const StageRecord& stage,
                  const TraversalLog* log) {
    using Region = Regions::Region;
    const LevelQueues level = queues.queues_of(stage);
    std::vector<std::uint32_t> queue;
    for (std::size_t node = 0; node < level.nodes(); ++node) {
        for (std::size_t p = 0; p < level.regions.regions[node].count; ++p) {
            queue.push_back(level.ray(node, p));
        }
    }
    json out{
        {"queue", pool.add(queue)},
        {"lengths", pool.add(of_regions(level.regions, [](const Region& r) { return r.count; }))},
        {"offsets", pool.add(of_regions(level.regions, [](const Region& r) { return r.begin; }))},
        {"claimed", pool.add(of_regions(level.regions, [](const Region& r) { return r.claimed; }))},
        {"block_offsets", pool.add(level.block_offsets)}};
    if (!level.places.empty()) out["places"] = pool.add(level.places);
    const PartialStage below = queues.some_of(
        stage, {&buffers::child_counts, &buffers::child_offsets, &buffers::child_queue});
    if (const auto* child_queue = below.view.find(buffers::child_queue.name);
        child_queue != nullptr) {
        const Regions regions = regions_of(below.view, *child_queue, true);
        out["child_queue"] = pool.add(without_gaps(below.get(buffers::child_queue), regions));
        out["child_counts"] =
            pool.add(of_regions(regions, [](const Region& r) { return r.count; }));
        out["child_claimed"] =
            pool.add(of_regions(regions, [](const Region& r) { return r.claimed; }));
        out["child_room"] = pool.add(of_regions(regions, [](const Region& r) { return r.room; }));
        out["child_offsets"] =
            pool.add(of_regions(regions, [](const Region& r) { return r.begin; }));
    }
    const PartialStage state = queues.some_of(stage, {&buffers::rays, &buffers::minimum});
    if (const auto rays = state.get(buffers::rays); !rays.empty()) {
        out["rays"] = pool.add(as_floats(rays));
    }
    if (const auto minimum = state.get(buffers::minimum); !minimum.empty()) {
        out["minimum"] = pool.add(minimum);
    }
    const auto found = log == nullptr ? std::map<std::uint32_t, VisitLog>::const_iterator{}
                                      : log->launches.find(stage.launch);
    static const VisitLog nothing;
    const bool has = log != nullptr && found != log->launches.end();
    out.update((has ? found->second : nothing).arrays(pool, queue.size()));
    return out;
}

json merge_arrays(PageArrays& pool, const Queues& queues, const StageRecord& stage,
                  const TraversalLog* log) {
    json out = json::object();
    const PartialStage part = queues.some_of(stage, {&buffers::rays, &buffers::merged});
    if (const auto rays = part.get(buffers::rays); !rays.empty()) {
        out["rays"] = pool.add(as_floats(rays));
    }
    // The primitive goes along as bits; the page takes it out of the same words.
    if (const auto merged = part.get(buffers::merged); !merged.empty()) {
        out["merged"] = pool.add(as_floats(merged));
    }
    if (log == nullptr) return out;
    std::vector<std::uint32_t> winner;
    winner.reserve(log->winner_node.size());
    for (const std::uint32_t node : log->winner_node) winner.push_back(node + 1);  // 0: none
    out["winner_node"] = pool.add(winner);
    for (const auto& [ray, hit] : log->stray) {
        out["stray"].push_back({ray, hit.slot, hit.hit.t, hit.hit.primitive, hit.won});
    }
    return out;
}

}  // namespace

json launch_arrays(PageArrays& pool, const Queues& queues, const StageRecord& stage,
                   const TraversalLog* log) {
    if (is_level_kernel(stage.kind)) return level_arrays(pool, queues, stage, log);
    if (stage.kind == StageKind::merge_intersections) {
        return merge_arrays(pool, queues, stage, log);
    }
    json out = json::object();
    const auto add = [&](const reference::BufferInfo& buffer) {
        const PartialStage part = queues.some_of(stage, {&buffer});
        if (part.view.find(buffer.name) == nullptr) return;
        out[std::string(buffer.name)] = buffer.type == reference::ElementType::float32
                                            ? pool.add(part.view.get<float>(buffer.name))
                                            : pool.add(part.view.get<std::uint32_t>(buffer.name));
    };
    switch (stage.kind) {
        case StageKind::direct_light_rays:
            add(buffers::shadow_rays);
            add(buffers::potential);
            break;
        case StageKind::resolve_light:
            add(buffers::radiance);
            break;
        case StageKind::scene_rays:
            add(buffers::flags);
            add(buffers::rays);
            add(buffers::throughput);
            add(buffers::radiance);
            break;
        case StageKind::reconstruct_image:
            add(buffers::radiance);
            break;
        default:
            break;
    }
    return out;
}

json pair_arrays(PageArrays& pool, const Queues& a, const StageRecord& a_stage, const Queues& b,
                 const StageRecord& b_stage) {
    std::vector<std::uint32_t> nodes, pairs, of_a, of_b, change, what;
    for (const NodePair& node : compare_nodes(a, a_stage, b, b_stage)) {
        if (node.moved + node.changed + node.missing + node.extra == 0) continue;
        const auto aligned =
            align(a.entries(a_stage, node.a.node), b.entries(b_stage, node.a.node));
        nodes.push_back(node.a.node);
        pairs.push_back(static_cast<std::uint32_t>(aligned.size()));
        for (const EntryPair& pair : aligned) {
            of_a.push_back(pair.a ? pair.a->position + 1 : 0);
            of_b.push_back(pair.b ? pair.b->position + 1 : 0);
            change.push_back(static_cast<std::uint32_t>(pair.change));
            what.push_back((pair.what.find("ray") != std::string::npos ? 1 : 0) +
                           (pair.what.find("minimum") != std::string::npos ? 2 : 0));
        }
    }
    if (nodes.empty()) return json::object();
    return {{"node", pool.add(nodes)}, {"pairs", pool.add(pairs)},   {"a", pool.add(of_a)},
            {"b", pool.add(of_b)},     {"change", pool.add(change)}, {"what", pool.add(what)}};
}

}  // namespace scotty::verify
