#include "verify/queues/queues_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

#include "verify/base/ask.h"
#include "verify/base/json_number.h"
#include "verify/base/progress.h"
#include "verify/invariants/expected.h"
#include "verify/pages/page.h"
#include "verify/queues/queues_diff.h"
#include "verify/queues/queues_invariants.h"
#include "verify/queues/queues_page_launch.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using nlohmann::json;
using reference::kNone;
using reference::kNotApplicable;
using reference::StageKind;

namespace {

json invariant_names(reference::StageKind kind) {
    json names = json::array();
    for (const char* name : reference::stage_info(kind).invariants) names.push_back(name);
    return names;
}

/// Divergences that one can step through; the rest is counted.
constexpr std::size_t kDivergences = 500;
/// Triangles that the view of the scene can bear.
constexpr std::size_t kTriangles = 20000;

class PageMaker {
 public:
    PageMaker(const Queues& a, const Queues* b, const PageRequest& request)
        : a_(a), b_(b), request_(request), stages_(a.capture().stages()) {}

    json make() {
        judge();
        json page = about();
        page["tree"] = tree();
        for (std::size_t i = 0; i < stages_.size(); ++i) launches_.push_back(about_launch(i));
        pool_.close(SIZE_MAX);
        page["divergences"] = divergences_;
        page["first"] = first_selection();
        page["images"] = images();
        page["from"] = provenance();
        page["scene_triangles"] = triangles();
        embed_launches(page["first"]["launch"].get<std::size_t>());
        page["launches"] = std::move(launches_);
        page["command"] = command();
        page["pool"] = pool_.document();
        return page;
    }

 private:
    std::string command() const {
        std::string text =
            fmt::format("scotty queues {}", shell_word(a_.capture().directory().string()));
        if (b_ != nullptr) text += " --diff " + shell_word(b_->capture().directory().string());
        return text;
    }

    /// Everything that is a verdict is found here.
    void judge() {
        checked_a_ = check_capture(a_.capture());
        if (b_ != nullptr) {
            checked_b_ = check_capture(b_->capture());
            Progress progress;
            progress.show("comparing the captures");
            report_ = diff_captures(a_.capture(), b_->capture());
            for (const StageResult& result : report_.stages) results_[result.name] = &result;
        }
        for (std::size_t i = 0; i < stages_.size(); ++i) find_divergences(i);
        std::stable_sort(divergences_.begin(), divergences_.end(),
                         [](const json& x, const json& y) {
                             return x["launch"].get<std::size_t>() < y["launch"].get<std::size_t>();
                         });
    }

    const StageRecord* partner(const StageRecord& stage) const {
        return b_ == nullptr ? nullptr : b_->capture().find(stage.name);
    }

    const StageResult* result(const StageRecord& stage) const {
        const auto found = results_.find(stage.name);
        return found == results_.end() ? nullptr : found->second;
    }

    void add_divergence(json divergence) {
        if (divergences_.size() < kDivergences) {
            divergences_.push_back(std::move(divergence));
        } else {
            ++more_divergences_;
        }
    }

