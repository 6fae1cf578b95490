#include "verify/diff/diff.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

#include "reference/base/error.h"
#include "verify/capture/failure.h"
#include "verify/capture/pipeline_input.h"
#include "verify/diff/diff_parts.h"
#include "verify/diff/tolerance.h"
#include "verify/invariants/invariants.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::BufferView;
using reference::EarlyOut;
using reference::kNotApplicable;
using reference::PipelineParameters;
using reference::StageKind;
using reference::StageView;

namespace {

/// Under `immediate` queues and gathered hits depend on when other blocks lower a minimum; the rays
/// themselves and their final results do not.
bool depends_on_timing(const PipelineParameters& p, const StageView& stage,
                       std::string_view buffer) {
    if (p.early_out != EarlyOut::immediate) return false;
    if (is_of_traversal(stage.kind)) return buffer != buffers::rays.name;
    return stage.kind == StageKind::merge_intersections &&
           (buffer == buffers::hit_counts.name || buffer == buffers::hits.name ||
            buffer == buffers::packed_hits.name);
}

/// Whether the buffer belongs to shadow rays that only ask whether they hit; their hits vary.
bool only_occlusion(const PipelineParameters& p, const StageView& stage, std::string_view buffer) {
    return p.early_out == EarlyOut::immediate && p.shadow_query == reference::ShadowQuery::any &&
           stage.light != kNotApplicable &&
           (buffer == buffers::merged.name || buffer == buffers::shadow_hits.name);
}

/// Orders a stage's differences: inputs lead, then those that name a ray.
int rank(const Comparison& comparison, std::string_view buffer, bool output) {
    if (!output) return 0;
    if (comparison.field == "shape") return 4;
    const bool counter = buffer == buffers::child_counts.name || buffer == buffers::hit_counts.name;
    return counter ? 3 : (reference::buffer_info(buffer).order == BufferOrder::ordered ? 2 : 1);
}

const BufferView* find_in(const std::vector<BufferView>& buffers, std::string_view name) {
    for (const BufferView& buffer : buffers) {
        if (buffer.name == name) return &buffer;
    }
    return nullptr;
}

Divergence divergence_of(const StageView& stage) {
    Divergence out;
    out.stage = stage.name;
    out.launch = stage.launch;
    out.level = stage.level;
    return out;
}

Divergence divergence_of(const Failure& failure, const char* side) {
    Divergence out;
    out.stage = failure.stage;
    out.launch = failure.launch;
    out.level = failure.level;
    out.node = failure.node;
    out.block = failure.block;
    out.thread = failure.thread;
    out.ray = failure.ray;
    out.field = failure.field;
    out.sentence =
        fmt::format("{} is out of bounds ({}): {}", side, failure.invariant, failure.sentence);
    out.a = "expected " + failure.expected;
    out.b = "found " + failure.found;
    return out;
}

}  // namespace

const char* to_string(Verdict verdict) {
    switch (verdict) {
        case Verdict::identical:
            return "identical";
        case Verdict::reordered:
            return "reordered";
        case Verdict::within_tolerance:
            return "within tolerance";
        case Verdict::within_bounds:
            return "within bounds";
        case Verdict::not_comparable:
            return "not comparable (immediate)";
        case Verdict::differs:
            return "differs";
    }
    return "(invalid)";
}

class Differ::State {
 public:
    State(const Capture& a, DiffOptions options)
        : a_(a),
          options_(std::move(options)),
          input_(input_of(a)),
          places_(a, input_ ? &input_->bvh : nullptr) {
        for (std::size_t i = 0; i < a.stages().size(); ++i) order_[a.stages()[i].name] = i;
        if (parameters().early_out != EarlyOut::immediate || tolerant() || options_.isolated ||
            !input_ || !a.header().patterns.empty() || !a.has_buffers()) {
            return;
        }
        check_a();
        b_checker_.emplace(input_->scene, input_->bvh, parameters(), every_failure());
    }

    void add(const StageView& b) {
        if (b_checker_) b_checker_->on_stage(b);
        const StageRecord* a = partner_of(b);
        if (a == nullptr) return;
        results_[key(last_)] = compare_stage(a_.load(*a).view, b);
        take_failures_of_b();
    }

