#include "verify/queues/queues.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "reference/base/error.h"
#include "reference/contract/last_queues.h"
#include "verify/capture/pipeline_input.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::Error;
using reference::kNotApplicable;
using reference::StageKind;

namespace {

/// Buffers kept for the next question; a history needs about six at a time.
constexpr std::size_t kRecentBuffers = 12;

std::string who(const Capture& capture) { return capture.directory().string(); }

reference::WideBvh tree_of(const Capture& capture) {
    if (!capture.has_buffers()) {
        throw Error::bad_input(who(capture),
                               "expected the buffers of its launches, but only the index is left; "
                               "bring the folder buffers/ along, or capture again");
    }
    return read_pipeline_input(capture.directory()).bvh;
}

/// Queues of nodes, as buffers hold them.
struct NodeQueues {
    std::vector<std::uint32_t> counts, offsets, rays;
    std::vector<std::uint32_t> places;  ///< by entry: its index in the queue of pairs
};

/// The queues of the nodes from `first` to `end`, as runs of the sorted pairs. Pairs of other nodes
/// are left out: the invariants report them.
NodeQueues runs_of(std::span<const reference::NodeRay> pairs, const reference::WideBvh& bvh,
                   std::uint32_t first, std::uint32_t end) {
    std::vector<std::uint32_t> position(bvh.inner_count(), reference::kNone);
    for (std::uint32_t node = first; node < end; ++node) {
        const std::uint32_t ref = bvh.node_refs[node];
        if (!reference::is_leaf(ref)) position[ref] = node - first;
    }
    NodeQueues out;
    out.counts.resize(end - first, 0);
    for (std::uint32_t i = 0; i < pairs.size(); ++i) {
        const std::uint32_t inner = pairs[i].node;
        if (inner >= position.size() || position[inner] == reference::kNone) continue;
        ++out.counts[position[inner]];
        out.places.push_back(i);
    }
    std::sort(out.places.begin(), out.places.end(), [&](std::uint32_t a, std::uint32_t b) {
        return std::tie(pairs[a].node, pairs[a].ray, a) < std::tie(pairs[b].node, pairs[b].ray, b);
    });
    out.offsets.push_back(0);
    for (const std::uint32_t count : out.counts) out.offsets.push_back(out.offsets.back() + count);
    for (const std::uint32_t i : out.places) out.rays.push_back(pairs[i].ray);
    return out;
}

/// The root's, which is all rays.
NodeQueues root_queue(std::uint32_t rays) { return {{rays}, {0, rays}, {}, {}}; }

/// By node: the lowest block that has an entry of it. Last: all blocks.
std::vector<std::uint32_t> first_blocks(const NodeQueues& queues, std::uint32_t threads) {
    std::vector<std::uint32_t> out;
    std::uint32_t entries = 0;
    for (std::size_t node = 0; node < queues.counts.size(); ++node) {
        std::uint32_t first =
            queues.counts[node] == 0 || queues.places.empty() ? 0 : reference::kNone;
        for (std::uint32_t p = 0; p < queues.counts[node] && !queues.places.empty(); ++p) {
            first = std::min(first, queues.places[queues.offsets[node] + p] / threads);
        }
        out.push_back(first);
        entries += queues.counts[node];
    }
    out.push_back((entries + threads - 1) / threads);
    return out;
}

/// By entry of a level: its index in the queue of pairs. In no capture: what a debugger sorts by.
constexpr reference::Buffer<std::uint32_t> kPlaces{"places", reference::Row::none, buffers::kNumber,
                                                   buffers::kExact, "index in the queue of pairs"};

}  // namespace