    /// The first failure of an invariant in a node, the diff's first of a launch, then each node in
    /// which entries differ.
    void find_divergences(std::size_t index) {
        const StageRecord& stage = stages_[index];
        std::vector<std::uint32_t> told;
        const auto add = [&](const char* side, const std::string& what, const std::string& text,
                             std::uint32_t node, std::uint32_t ray, std::uint32_t block) {
            add_divergence({{"launch", index},
                            {"side", side},
                            {"what", what},
                            {"text", text},
                            {"node", json_id(node)},
                            {"ray", json_id(ray)},
                            {"block", json_id(block)}});
            told.push_back(node);
        };
        const auto* found = result(stage);
        const std::optional<Divergence> first =
            found != nullptr && found->failed() ? found->first : std::nullopt;
        if (first) {
            const std::string values = first->a.empty() && first->b.empty()
                                           ? ""
                                           : fmt::format(" ({}{}{}: A {}, B {})", first->buffer,
                                                         first->field.empty() ? "" : ".",
                                                         first->field, first->a, first->b);
            add("diff", "differs", first->sentence + values, first->node, first->ray, first->block);
        }
        for (const auto& [side, run] : {std::pair("a", &checked_a_), std::pair("b", &checked_b_)}) {
            const StageRecord* of_side = *side == 'a' ? &stage : partner(stage);
            if (of_side == nullptr || !run->failures.contains(of_side->launch)) continue;
            std::map<std::pair<std::string, std::uint32_t>, bool> seen;
            for (const Failure& failure : run->failures.at(of_side->launch)) {
                if (!seen.emplace(std::pair(failure.invariant, failure.node), true).second) {
                    continue;
                }
                add(side, failure.invariant, told_by(failure), failure.node, failure.ray,
                    failure.block);
            }
        }
        if (!first || !is_level_kernel(stage.kind) || partner(stage) == nullptr) return;
        for (const NodePair& pair : compare_nodes(a_, stage, *b_, *partner(stage))) {
            if (pair.missing + pair.extra + pair.changed == 0) continue;
            if (std::find(told.begin(), told.end(), pair.a.node) != told.end()) continue;
            add("diff", "differs",
                fmt::format("{} missing, {} extra, {} changed in the queue of node {}",
                            pair.missing, pair.extra, pair.changed, pair.a.node),
                pair.a.node, kNone, kNone);
        }
    }

    static std::string told_by(const Failure& failure) {
        if (failure.expected.empty() && failure.found.empty()) return failure.sentence;
        return fmt::format("{} ({}: expected {}, found {})", failure.sentence,
                           failure.field.empty() ? "value" : failure.field, failure.expected,
                           failure.found);
    }

    json about() const {
        const auto one = [](const Queues& queues, const CheckedRun& checked) {
            const CaptureHeader& header = queues.capture().header();
            return json{{"path", queues.capture().directory().string()},
                        {"backend", header.backend},
                        {"checked", checked.asked},
                        {"not_kept", checked.not_kept}};
        };
        const CaptureHeader& header = a_.capture().header();
        json out{{"scene", header.scene_name},
                 {"a", one(a_, checked_a_)},
                 {"b", b_ == nullptr ? json() : one(*b_, checked_b_)},
                 {"parameters", verify::to_json(header.parameters)},
                 {"batches", a_.batches()},
                 {"more_divergences", more_divergences_}};
        for (std::uint32_t batch = 0; batch < a_.batches(); ++batch) {
            out["rays"].push_back(a_.ray_count(batch));
        }
        std::size_t only_b = 0;
        for (const StageResult& stage : report_.stages) {
            only_b += a_.capture().find(stage.name) == nullptr ? 1 : 0;
        }
        out["only_in_b"] = only_b;
        return out;
    }

    json tree() {
        const auto& bvh = a_.bvh();
        std::vector<float> boxes(std::size_t{6} * bvh.node_count());
        const auto put = [&](std::uint32_t node, const reference::Vec3& low,
                             const reference::Vec3& high) {
            const float box[] = {low.x, low.y, low.z, high.x, high.y, high.z};
            std::copy(std::begin(box), std::end(box), boxes.begin() + std::size_t{6} * node);
        };
        std::vector<std::uint32_t> parents, triangles;
        for (std::uint32_t node = 0; node < bvh.node_count(); ++node) {
            parents.push_back(node == 0 ? 0 : bvh.parents[node]);
            const std::uint32_t ref = bvh.node_refs[node];
            const bool leaf = reference::is_leaf(ref);
            triangles.push_back(leaf ? bvh.leaves[reference::ref_index(ref)].count : 0);
            if (leaf) continue;
            const NodeBoxes of = boxes_of(bvh, reference::ref_index(ref));
            if (node == 0) put(node, of.node_low, of.node_high);
            for (std::uint32_t c = 0; c < of.width; ++c) {
                if (of.child[c] != kNone) put(of.child[c], of.low[c], of.high[c]);
            }
        }
        return {{"level_begins", bvh.level_begins},
                {"parents", pool_.add(parents)},
                {"triangles", pool_.add(triangles)},  // 0: an inner node
                {"boxes", pool_.add(boxes)}};
    }