    void add_by_hash(const StageRecord& b) {
        b_checker_.reset();  // nothing is left to check the bounds with
        const StageRecord* a = partner_of(bare_view(b));
        if (a == nullptr) return;
        StageResult result = bare(bare_view(b));
        compare_hashes(a->inputs, b.inputs, true, b, result);
        compare_hashes(a->outputs, b.outputs, false, b, result);
        results_[key(last_)] = std::move(result);
    }

    void retry(std::string_view stage, std::string_view reason) {
        if (b_checker_) b_checker_->on_retry(stage, reason);
        const std::size_t slash = stage.rfind('/');
        const std::string prefix =
            std::string(slash == std::string_view::npos ? "" : stage.substr(0, slash + 1)) +
            "level";
        std::erase_if(results_, [&](const auto& result) {
            const bool dropped = result.second.name.starts_with(prefix);
            if (dropped) seen_.erase(result.second.name);
            return dropped;
        });
    }

    void add_end(const std::string& what) {
        const std::size_t next = seen_.empty() ? 0 : last_ + 1;
        if (next < a_.stages().size()) add_error(a_.stages()[next], what);
    }

    void add_error(const StageRecord& stage, const std::string& what) {
        if (!asked(stage.name)) return;
        StageResult result = bare(bare_view(stage));
        result.verdict = Verdict::differs;
        result.first = divergence_of(bare_view(stage));
        result.first->sentence = "the stage could not be run: " + what;
        result.first->replay = replay_command(stage.name);
        results_[key(order_.at(stage.name))] = std::move(result);
        seen_.insert(stage.name);
    }

    DiffReport finish(const std::function<bool(std::string_view)>& covers) {
        for (std::size_t i = 0; i < a_.stages().size(); ++i) {
            const StageRecord& stage = a_.stages()[i];
            if (seen_.contains(stage.name) || !asked(stage.name)) continue;
            if (covers(stage.name)) {
                add_missing(bare(bare_view(stage)), "B", i);
            } else {
                ++not_compared_;
            }
        }
        for (const Divergence& found : a_failures_) add_out_of_bounds(found);
        DiffReport report;
        report.a = a_.directory().string();
        report.a_backend = a_.header().backend;
        report.b_backend = options_.b_backend;
        report.isolated = options_.isolated;
        report.not_compared = not_compared_;
        for (auto& [order, result] : results_) report.stages.push_back(std::move(result));
        return report;
    }

 private:
    static std::optional<PipelineInput> input_of(const Capture& a) {
        if (!std::filesystem::exists(a.directory() / kInputFolder)) return std::nullopt;
        return read_pipeline_input(a.directory());
    }
    static InvariantSettings every_failure() {
        InvariantSettings settings;
        settings.max_failures = 10000;
        settings.recompute_shading = false;  // shading is compared, by its arithmetic's tolerance
        return settings;
    }
    const PipelineParameters& parameters() const { return a_.header().parameters; }
    bool tolerant() const {
        return parameters().arithmetic == reference::Arithmetic::fast ||
               options_.b_arithmetic == reference::Arithmetic::fast;
    }
    /// A's stage of that name, from now on the last seen; null if there is none to compare with.
    const StageRecord* partner_of(const StageView& b) {
        if (!asked(b.name)) return nullptr;
        const auto at = order_.find(b.name);
        if (at == order_.end()) {
            if (a_.covers(b.name)) {
                add_missing(bare(b), "A", last_);
            } else {
                ++not_compared_;
            }
            return nullptr;
        }
        last_ = at->second;
        seen_.insert(b.name);
        return &a_.stages()[last_];
    }

    /// Equal canonical hashes mean equal content, whatever the order or the unused room.
    void compare_hashes(const std::vector<BufferRecord>& a, const std::vector<BufferRecord>& b,
                        bool input, const StageRecord& stage, StageResult& result) {
        const StageView view = bare_view(stage);
        for (const BufferRecord& buffer : a) {
            const auto other = std::find_if(b.begin(), b.end(), [&](const BufferRecord& record) {
                return record.name == buffer.name;
            });
            Verdict verdict = Verdict::identical;
            if (other == b.end() || buffer.canonical_hash != other->canonical_hash) {
                verdict = depends_on_timing(parameters(), view, buffer.name) ||
                                  only_occlusion(parameters(), view, buffer.name)
                              ? Verdict::not_comparable
                              : Verdict::differs;
            } else if (buffer.hash != other->hash) {
                verdict = Verdict::reordered;
            }
            result.buffers.push_back({buffer.name, input, verdict, 0});
            result.verdict = std::max(result.verdict, verdict);
            if (verdict != Verdict::differs || result.first) continue;
            Divergence found = divergence_of(view);
            found.buffer = buffer.name;
            found.input = input;
            found.a = "hash " + buffer.canonical_hash;
            found.b = other == b.end() ? "no such buffer" : "hash " + other->canonical_hash;
            found.sentence = fmt::format(
                "the content differs; a capture is without its buffers, "
                "so capture this stage again (--stages '{}') to see where",
                stage.name);
            result.first = std::move(found);
        }
    }

