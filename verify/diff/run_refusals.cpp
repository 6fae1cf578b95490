#include "verify/diff/run_refusals.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <variant>

#include "reference/base/error.h"
#include "reference/contract/batch_plan.h"
#include "reference/contract/stage_inputs.h"
#include "verify/capture/replay_inputs.h"
#include "verify/oracles/refusal_check.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::BufferView;
using reference::kNotApplicable;
using reference::OwnedBuffer;
using reference::StageKind;
using reference::StageView;

namespace {

Failure refusal_failure(const std::string& stage, const std::string& sentence) {
    Failure failure;
    failure.invariant = kRefusal;
    failure.stage = stage;
    failure.sentence = sentence;
    return failure;
}

/// What a function throws; empty where it does not.
std::string error_text(const std::function<void()>& run, std::string* said) {
    try {
        run();
    } catch (const reference::Error& error) {
        if (said != nullptr) *said += std::string(error.what()) + '\n';
        return error.what();
    }
    return {};
}

/// A launch whose inputs may be changed.
class Inputs {
 public:
    explicit Inputs(const StageView& stage) : view_(stage) {
        for (const BufferView& buffer : stage.inputs) owned_.push_back(own(buffer));
        view_.outputs.clear();
    }

    StageView& place() { return view_; }
    const StageView& view() {
        view_.inputs.clear();
        for (const OwnedBuffer& buffer : owned_) view_.inputs.push_back(buffer.view());
        return view_;
    }
    void erase(std::string_view name) {
        std::erase_if(owned_, [&](const OwnedBuffer& buffer) { return buffer.name == name; });
    }
    OwnedBuffer& at(std::string_view name) {
        return *std::find_if(owned_.begin(), owned_.end(),
                             [&](const OwnedBuffer& buffer) { return buffer.name == name; });
    }
    /// Word i of a buffer, as a number.
    void set(std::string_view name, std::size_t word, std::uint32_t value) {
        std::memcpy(at(name).bytes.data() + word * sizeof value, &value, sizeof value);
    }

 private:
    StageView view_;
    std::vector<OwnedBuffer> owned_;
};

std::set<std::size_t> ends_and_middle_of(std::size_t size) {
    if (size == 0) return {};
    return {0, size / 2, size - 1};
}

class StageSpoiler {
 public:
    StageSpoiler(const Capture& capture, const Backend& backend, std::string* said)
        : capture_(capture),
          backend_(backend),
          said_(said),
          input_(read_pipeline_input(capture.directory())),
          parameters_(input_.parameters) {}

    std::vector<Failure> run() {
        for (const reference::StageInfo& info : reference::kStages) {
            const StageRecord* first = nullptr;
            const StageRecord* last = nullptr;
            for (const StageRecord& stage : capture_.stages()) {
                if (stage.kind != info.kind) continue;
                if (first == nullptr) first = &stage;
                last = &stage;
            }
            if (first != nullptr) spoil(*first);
            if (last != first) spoil(*last);
        }
        return std::move(failures_);
    }

 private:
    using Edit = std::function<void(Inputs&)>;

    void spoil(const StageRecord& record) {
        const LoadedStage loaded = prepare_stage(capture_, record);
        stage_ = &loaded.view;
        spoil_place();
        for (const BufferView& buffer : loaded.view.inputs) {
            const reference::BufferInfo* info = reference::find_buffer(buffer.name);
            // At the root, where all rays are in one queue, no offsets are read.
            if (info == nullptr || !reference::reads(stage_->kind, *info)) continue;
            if (stage_->level == 0 && info->name == buffers::queue_offsets.name) continue;
            spoil_shape(*info);
        }
        if (reference::is_level_kernel(stage_->kind)) {
            parameters_.queues == reference::QueueKind::pairs ? spoil_pairs() : spoil_queues();
        }
        if (stage_->kind == StageKind::merge_intersections) spoil_hits();
        spoil_path_hits();
    }