std::shared_ptr<const reference::OwnedBuffer> Queues::from_pairs(
    const StageRecord& stage, const reference::BufferInfo& wanted) const {
    const auto is = [&](const reference::BufferInfo& one) { return one.name == wanted.name; };
    const bool below =
        is(buffers::child_counts) || is(buffers::child_offsets) || is(buffers::child_queue);
    const bool here = is(buffers::node_counts) || is(buffers::queue_offsets) ||
                      is(buffers::block_offsets) || is(buffers::queue) || is(kPlaces);
    if (!has_pairs() || !is_level_kernel(stage.kind) || !(below || here)) return nullptr;
    const auto& begins = bvh_.level_begins;
    if (stage.level >= bvh_.level_count() || stage.threads == 0) return nullptr;
    NodeQueues queues;
    if (here && stage.level == 0) {
        const BufferRecord* rays = stage.input(buffers::rays.name);
        if (rays == nullptr || is(buffers::queue) || is(kPlaces)) return nullptr;
        queues = root_queue(static_cast<std::uint32_t>(rays->shape.at(0)));
    } else {
        const BufferRecord* record =
            below ? stage.output(buffers::child_pairs.name) : stage.input(buffers::pairs.name);
        if (record == nullptr) return nullptr;
        const auto pairs = buffer(stage, *record);
        const std::uint32_t level = stage.level + (below ? 1 : 0);
        const std::uint32_t first = begins[level];
        const std::uint32_t end = level < bvh_.level_count() ? begins[level + 1] : first;
        queues = runs_of({reinterpret_cast<const reference::NodeRay*>(pairs->bytes.data()),
                          pairs->bytes.size() / sizeof(reference::NodeRay)},
                         bvh_, first, end);
    }
    const auto made = [&](const std::vector<std::uint32_t>& values) {
        reference::OwnedBuffer out = own(reference::buffer_view<std::uint32_t>(
            wanted.name, std::span<const std::uint32_t>(values), wanted.meaning));
        return std::make_shared<const reference::OwnedBuffer>(std::move(out));
    };
    if (is(buffers::node_counts) || is(buffers::child_counts)) return made(queues.counts);
    if (is(buffers::queue_offsets) || is(buffers::child_offsets)) return made(queues.offsets);
    if (is(buffers::block_offsets)) return made(first_blocks(queues, stage.threads));
    return made(is(kPlaces) ? queues.places : queues.rays);
}

Queues::Queues(const Capture& capture)
    : capture_(capture), bvh_(tree_of(capture)), last_queues_(reference::last_queues(bvh_)) {
    for (const StageRecord& stage : capture_.stages()) {
        batches_ = std::max(batches_, stage.batch + 1);
    }
    origins_.resize(batches_);
}

const StageRecord& Queues::launch(std::uint32_t number) const {
    const auto& stages = capture_.stages();
    for (const StageRecord& stage : stages) {
        if (stage.launch == number) return stage;
    }
    if (stages.empty()) throw Error::bad_input(who(capture_), "holds no launches");
    throw Error::bad_input(
        who(capture_),
        fmt::format("there is no launch {}; it holds {} of the launches {} to {}", number,
                    stages.size(), stages.front().launch, stages.back().launch));
}

std::uint32_t Queues::level_of(std::uint32_t node) const {
    if (node >= bvh_.node_count()) {
        throw Error::bad_input(who(capture_),
                               fmt::format("there is no node {}; the tree has nodes "
                                           "0 to {} in {} levels",
                                           node, bvh_.node_count() - 1, bvh_.level_count()));
    }
    const auto& begins = bvh_.level_begins;
    if (node >= begins.back()) {
        std::uint32_t root = node;
        while (root >= begins.back()) root = bvh_.parents[root];
        throw Error::bad_input(
            who(capture_), fmt::format("node {} has no queue: it is inside the subtree of node {}, "
                                       "whose rays go on depth first; ask for node {}",
                                       node, root, root));
    }
    const auto after = std::upper_bound(begins.begin(), begins.end(), node);
    return static_cast<std::uint32_t>(after - begins.begin()) - 1;
}

std::uint32_t Queues::last_queue_of(std::uint32_t primitive) const {
    return primitive < last_queues_.size() ? last_queues_[primitive] : reference::kNone;
}

std::shared_ptr<const reference::OwnedBuffer> Queues::buffer(const StageRecord& stage,
                                                             const BufferRecord& record) const {
    const std::string key = record.name + "=" + record.file;  // equal arrays are one file
    const auto found = std::find_if(recent_.begin(), recent_.end(),
                                    [&](const auto& recent) { return recent.first == key; });
    auto item = found != recent_.end()
                    ? *found
                    : std::pair(key, std::make_shared<const reference::OwnedBuffer>(
                                         capture_.load(stage, record)));
    if (found != recent_.end()) recent_.erase(found);
    recent_.push_front(item);
    if (recent_.size() > kRecentBuffers) recent_.pop_back();
    return item.second;
}

PartialStage Queues::some_of(const StageRecord& stage,
                             std::initializer_list<const reference::BufferInfo*> wanted) const {
    PartialStage part;
    part.view = bare_view(stage);
    for (const reference::BufferInfo* info : wanted) {
        if (const auto made = from_pairs(stage, *info); made != nullptr) {
            part.kept.push_back(made);
            const bool output = info->row == reference::Row::child_node;
            (output ? part.view.outputs : part.view.inputs).push_back(made->view());
            continue;
        }
        for (const bool output : {false, true}) {
            const BufferRecord* record =
                output ? stage.output(info->name) : stage.input(info->name);
            if (record == nullptr) continue;
            part.kept.push_back(buffer(stage, *record));
            (output ? part.view.outputs : part.view.inputs).push_back(part.kept.back()->view());
        }
    }
    return part;
}