    std::vector<std::uint32_t> counts(const Queues& queues, const StageRecord& stage) const {
        const PartialStage part = queues.some_of(stage, {&buffers::node_counts});
        const auto of = part.get(buffers::node_counts);
        return {of.begin(), of.end()};
    }

    json about_launch(std::size_t index) {
        const StageRecord& stage = stages_[index];
        json out{{"launch", stage.launch},          {"name", stage.name},
                 {"kind", to_string(stage.kind)},   {"batch", stage.batch},
                 {"bounce", json_id(stage.bounce)}, {"light", json_id(stage.light)},
                 {"level", json_id(stage.level)},   {"blocks", stage.blocks},
                 {"threads", stage.threads}};
        const StageRecord* b = partner(stage);
        const StageResult* diff = result(stage);
        if (b != nullptr && b->launch != stage.launch) out["launch_b"] = b->launch;
        if (b_ != nullptr) {
            out["verdict"] = b == nullptr || (diff != nullptr && diff->missing) ? "missing"
                             : diff == nullptr                                  ? "not compared"
                                               : to_string(diff->verdict);
            out["differs"] = diff != nullptr && diff->failed();
        }
        if (diff != nullptr && diff->failed() && diff->first && !diff->first->replay.empty()) {
            out["replay"] = diff->first->replay;
        }
        out["invariants"] = {{"names", invariant_names(stage.kind)},
                             {"a", failures(checked_a_, stage)},
                             {"b", b == nullptr ? json::array() : failures(checked_b_, *b)}};
        if (!is_level_kernel(stage.kind)) return out;
        out["counts"] = pool_.add(counts(a_, stage));
        if (b == nullptr) return out;
        out["counts_b"] = pool_.add(counts(*b_, *b));
        if (diff == nullptr || diff->verdict == Verdict::identical) return out;
        std::vector<std::uint32_t> differences;
        std::uint64_t moved = 0;
        for (const NodePair& pair : compare_nodes(a_, stage, *b_, *b)) {
            differences.push_back(
                static_cast<std::uint32_t>(pair.changed + pair.missing + pair.extra));
            moved += pair.moved;
        }
        out["differences"] = pool_.add(differences);
        out["moved"] = moved;
        return out;
    }

    static json failures(const CheckedRun& run, const StageRecord& stage) {
        json out = json::array();
        const auto found = run.failures.find(stage.launch);
        if (found == run.failures.end()) return out;
        for (const Failure& failure : found->second) {
            if (out.size() == 100) break;  // the page says how many there are
            out.push_back({{"name", failure.invariant},
                           {"node", json_id(failure.node)},
                           {"block", json_id(failure.block)},
                           {"ray", json_id(failure.ray)},
                           {"text", told_by(failure)}});
        }
        return out;
    }