    bool asked(const std::string& stage) const {
        return options_.patterns.empty() ||
               std::any_of(options_.patterns.begin(), options_.patterns.end(),
                           [&](const std::string& p) { return stage_matches(p, stage); });
    }
    static StageResult bare(const StageView& stage) {
        StageResult result;
        result.name = stage.name;
        result.kind = stage.kind;
        result.launch = stage.launch;
        return result;
    }
    /// A's stages in their order; those that only B has come after the last that both have.
    static std::pair<std::size_t, std::size_t> key(std::size_t a_index, std::size_t extra = 0) {
        return {a_index, extra};
    }

    void add_missing(StageResult result, const char* side, std::size_t where) {
        // When timing matters, one run may well be done a level earlier than the other; the bounds
        // say whether it was right.
        result.missing = true;
        const bool may_be =
            parameters().early_out == EarlyOut::immediate && is_of_traversal(result.kind);
        result.verdict = may_be ? timing_verdict() : Verdict::differs;
        if (!may_be) {
            StageView view;
            view.name = result.name;
            view.launch = result.launch;
            result.first = divergence_of(view);
            result.first->sentence = fmt::format("the stage is missing in {}", side);
        }
        const bool in_b = *side == 'B';
        results_[key(where, in_b ? 0 : ++extras_)] = std::move(result);
    }

    Verdict timing_verdict() const {
        return b_checker_ ? Verdict::within_bounds : Verdict::not_comparable;
    }

    std::string replay_command(const std::string& stage) const {
        if (!options_.rerun.empty()) {
            return fmt::format("{} --isolated --stages '{}'", options_.rerun, stage);
        }
        return fmt::format("scotty replay {} --stage {} --backend {}", a_.directory().string(),
                           stage, options_.b_backend);
    }

    void check_a() {
        InvariantChecker checker(input_->scene, input_->bvh, parameters(), every_failure());
        for (const StageRecord& stage : a_.stages()) checker.on_stage(a_.load(stage).view);
        for (const Failure& failure : checker.failures()) {
            a_failures_.push_back(divergence_of(failure, "A"));
        }
    }

    void take_failures_of_b() {
        if (!b_checker_) return;
        const auto& failures = b_checker_->failures();
        // A retry withdraws failures.
        for (taken_ = std::min(taken_, failures.size()); taken_ < failures.size(); ++taken_) {
            add_out_of_bounds(divergence_of(failures[taken_], "B"));
        }
    }

    /// Adds to the stage that the failure names.
    void add_out_of_bounds(Divergence found) {
        const auto at = order_.find(found.stage);
        if (at == order_.end() || !asked(found.stage)) return;
        const StageRecord& stage = a_.stages()[at->second];
        const auto result = results_.find(key(at->second));
        if (result == results_.end()) return;
        if (result->second.verdict == Verdict::differs) return;
        found.replay = replay_command(found.stage);
        places_.fill_provenance(found, stage.batch);
        result->second.verdict = Verdict::differs;
        result->second.first = std::move(found);
    }

    StageResult compare_stage(const StageView& a, const StageView& b) {
        StageResult result = bare(b);
        int best_rank = 1000;
        if (!options_.isolated) compare_lists(a, b, false, result, best_rank);
        compare_lists(a, b, true, result, best_rank);
        for (const BufferView& output : a.outputs) note_non_finite(a, output, false, result);
        for (const BufferView& output : b.outputs) note_non_finite(b, output, true, result);
        return result;
    }

    static void note_non_finite(const StageView& stage, const BufferView& output, bool in_b,
                                StageResult& result) {
        std::optional<NonFinite> found = find_non_finite(stage, output);
        if (!found) return;
        found->in_b = in_b;
        result.non_finite.push_back(std::move(*found));
    }

