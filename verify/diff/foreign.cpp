#include "verify/diff/foreign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "reference/base/error.h"
#include "verify/capture/failure.h"
#include "verify/capture/npy.h"
#include "verify/diff/foreign_run.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::Error;
using reference::kNotApplicable;
using reference::Ray;
using reference::StageKind;
using reference::StageView;

ForeignTree read_foreign_tree(const Capture& capture) {
    ForeignTree tree{read_pipeline_input(capture.directory()), {}, {}, {}};
    const std::filesystem::path file = capture.directory() / kInputFolder / "node_ids.npy";
    const NpyArray ids = read_npy(file);
    const auto values = ids.get<std::uint64_t>();
    tree.node_ids.assign(values.begin(), values.end());
    reference::Scene& scene = tree.input.scene;
    validate_and_repair(scene);
    const reference::WideBvh& bvh = tree.input.bvh;
    tree.violations = reference::validate(bvh, scene);
    if (tree.node_ids.size() != bvh.node_count() || bvh.level_begins.size() < 2 ||
        bvh.level_begins.back() != bvh.node_count()) {
        throw Error::bad_input(file.string(), fmt::format("{} ids, but the tree has {} nodes",
                                                          tree.node_ids.size(), bvh.node_count()));
    }
    tree.leaf_of.assign(scene.triangles.size(), kNotApplicable);
    for (std::uint32_t node = 0; node < bvh.node_count(); ++node) {
        if (!reference::is_leaf(bvh.node_refs[node])) continue;
        const reference::Leaf& leaf = bvh.leaves.at(reference::ref_index(bvh.node_refs[node]));
        for (std::uint32_t i = leaf.first; i < leaf.first + leaf.count; ++i) {
            tree.leaf_of.at(bvh.triangles.at(i).primitive) = node;
        }
    }
    return tree;
}

ForeignVerdict::ForeignVerdict(const Capture& capture, const ForeignTree& tree,
                               const ForeignQuery& query, const StageView& stage)
    : capture_(capture), tree_(tree), query_(query), stage_(stage) {
    result_.name = stage.name;
    result_.kind = stage.kind;
    result_.launch = stage.launch;
}

BufferResult& ForeignVerdict::buffer_named(const char* name) {
    for (BufferResult& buffer : result_.buffers) {
        if (buffer.name == name) return buffer;
    }
    return result_.buffers.emplace_back(BufferResult{name, false, Verdict::identical, 0});
}

void ForeignVerdict::fail(const char* buffer, std::uint32_t node, std::uint32_t ray,
                          std::string sentence, std::string found, std::string expected,
                          std::uint32_t block) {
    BufferResult& result = buffer_named(buffer);
    result.verdict = Verdict::differs;
    ++result.different;
    if (result_.first) return;
    Divergence& first = result_.first.emplace();
    first.stage = stage_.name;
    first.launch = stage_.launch;
    first.level = stage_.level;
    first.node = node;
    first.ray = ray;
    first.block = block;
    first.buffer = buffer;
    first.sentence = std::move(sentence);
    first.a = std::move(found);
    first.b = std::move(expected);
    if (node != kNotApplicable) first.own_node = tree_.node_ids[node];
    if (ray < query_.ids.size()) first.own_ray = query_.ids[ray];
    first.replay =
        fmt::format("scotty diff {} --stages '{}'", capture_.directory().string(), stage_.name);
}

StageResult ForeignVerdict::take() {
    for (const BufferResult& buffer : result_.buffers) {
        result_.verdict = std::max(result_.verdict, buffer.verdict);
    }
    return std::move(result_);
}

namespace {

class ForeignDiff {
 public:
    ForeignDiff(const Capture& capture, const Backend& backend, const DiffOptions& options)
        : capture_(capture),
          backend_(backend),
          options_(options),
          tree_(read_foreign_tree(capture)) {}

    DiffReport run() && {
        report_.a = capture_.directory().string();
        report_.a_backend = capture_.header().backend;
        report_.b = "the " + backend_.name;
        report_.b_backend = backend_.name;
        report_.isolated = true;
        report_.tree_violations = tree_.violations;
        const auto& stages = capture_.stages();
        for (std::size_t begin = 0; begin < stages.size();) {
            std::size_t end = begin;
            while (end < stages.size() && prefix_of(stages[end]) == prefix_of(stages[begin])) ++end;
            judge_query({stages.data() + begin, end - begin});
            begin = end;
        }
        name_other_kinds();
        return std::move(report_);
    }

 private:
    static std::string prefix_of(const StageRecord& stage) {
        const std::size_t level = stage.name.find("level");
        return stage.name.substr(0, level != std::string::npos ? level : stage.name.rfind('/') + 1);
    }
    bool asked(const std::string& stage) const {
        return options_.patterns.empty() ||
               std::any_of(options_.patterns.begin(), options_.patterns.end(),
                           [&](const std::string& p) { return stage_matches(p, stage); });
    }