    /// Refused, with an error that names the launch and `named` (empty: the launch will do).
    void refused(std::string_view named, const std::string& what, const Edit& edit) {
        Inputs inputs(*stage_);
        edit(inputs);
        const StageView& view = inputs.view();
        const std::string error =
            error_text([&] { backend_.pipeline(input_)->run_stage(view); }, said_);
        const auto contains = [&](std::string_view part) {
            return error.find(part) != std::string::npos;
        };
        if (error.empty()) {
            failures_.push_back(
                refusal_failure(stage_->name, what + " is run, and should be refused"));
        } else if (!contains(stage_->name) || !contains(named)) {
            failures_.push_back(refusal_failure(
                stage_->name,
                fmt::format("{} is refused, by an error that does not name it: {}", what, error)));
        }
    }

    void spoil_place() {
        const auto levels = static_cast<std::uint32_t>(input_.bvh.level_begins.size() - 1);
        const bool by_level =
            stage_->kind == StageKind::scan_counts || reference::is_level_kernel(stage_->kind);
        if (by_level) {
            refused("level", fmt::format("level {} of {}", levels, levels),
                    [=](Inputs& in) { in.place().level = levels; });
        }
        if (stage_->kind != StageKind::primary_rays && stage_->kind != StageKind::reconstruct_image)
            return;
        const std::uint64_t batches = reference::BatchPlan(parameters_).size();
        // The place is a part of the name.
        Inputs inputs(*stage_);
        inputs.place().batch = static_cast<std::uint32_t>(batches);
        const StageView& view = inputs.view();
        const auto run = [&] { backend_.pipeline(input_)->run_stage(view); };
        if (!error_text(run, said_).empty()) return;
        failures_.push_back(refusal_failure(
            stage_->name,
            fmt::format("batch {} of {} is run, and should be refused", batches, batches)));
    }

    /// Which buffer an error about a wrong number of elements names is the first that disagrees
    /// with another; where this one says how many there are, that is another.
    void spoil_shape(const reference::BufferInfo& info) {
        const std::string name(info.name);
        refused(info.name, name + " that is missing", [&](Inputs& in) { in.erase(info.name); });
        if (stage_->find(info.name)->bytes != 0) {
            refused(info.name, name + " with a part of an element",
                    [&](Inputs& in) { in.at(info.name).bytes.pop_back(); });
        }
        if (counts_itself(info)) return;
        const bool says_count =
            info.name == buffers::rays.name || info.name == buffers::shadow_rays.name;
        const std::string_view named = says_count ? std::string_view() : info.name;
        refused(named, name + " with one element more", [&](Inputs& in) {
            in.at(info.name).bytes.resize(in.at(info.name).bytes.size() + info.element_bytes);
        });
        if (stage_->find(info.name)->bytes == 0) return;
        refused(named, name + " with one element less", [&](Inputs& in) {
            in.at(info.name).bytes.resize(in.at(info.name).bytes.size() - info.element_bytes);
        });
    }
    /// Buffers that may have any number of elements.
    bool counts_itself(const reference::BufferInfo& info) const {
        const bool has_partner = stage_->kind != StageKind::publish_minimum &&
                                 info.name != buffers::queue.name &&
                                 info.order != reference::BufferOrder::set;
        const bool one_list = info.name == buffers::hits.name && rays() == 1;
        return !has_partner || one_list;
    }
    std::size_t rays() const { return stage_->get(buffers::rays).size(); }

    void spoil_queues() {
        const std::size_t level_nodes = stage_->get(buffers::node_counts).size();
        const auto counts = stage_->get(buffers::node_counts);
        const auto per_block = static_cast<std::uint32_t>(parameters_.rays_per_block);
        const auto spoil_word = [&](const auto& buffer, std::size_t i, std::uint32_t value,
                                    std::string_view named) {
            refused(named, fmt::format("{} {} = {}", buffer.name, i, value),
                    [&](Inputs& in) { in.set(buffer.name, i, value); });
        };
        for (const std::size_t i : ends_and_middle_of(level_nodes)) {
            spoil_word(buffers::node_counts, i, counts[i] + per_block, stage_->name);
        }
        if (stage_->level == 0) {
            const std::uint32_t other = counts[0] % per_block == 1 || counts[0] % per_block == 0
                                            ? counts[0] + (counts[0] % per_block == 1 ? 1 : -1)
                                            : counts[0] - 1;
            if (other != 0) spoil_word(buffers::node_counts, 0, other, stage_->name);
        }
        const auto blocks = stage_->get(buffers::block_offsets);
        for (const std::size_t i : ends_and_middle_of(blocks.size())) {
            spoil_word(buffers::block_offsets, i, blocks[i] + 1, buffers::block_offsets.name);
        }
        spoil_offsets(buffers::child_offsets);
        if (stage_->level == 0) return;
        spoil_offsets(buffers::queue_offsets);
        const auto offsets = stage_->get(buffers::queue_offsets);
        std::vector<std::size_t> used;
        for (std::size_t node = 0; node < counts.size(); ++node) {
            if (counts[node] == 0) continue;
            used.push_back(offsets[node]);
            used.push_back(offsets[node] + counts[node] - 1);
        }
        for (const std::size_t i : ends_and_middle_of(used.size())) {
            spoil_word(buffers::queue, used[i], static_cast<std::uint32_t>(rays()),
                       buffers::queue.name);
        }
    }