    /// What was asked for; else the first divergence; else the first root, and the pixel in the
    /// middle.
    json first_selection() const {
        std::size_t index = stages_.size();
        json node;
        json ray;
        if (request_.launch) {
            const StageRecord& stage = a_.launch(*request_.launch);
            index = static_cast<std::size_t>(&stage - stages_.data());
        } else if (!divergences_.empty()) {
            index = divergences_[0]["launch"];
            node = divergences_[0]["node"];
            ray = divergences_[0]["ray"];
        }
        if (request_.node) {
            node = *request_.node;
            const std::uint32_t level = a_.level_of(*request_.node);
            for (std::size_t i = 0; i < stages_.size() && !request_.launch; ++i) {
                if (stages_[i].level != level || !is_level_kernel(stages_[i].kind)) continue;
                index = std::min(index, i);
            }
        }
        if (request_.ray) ray = *request_.ray;
        for (std::size_t i = 0; index == stages_.size() && i < stages_.size(); ++i) {
            if (is_level_kernel(stages_[i].kind)) index = i;
        }
        json out{{"launch", index == stages_.size() ? 0 : index}, {"node", node}, {"ray", ray}};
        if (request_.pixel) {
            out["pixel"] = {request_.pixel->first, request_.pixel->second};
        } else if (ray.is_null() && divergences_.empty()) {
            const auto& p = a_.parameters();
            out["pixel"] = {p.image_width / 2, p.image_height / 2};
        }
        return out;
    }

    std::size_t room() const {
        return request_.room > pool_.size() ? request_.room - pool_.size() : 0;
    }

    json images() {
        const auto last = [](const Queues& queues) -> const StageRecord* {
            const StageRecord* found = nullptr;
            for (const StageRecord& stage : queues.capture().stages()) {
                if (stage.kind == StageKind::reconstruct_image) found = &stage;
            }
            return found;
        };
        json out;
        for (const auto& [side, queues] : {std::pair("a", &a_), std::pair("b", b_)}) {
            const StageRecord* stage = queues == nullptr ? nullptr : last(*queues);
            if (stage == nullptr) continue;
            const PartialStage part = queues->some_of(*stage, {&buffers::image});
            if (part.view.find(buffers::image.name) == nullptr) continue;
            const std::uint32_t number = pool_.add(part.view.get<float>(buffers::image.name));
            if (pool_.close(room() / 2)) out[side] = number;
        }
        return out;
    }

    json provenance() {
        json out = json::array();
        for (std::uint32_t batch = 0; batch < a_.batches(); ++batch) {
            std::vector<std::uint32_t> pixel, sample;
            const auto& p = a_.parameters();
            for (std::uint32_t ray = 0; const auto from = a_.origin(batch, ray); ++ray) {
                pixel.push_back(from->pixel_y * p.image_width + from->pixel_x);
                sample.push_back(from->sample);
            }
            json one{{"pixel", pool_.add(pixel)}, {"sample", pool_.add(sample)}};
            out.push_back(!pixel.empty() && pool_.close(room() / 2) ? one : json());
            pool_.close(0);
        }
        return out;
    }

    json triangles() {
        const auto& all = a_.bvh().triangles;
        if (all.size() > kTriangles) return nullptr;
        std::vector<float> corners;
        std::vector<std::uint32_t> first;  // by node: of a leaf
        for (const auto& t : all) {
            for (const auto& v : {t.v0, t.v1, t.v2}) corners.insert(corners.end(), {v.x, v.y, v.z});
        }
        for (const std::uint32_t ref : a_.bvh().node_refs) {
            first.push_back(
                reference::is_leaf(ref) ? a_.bvh().leaves[reference::ref_index(ref)].first : 0);
        }
        json out{{"corners", pool_.add(corners)}, {"first", pool_.add(first)}};
        return pool_.close(room() / 3) ? out : json();
    }

    static bool of_traversal(const StageRecord& stage) {
        return reference::is_of_traversal(stage.kind) ||
               stage.kind == StageKind::merge_intersections;
    }

    /// A traversal, or a launch between traversals: what is read together.
    struct Unit {
        std::size_t first = 0, last = 0;
    };
    std::vector<Unit> units() const {
        std::vector<Unit> out;
        for (std::size_t i = 0; i < stages_.size(); ++i) {
            const StageRecord& s = stages_[i];
            const bool goes_on = i > 0 && of_traversal(s) && of_traversal(stages_[i - 1]) &&
                                 s.batch == stages_[i - 1].batch &&
                                 s.bounce == stages_[i - 1].bounce &&
                                 s.light == stages_[i - 1].light;
            if (!goes_on) out.push_back({i, i});
            out.back().last = i;
        }
        return out;
    }