    ForeignQuery begin_query(const StageRecord& record, const StageView& first) const {
        ForeignQuery query;
        query.prefix = prefix_of(record);
        query.asks_any = record.light != kNotApplicable &&
                         tree_.input.parameters.shadow_query == reference::ShadowQuery::any;
        const auto rays = first.get(buffers::rays);
        const auto ids = first.get<std::uint64_t>("ray_ids");
        if (rays.empty() || ids.size() < rays.size()) {
            throw Error::bad_input(capture_.directory().string(),
                                   query.prefix + " has no rays, or no ids of them");
        }
        query.rays.assign(rays.begin(), rays.end());
        query.ids.assign(ids.begin(), ids.end());
        for (Ray& ray : query.rays) {
            bool sound = ray.t_min >= 0.0f && !std::isnan(ray.t_max) &&
                         ray.direction != reference::Vec3(0.0f, 0.0f, 0.0f);
            for (int axis = 0; axis < 3; ++axis) {
                sound = sound && std::isfinite(ray.origin[axis]) &&
                        std::abs(ray.origin[axis]) <= reference::kMaxCoordinate &&
                        std::isfinite(ray.direction[axis]);
            }
            query.sound.push_back(sound);
            if (!sound) ray = reference::dead_ray();
        }
        query.truth.resize(rays.size());
        query.leaf_hits.resize(rays.size());
        query.given.assign(tree_.node_ids.size(), false);
        // A tree of our own: the capture's may be what is wrong.
        const reference::PipelineParameters parameters;
        const reference::WideBvh bvh =
            build_wide_bvh(tree_.input.scene, bvh_parameters(parameters, 0));
        backend_.make(tree_.input.scene, bvh, parameters, {})
            ->trace(query.rays, reference::TraversalKind::closest, query.truth);
        return query;
    }

    void judge_query(std::span<const StageRecord> stages) {
        const LoadedStage first = capture_.load(stages.front());
        ForeignQuery query = begin_query(stages.front(), first.view);
        for (const StageRecord& record : stages) {
            const LoadedStage loaded = capture_.load(record);
            ForeignVerdict verdict(capture_, tree_, query, loaded.view);
            if (record.level == 0) judge_rays(query, verdict);
            const bool culls = capture_.header().culls;
            if (is_level_kernel(record.kind)) {
                judge_foreign_level(loaded.view, tree_, backend_, culls, query, verdict);
            } else if (record.kind == StageKind::merge_intersections) {
                query.has_hits = !loaded.view.get(buffers::hit_counts).empty();
                query.has_answers = !loaded.view.get(buffers::merged).empty();
                judge_foreign_hits(loaded.view, tree_, culls, query, verdict);
            }
            if (!asked(record.name) || !verdict.is_judged()) continue;
            report_.excused += verdict.excused_count();
            report_.stages.push_back(verdict.take());
        }
        name_missing(query);
    }

    static void judge_rays(const ForeignQuery& query, ForeignVerdict& verdict) {
        for (std::uint32_t ray = 0; ray < query.count(); ++ray) {
            if (query.sound[ray]) continue;
            verdict.fail("rays", kNotApplicable, ray, "the ray cannot be traced",
                         "a value that is not finite, no direction, or t_min below 0",
                         "finite values");
        }
    }

    void name_missing(const ForeignQuery& query) {
        const auto& begins = tree_.input.bvh.level_begins;
        std::string levels;
        for (std::size_t level = 1; level + 1 < begins.size(); ++level) {
            const auto begin = query.given.begin() + begins[level];
            const auto end = query.given.begin() + begins[level + 1];
            const auto given = std::count(begin, end, true);
            if (given == end - begin) continue;
            levels += levels.empty() ? "" : ", ";
            levels += given == 0 ? fmt::format("{}", level)
                                 : fmt::format("{} ({} of {} nodes)", level, end - begin - given,
                                               end - begin);
        }
        if (!levels.empty())
            report_.not_given.push_back(query.prefix + "queues of level " + levels);
        if (!query.has_hits) report_.not_given.push_back(query.prefix + "gathered hits");
        if (!query.has_answers) report_.not_given.push_back(query.prefix + "closest hits");
    }

    void name_other_kinds() {
        std::set<StageKind> seen;
        for (const StageRecord& stage : capture_.stages()) seen.insert(stage.kind);
        for (const reference::StageInfo& info : reference::kStages) {
            if (info.of_traversal && info.kind != StageKind::merge_intersections) continue;
            if (!seen.contains(info.kind)) report_.not_given.emplace_back(info.name);
        }
    }

    const Capture& capture_;
    const Backend& backend_;
    const DiffOptions& options_;
    ForeignTree tree_;
    DiffReport report_;
};

}  // namespace

DiffReport diff_foreign(const Capture& capture, const Backend& backend, DiffOptions options) {
    if (!capture.header().foreign) {
        throw Error::bad_input(capture.directory().string(), "is not of another program");
    }
    return ForeignDiff(capture, backend, options).run();
}

}  // namespace scotty::verify