    /// The first, the middle and the last pair: a ray that there is not, and nodes of other levels.
    void spoil_pairs() {
        const auto begins = reference::inner_begins(input_.bvh);
        for (const std::size_t i : ends_and_middle_of(stage_->get(buffers::pairs).size())) {
            const auto spoil_word = [&](std::size_t word, std::uint32_t value) {
                refused(buffers::pairs.name,
                        fmt::format("pair {} with word {} = {}", i, word, value),
                        [&](Inputs& in) { in.set(buffers::pairs.name, 2 * i + word, value); });
            };
            spoil_word(0, begins[stage_->level] - 1);
            spoil_word(0, begins[stage_->level + 1]);
            spoil_word(1, static_cast<std::uint32_t>(rays()));
        }
    }

    void spoil_offsets(const reference::Buffer<std::uint32_t>& buffer) {
        const auto offsets = stage_->get(buffer);
        for (std::size_t i = 1; i < offsets.size(); i = std::max(i + 1, offsets.size() - 1)) {
            refused(buffer.name, fmt::format("{} {} less than the one before", buffer.name, i),
                    [&](Inputs& in) { in.set(buffer.name, i - 1, offsets[i] + 1); });
        }
    }

    /// The first and the last hit that a ray has.
    void spoil_hits() {
        const auto triangles = static_cast<std::uint32_t>(input_.scene.triangles.size());
        const std::string what = fmt::format("a hit with primitive {}", triangles);
        const auto packed = stage_->get(buffers::packed_hits);
        const auto counts = stage_->get(buffers::hit_counts);
        const auto hits = stage_->get(buffers::hits);
        std::vector<std::pair<std::string_view, std::size_t>> words;
        for (std::size_t ray = 0; ray < packed.size(); ++ray) {
            if (packed[ray] != reference::kNoPackedHit)
                words.emplace_back(buffers::packed_hits.name, 2 * ray);
        }
        for (std::size_t ray = 0; ray < counts.size(); ++ray) {
            const std::size_t capacity = hits.size() / counts.size();
            const std::size_t found = std::min<std::size_t>(counts[ray], capacity);
            for (std::size_t slot = 0; slot < found; ++slot) {
                words.emplace_back(buffers::hits.name, 2 * (ray * capacity + slot) + 1);
            }
        }
        for (const std::size_t i : ends_and_middle_of(words.size())) {
            const auto& [name, word] = words[i];
            refused(name, what,
                    [&, of = name, at = word](Inputs& in) { in.set(of, at, triangles); });
        }
    }

    void spoil_path_hits() {
        const auto triangles = static_cast<std::uint32_t>(input_.scene.triangles.size());
        const auto hits = stage_->get(buffers::path_hits);
        if (!reference::reads(stage_->kind, buffers::path_hits)) return;
        std::vector<std::size_t> found;
        for (std::size_t ray = 0; ray < hits.size(); ++ray) {
            if (is_hit(hits[ray])) found.push_back(ray);
        }
        constexpr std::size_t kWords = sizeof(reference::Hit) / sizeof(std::uint32_t);
        for (const std::size_t i : ends_and_middle_of(found.size())) {
            refused(buffers::path_hits.name,
                    fmt::format("a path's hit with primitive {}", triangles), [&](Inputs& in) {
                        in.set(buffers::path_hits.name, kWords * found[i] + 1, triangles);
                    });
        }
    }