LevelQueues Queues::queues_of(const StageRecord& stage) const {
    if (!is_level_kernel(stage.kind)) {
        throw Error::bad_input(
            stage.name, fmt::format("{} has no queues; only intersect_root and intersect read them",
                                    to_string(stage.kind)));
    }
    if (stage.level >= bvh_.level_count()) {
        throw Error::bad_input(stage.name, fmt::format("the tree has {} levels, no level {}",
                                                       bvh_.level_count(), stage.level));
    }
    LevelQueues out;
    out.stage = some_of(stage, {&buffers::node_counts, &buffers::queue_offsets,
                                &buffers::block_offsets, &buffers::queue, &kPlaces});
    out.first_node = bvh_.level_begins[stage.level];
    const std::uint32_t nodes = bvh_.level_begins[stage.level + 1] - out.first_node;
    const auto counts = out.stage.get(buffers::node_counts);
    out.block_offsets = out.stage.get(buffers::block_offsets);
    out.places = out.stage.get(kPlaces);
    if (stage.level == 0 && counts.size() == 1) {
        out.regions.regions = {{0, counts[0], counts[0], counts[0]}};
    } else if (const auto* queue = out.stage.view.find(buffers::queue.name); queue != nullptr) {
        out.queue = out.stage.get(buffers::queue);
        out.regions = regions_of(out.stage.view, *queue, false);
    }
    if (counts.size() != nodes || out.nodes() != nodes || out.block_offsets.size() < nodes ||
        stage.threads == 0) {
        throw Error::bad_input(
            stage.name,
            fmt::format("expected node_counts, queue_offsets, block_offsets and queue of {} nodes",
                        nodes));
    }
    return out;
}

std::optional<LevelTotals> Queues::totals(const StageRecord& stage) const {
    if (!is_level_kernel(stage.kind) || stage.level >= bvh_.level_count()) return std::nullopt;
    const PartialStage part =
        some_of(stage, {&buffers::node_counts, &buffers::block_offsets, &buffers::child_counts});
    const auto counts = part.get(buffers::node_counts);
    if (counts.empty()) return std::nullopt;
    LevelTotals out;
    out.nodes = static_cast<std::uint32_t>(counts.size());
    for (std::uint32_t i = 0; i < out.nodes; ++i) {
        out.with_work += counts[i] != 0 ? 1 : 0;
        out.entries += counts[i];
        if (counts[i] <= out.longest) continue;
        out.longest = counts[i];
        out.longest_node = bvh_.level_begins[stage.level] + i;
    }
    const auto blocks = part.get(buffers::block_offsets);
    out.blocks = blocks.empty() ? stage.blocks : blocks.back();
    for (const std::uint32_t count : part.get(buffers::child_counts)) out.pushed += count;
    return out;
}

std::vector<LaunchRow> Queues::launches(const DiffReport* verdicts) const {
    std::vector<LaunchRow> rows;
    for (const StageRecord& stage : capture_.stages()) {
        LaunchRow row;
        row.stage = &stage;
        row.totals = totals(stage);
        if (verdicts != nullptr) {
            const auto found =
                std::find_if(verdicts->stages.begin(), verdicts->stages.end(),
                             [&](const StageResult& result) { return result.name == stage.name; });
            if (found != verdicts->stages.end()) {
                row.verdict = found->verdict;
                row.missing = found->missing;
            }
        }
        rows.push_back(row);
    }
    return rows;
}

std::vector<NodeRow> Queues::nodes(const StageRecord& stage) const {
    const LevelQueues queues = queues_of(stage);
    const PartialStage children = some_of(stage, {&buffers::child_counts});
    const auto pushed = children.get(buffers::child_counts);
    const std::uint32_t first_child = bvh_.level_begins[stage.level + 1];
    std::vector<NodeRow> rows;
    for (std::uint32_t i = 0; i < queues.nodes(); ++i) {
        const Regions::Region& region = queues.regions.regions[i];
        NodeRow row;
        row.node = queues.first_node + i;
        row.parent = bvh_.parents[row.node];
        row.count = static_cast<std::uint32_t>(region.count);
        row.claimed = static_cast<std::uint32_t>(region.claimed);
        row.offset = static_cast<std::uint32_t>(region.begin);
        row.first_block = queues.block_offsets[i];
        std::set<std::uint32_t> blocks;
        for (std::uint32_t p = 0; p < row.count; ++p) blocks.insert(queues.block(i, p));
        row.blocks = static_cast<std::uint32_t>(blocks.size());
        const std::uint32_t ref = bvh_.node_refs[row.node];
        row.leaf = bvh_.ends_queues(row.node);
        if (reference::is_leaf(ref)) row.triangles = bvh_.leaves[reference::ref_index(ref)].count;
        // Breadth-first: a node's children are neighbours in the level below.
        const auto begin = bvh_.parents.begin() + first_child;
        const auto range = std::equal_range(begin, bvh_.parents.end(), row.node);
        for (auto child = range.first; !row.leaf && child != range.second; ++child) {
            const auto id = static_cast<std::uint32_t>(child - bvh_.parents.begin());
            row.children.push_back(id);
            row.pushed.push_back(id - first_child < pushed.size() ? pushed[id - first_child] : 0);
        }
        rows.push_back(std::move(row));
    }
    return rows;
}