    /// From `focus` outwards, until a launch finds no room any more.
    void embed_launches(std::size_t focus) {
        std::vector<Unit> order = units();
        const auto away = [&](const Unit& unit) {
            return focus < unit.first  ? unit.first - focus
                   : focus > unit.last ? focus - unit.last
                                       : 0;
        };
        std::stable_sort(order.begin(), order.end(),
                         [&](const Unit& x, const Unit& y) { return away(x) < away(y); });
        Progress progress;
        for (const Unit& unit : order) {
            progress.show(fmt::format("embedding {}", stages_[unit.first].name));
            if (!embed(unit, focus)) return;
        }
    }

    bool embed(const Unit& unit, std::size_t focus) {
        const StageRecord& first = stages_[unit.first];
        std::optional<TraversalLog> log_a;
        std::optional<TraversalLog> log_b;
        bool same = true;
        for (std::size_t i = unit.first; i <= unit.last; ++i) {
            const StageResult* diff = result(stages_[i]);
            same = same && diff != nullptr && diff->verdict == Verdict::identical;
        }
        const bool with_b = b_ != nullptr && !same;
        if (of_traversal(first)) {
            log_a = log_traversal(a_, first);
            if (with_b) log_b = log_traversal(*b_, first);
        }
        std::vector<std::size_t> order;
        for (std::size_t i = unit.first; i <= unit.last; ++i) order.push_back(i);
        std::stable_sort(order.begin(), order.end(), [&](std::size_t x, std::size_t y) {
            return std::max(x, focus) - std::min(x, focus) <
                   std::max(y, focus) - std::min(y, focus);
        });
        for (const std::size_t i : order) {
            const StageRecord& stage = stages_[i];
            const StageRecord* b = with_b ? partner(stage) : nullptr;
            json of_a = launch_arrays(pool_, a_, stage, log_a ? &*log_a : nullptr);
            json of_b;
            json pairs;
            if (b != nullptr) {
                of_b = launch_arrays(pool_, *b_, *b, log_b ? &*log_b : nullptr);
                if (is_level_kernel(stage.kind)) pairs = pair_arrays(pool_, a_, stage, *b_, *b);
            }
            if (!pool_.close(room())) return false;
            launches_[i]["arrays"] = std::move(of_a);
            if (b != nullptr && of_b != launches_[i]["arrays"]) {
                launches_[i]["arrays_b"] = std::move(of_b);
            }
            if (pairs.is_object() && !pairs.empty()) launches_[i]["pairs"] = std::move(pairs);
            if (log_a && !log_a->gaps.empty()) launches_[i]["gaps"] = log_a->gaps;
            if (log_b && !log_b->gaps.empty()) launches_[i]["gaps_b"] = log_b->gaps;
        }
        return true;
    }

    const Queues& a_;
    const Queues* b_;
    const PageRequest& request_;
    const std::vector<StageRecord>& stages_;
    CheckedRun checked_a_, checked_b_;
    DiffReport report_;
    std::map<std::string, const StageResult*> results_;
    std::vector<json> divergences_, launches_;
    std::uint64_t more_divergences_ = 0;
    PageArrays pool_;
};

}  // namespace

json queues_page_data(const Queues& a, const Queues* b, const PageRequest& request) {
    return PageMaker(a, b, request).make();
}

std::string queues_page(const Queues& a, const Queues* b, const PageRequest& request) {
    const json data = queues_page_data(a, b, request);
    return filled_page(
        "queues.html",
        {{"title", fmt::format("<title>{}: scotty queues</title>",
                               html_text(data["scene"].get<std::string>()))},
         {"policy",
          "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
          "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">"},
         {"data", fmt::format("<script type=\"application/json\" id=\"queues-data\">{}</script>",
                              json_for_script(data))}});
}

}  // namespace scotty::verify