    const Capture& capture_;
    const Backend& backend_;
    std::string* said_;
    PipelineInput input_;
    const reference::PipelineParameters& parameters_;
    const StageView* stage_ = nullptr;
    std::vector<Failure> failures_;
};

}  // namespace

std::vector<Failure> check_stage_refusals(const Capture& capture, const Backend& backend,
                                          std::string* said) {
    return StageSpoiler(capture, backend, said).run();
}

std::vector<Failure> check_ray_refusals(const PipelineInput& input, const Backend& backend,
                                        std::span<const reference::Ray> rays, std::string* said) {
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    constexpr float kInf = std::numeric_limits<float>::infinity();
    std::vector<Failure> failures;
    if (rays.empty()) return failures;
    const auto refused = [&](const std::string& what,
                             const std::function<void(reference::Ray&)>& edit) {
        std::vector<reference::Ray> spoiled(rays.begin(), rays.end());
        std::vector<reference::Hit> hits(spoiled.size());
        edit(spoiled.back());
        const std::string error = error_text(
            [&] {
                backend.pipeline(input)->trace(spoiled, reference::TraversalKind::closest, hits);
            },
            said);
        if (error.find(fmt::format("ray {}", spoiled.size() - 1)) != std::string::npos) return;
        failures.push_back(refusal_failure(
            "trace", error.empty() ? fmt::format("a ray with {} is traced", what)
                                   : fmt::format("a ray with {} is refused without its number: {}",
                                                 what, error)));
    };
    for (int axis = 0; axis < 3; ++axis) {
        for (const float value : {kNan, kInf, -kInf}) {
            const std::string of = fmt::format(".{} = {}", "xyz"[axis], value);
            refused("origin" + of, [&](reference::Ray& ray) { ray.origin[axis] = value; });
            refused("direction" + of, [&](reference::Ray& ray) { ray.direction[axis] = value; });
        }
    }
    refused("no direction", [](reference::Ray& ray) { ray.direction = reference::Vec3(0.0f); });
    refused("t_min = NaN", [](reference::Ray& ray) { ray.t_min = kNan; });
    refused("t_min below 0",
            [](reference::Ray& ray) { ray.t_min = -std::numeric_limits<float>::denorm_min(); });
    refused("t_max = NaN", [](reference::Ray& ray) { ray.t_max = kNan; });
    return failures;
}

std::vector<Failure> check_queue_refusal(const PipelineInput& input, const Backend& backend,
                                         std::span<const reference::Ray> rays, std::string* said) {
    PipelineInput broken = input;
    broken.parameters.batch_rays =
        std::max(input.parameters.batch_rays, static_cast<std::uint32_t>(rays.size()));
    // Below the root, and not its last. A queue of pairs has room for all children of all pairs.
    const bool has_queues = broken.bvh.level_begins.size() > 3 &&
                            broken.parameters.queues == reference::QueueKind::nodes;
    bool two_children = false;
    std::visit(
        [&](auto& nodes) {
            if (nodes.empty()) return;
            auto& root = nodes.front();
            two_children = root.child[1] != reference::kNone;
            for (const int slot : {0, 1}) {  // every ray enters both
                root.child[slot] = root.child[0];
                root.low_x[slot] = root.low_y[slot] = root.low_z[slot] = -1e30f;
                root.high_x[slot] = root.high_y[slot] = root.high_z[slot] = 1e30f;
            }
        },
        broken.bvh.inner);
    const bool living = std::any_of(rays.begin(), rays.end(), [](const reference::Ray& ray) {
        return ray.t_max > ray.t_min && ray.t_max > 1e20f;
    });
    if (!has_queues || !two_children || !living) return {};
    std::vector<reference::Hit> hits(rays.size());
    const std::string error = error_text(
        [&] { backend.pipeline(broken)->trace(rays, reference::TraversalKind::closest, hits); },
        said);
    const std::string room = fmt::format("node 1 has {} slots", rays.size());
    if (error.find(room) != std::string::npos &&
        error.find("rays were pushed") != std::string::npos) {
        return {};
    }
    return {refusal_failure(
        "trace", fmt::format("two children of the root that are one node overflow its queue: "
                             "expected an error about '{}', found '{}'",
                             room, error))};
}

}  // namespace scotty::verify