std::vector<Entry> Queues::entries(const StageRecord& stage, std::uint32_t node) const {
    const std::uint32_t level = level_of(node);
    const LevelQueues queues = queues_of(stage);
    if (level != stage.level) {
        throw Error::bad_input(stage.name, fmt::format("node {} is of level {}; this launch is of "
                                                       "level {}, which has nodes {} to {}",
                                                       node, level, stage.level, queues.first_node,
                                                       queues.first_node + queues.nodes() - 1));
    }
    const PartialStage state = some_of(stage, {&buffers::rays, &buffers::minimum});
    const auto rays = state.get(buffers::rays);
    const auto minimum = state.get(buffers::minimum);
    const std::uint32_t position = node - queues.first_node;
    std::vector<Entry> out(queues.regions.regions[position].count);
    for (std::uint32_t p = 0; p < out.size(); ++p) {
        Entry& entry = out[p];
        entry.position = p;
        entry.block = queues.block(position, p);
        entry.thread = queues.thread(position, p);
        entry.ray = queues.ray(position, p);
        if (entry.ray < rays.size()) entry.record = rays[entry.ray];
        if (entry.ray < minimum.size()) entry.minimum = minimum[entry.ray];
        entry.from = origin(stage.batch, entry.ray);
    }
    return out;
}

const PartialStage* Queues::primary_rays(std::uint32_t batch) const {
    if (batch >= batches_) return nullptr;
    if (!origins_[batch]) {
        const StageRecord* stage = capture_.find(
            reference::stage_name(StageKind::primary_rays, batch, kNotApplicable, kNotApplicable,
                                  kNotApplicable, capture_.header().several_batches));
        origins_[batch] = stage == nullptr ? PartialStage{}
                                           : some_of(*stage, {&buffers::pixel, &buffers::sample});
    }
    return &*origins_[batch];
}

std::size_t Queues::ray_count(std::uint32_t batch) const {
    for (const StageRecord& stage : capture_.stages()) {
        if (stage.batch != batch) continue;
        for (const auto* buffers : {&stage.inputs, &stage.outputs}) {
            for (const BufferRecord& buffer : *buffers) {
                if (buffer.name == buffers::rays.name || buffer.name == buffers::radiance.name)
                    return buffer.shape.at(0);
            }
        }
    }
    return 0;
}

std::optional<Provenance> Queues::origin(std::uint32_t batch, std::uint32_t ray) const {
    const PartialStage* stage = primary_rays(batch);
    if (stage == nullptr) return std::nullopt;
    const auto pixel = stage->get(buffers::pixel);
    const auto sample = stage->get(buffers::sample);
    if (ray >= pixel.size() || ray >= sample.size()) return std::nullopt;
    const std::uint32_t width = parameters().image_width;
    return Provenance{pixel[ray] % width, pixel[ray] / width, sample[ray]};
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> Queues::rays_of(std::uint32_t x,
                                                                     std::uint32_t y) const {
    const auto& p = parameters();
    if (x >= p.image_width || y >= p.image_height) {
        throw Error::bad_input(
            who(capture_), fmt::format("there is no pixel ({}, {}); the image has {}x{}, from (0, "
                                       "0) at the top left",
                                       x, y, p.image_width, p.image_height));
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
    bool known = false;
    for (std::uint32_t batch = 0; batch < batches_; ++batch) {
        const auto pixel = primary_rays(batch)->get(buffers::pixel);
        known = known || !pixel.empty();
        for (std::uint32_t ray = 0; ray < pixel.size(); ++ray) {
            if (pixel[ray] == y * p.image_width + x) out.emplace_back(batch, ray);
        }
    }
    if (!known) {
        throw Error::bad_input(who(capture_),
                               "which rays belong to a pixel is in primary_rays, which was not "
                               "captured; capture it too: --stages '*primary_rays'");
    }
    return out;
}

}  // namespace scotty::verify