    void compare_lists(const StageView& a, const StageView& b, bool output, StageResult& result,
                       int& best_rank) {
        const auto& a_list = output ? a.outputs : a.inputs;
        const auto& b_list = output ? b.outputs : b.inputs;
        for (const BufferView& buffer : a_list) {
            if (const BufferView* other = find_in(b_list, buffer.name)) {
                compare_buffer({a, buffer, b, *other, output}, result, best_rank);
            } else {
                add_missing_buffer(b, buffer, output, "B", result, best_rank);
            }
        }
        // A stage that ran alone returns more than the pipeline shows.
        if (options_.isolated) return;
        for (const BufferView& buffer : b_list) {
            if (find_in(a_list, buffer.name) == nullptr) {
                add_missing_buffer(b, buffer, output, "A", result, best_rank);
            }
        }
    }

    void compare_buffer(const BufferPair& pair, StageResult& result, int& best_rank) {
        const std::string_view name = pair.a.name;
        Comparison found = only_occlusion(parameters(), pair.b_stage, name)
                               ? compare_occlusion(pair)
                               : compare(pair);
        if (found.verdict == Verdict::differs && tolerant()) {
            found = compare_within_tolerance(pair);
        }
        if (found.verdict == Verdict::differs &&
            depends_on_timing(parameters(), pair.b_stage, name)) {
            found.verdict = timing_verdict();
        }
        result.buffers.push_back({std::string(name), !pair.output, found.verdict, found.different});
        result.verdict = std::max(result.verdict, found.verdict);
        if (found.verdict != Verdict::differs) return;
        const int own_rank = rank(found, name, pair.output);
        if (own_rank >= best_rank) return;
        best_rank = own_rank;
        Divergence divergence = divergence_of(pair.b_stage);
        divergence.buffer = std::string(name);
        divergence.field = found.field;
        divergence.input = !pair.output;
        divergence.a = found.a;
        divergence.b = found.b;
        divergence.ulps = found.ulps;
        divergence.sentence = found.sentence;
        if (!pair.output) divergence.sentence += "; the stage was handed it so";
        divergence.replay = replay_command(divergence.stage);
        places_.fill(divergence, pair, found);
        if (options_.written_by && pair.output && found.word) {
            divergence.written_by =
                options_.written_by(static_cast<const std::byte*>(pair.b.data) + 4 * *found.word);
        }
        result.first = std::move(divergence);
    }

    void add_missing_buffer(const StageView& b, const BufferView& buffer, bool output,
                            const char* side, StageResult& result, int& best_rank) {
        result.buffers.push_back({std::string(buffer.name), !output, Verdict::differs, 1});
        result.verdict = Verdict::differs;
        if (best_rank <= 0) return;
        best_rank = 0;
        result.first = divergence_of(b);
        result.first->buffer = std::string(buffer.name);
        result.first->input = !output;
        result.first->sentence = fmt::format("the buffer is missing in {}", side);
    }

    const Capture& a_;
    DiffOptions options_;
    std::optional<PipelineInput> input_;
    Places places_;
    std::map<std::string, std::size_t, std::less<>> order_;  ///< A's stages by name
    std::map<std::pair<std::size_t, std::size_t>, StageResult> results_;
    std::set<std::string, std::less<>> seen_;
    std::size_t last_ = 0;    ///< A's stage that was compared last
    std::size_t extras_ = 0;  ///< stages that only B has
    std::uint64_t not_compared_ = 0;
    std::optional<InvariantChecker> b_checker_;
    std::size_t taken_ = 0;  ///< B's failures that have been reported
    std::vector<Divergence> a_failures_;
};

Differ::Differ(const Capture& a, DiffOptions options)
    : state_(std::make_unique<State>(a, std::move(options))) {}
Differ::~Differ() = default;
void Differ::on_stage(const StageView& b) { state_->add(b); }
void Differ::add_by_hash(const StageRecord& b) { state_->add_by_hash(b); }
void Differ::on_retry(std::string_view stage, std::string_view reason) {
    state_->retry(stage, reason);
}
void Differ::add_error(const StageRecord& stage, const std::string& what) {
    state_->add_error(stage, what);
}
void Differ::add_end(const std::string& what) { state_->add_end(what); }
DiffReport Differ::finish(const std::function<bool(std::string_view)>& covers) {
    return state_->finish(covers);
}

}  // namespace scotty::verify
