#include "verify/capture/replay_inputs.h"

#include <fmt/format.h>

#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "reference/contract/records.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

using reference::BufferView;
using reference::EarlyOut;
using reference::ElementType;
using reference::Error;
using reference::kNotApplicable;
using reference::OwnedBuffer;
using reference::StageKind;

namespace {

/// Fills in what one stage needs beyond its record.
class Preparation {
 public:
    Preparation(const Capture& capture, const StageRecord& record)
        : capture_(capture),
          record_(record),
          parameters_(capture.header().parameters),
          stage_(capture.load(record)) {}

    LoadedStage run() && {
        switch (record_.kind) {
            case StageKind::intersect_root:
            case StageKind::intersect:
                before_level();
                break;
            case StageKind::direct_light_rays:
                take_from(name(StageKind::primary_rays, kNotApplicable, kNotApplicable),
                          {"pixel", "sample"});
                break;
            case StageKind::resolve_light:
                take_from(radiance_writer(record_.bounce, record_.light), {"radiance"});
                break;
            case StageKind::scene_rays:
                take_from(name(StageKind::primary_rays, kNotApplicable, kNotApplicable),
                          {"pixel", "sample"});
                take_from(path_writer(record_.bounce), {"rays", "throughput", "flags", "depth"});
                take_from(radiance_writer(record_.bounce, parameters_.light_samples), {"radiance"});
                break;
            case StageKind::reconstruct_image:
                before_image();
                break;
            case StageKind::primary_rays:
            case StageKind::scan_counts:
            case StageKind::publish_minimum:
            case StageKind::merge_intersections:
            case StageKind::filter:
                break;  // functions of what is in their records
        }
        return std::move(stage_);
    }

 private:
    std::string name(StageKind kind, std::uint32_t bounce, std::uint32_t light,
                     std::uint32_t level = kNotApplicable, std::uint32_t back_batches = 0) const {
        return reference::stage_name(kind, record_.batch - back_batches, bounce, light, level,
                                     capture_.header().several_batches);
    }
    /// Who wrote the path state that vertex `bounce` begins with.
    std::string path_writer(std::uint32_t bounce) const {
        return bounce == 0 ? name(StageKind::primary_rays, kNotApplicable, kNotApplicable)
                           : name(StageKind::scene_rays, bounce - 1, kNotApplicable);
    }
    /// Who wrote the radiance last, before light sample `light` of that vertex.
    std::string radiance_writer(std::uint32_t bounce, std::uint32_t light) const {
        return light == 0 ? path_writer(bounce) : name(StageKind::resolve_light, bounce, light - 1);
    }

    const StageRecord& stage_named(const std::string& stage, const std::string& buffer) const {
        const StageRecord* found = capture_.find(stage);
        if (found != nullptr) return *found;
        throw Error::bad_input(
            capture_.directory().string(),
            fmt::format("running {} alone needs {} as {} left it, and that stage is not in the "
                        "capture; capture it too (--stages '{}' '{}'), or all stages",
                        record_.name, buffer, stage, record_.name, stage));
    }

    void take(const StageRecord& from, const BufferRecord* buffer, const std::string& wanted) {
        if (buffer == nullptr) {
            throw Error::bad_input(
                capture_.directory().string(),
                fmt::format("running {} alone needs {}, which {} of this capture does not show",
                            record_.name, wanted, from.name));
        }
        replace_input(capture_.load(from, *buffer));
    }

    void take_from(const std::string& stage, const std::vector<std::string>& buffers) {
        const StageRecord& from = stage_named(stage, buffers.front());
        for (const std::string& buffer : buffers) take(from, from.output(buffer), buffer);
    }

    void replace_input(OwnedBuffer buffer) {
        auto& inputs = stage_.view.inputs;
        std::erase_if(inputs, [&](const BufferView& view) { return view.name == buffer.name; });
        stage_.add_input(std::move(buffer));
    }

    void before_level() {
        if (record_.level == 0) {
            initial_hits();
        } else {
            const std::uint32_t level = record_.level - 1;
            const std::string before =
                name(level == 0 ? StageKind::intersect_root : StageKind::intersect, record_.bounce,
                     record_.light, level);
            if (parameters_.hit_mode == reference::HitMode::packed) {
                take_from(before, {"packed_hits"});
            } else {
                take_from(before, {"hit_counts", "hits"});
            }
            if (parameters_.early_out == EarlyOut::immediate) {
                // What a level shows is the minimum after its launch: the one before shows what
                // this one began with.
                const StageRecord& from = stage_named(before, "minimum");
                take(from, from.input("minimum"), "minimum");
            }
        }
        if (parameters_.early_out == EarlyOut::level) copy_minimum_to_lowered();
    }

    /// Nothing has been hit. Under `immediate` the root lowers nothing, so its minimum is as shown.
    void initial_hits() {
        if (const BufferRecord* packed = record_.output("packed_hits")) {
            fill(*packed, [](std::byte* at, std::size_t bytes) { std::memset(at, 0xff, bytes); });
        }
        if (const BufferRecord* counts = record_.output("hit_counts")) {
            fill(*counts, [](std::byte* at, std::size_t bytes) { std::memset(at, 0, bytes); });
        }
        if (const BufferRecord* hits = record_.output("hits")) {
            fill(*hits, [](std::byte* at, std::size_t bytes) {
                constexpr reference::HitCandidate kUnused{reference::kInfinity, reference::kNone};
                for (std::size_t i = 0; i + sizeof kUnused <= bytes; i += sizeof kUnused) {
                    std::memcpy(at + i, &kUnused, sizeof kUnused);
                }
            });
        }
    }

    template <class Fill>
    void fill(const BufferRecord& like, const Fill& fill_bytes) {
        OwnedBuffer buffer{like.name, like.type, like.shape, like.meaning, {}};
        buffer.bytes.resize(element_count(like.shape) * size_of(like.type));
        fill_bytes(buffer.bytes.data(), buffer.bytes.size());
        replace_input(std::move(buffer));
    }

    /// Between levels all that was lowered has been published.
    void copy_minimum_to_lowered() {
        for (const BufferView& view : stage_.view.inputs) {
            if (view.name != "minimum") continue;
            OwnedBuffer lowered = own(view);
            lowered.name = "lowered";
            replace_input(std::move(lowered));
            return;
        }
    }

    void before_image() {
        if (record_.batch > 0) {
            take_from(name(StageKind::reconstruct_image, kNotApplicable, kNotApplicable,
                           kNotApplicable, 1),
                      {"image"});
            return;
        }
        const BufferRecord* image = record_.output("image");
        if (image == nullptr) return;
        fill(*image, [](std::byte* at, std::size_t bytes) { std::memset(at, 0, bytes); });
    }

    const Capture& capture_;
    const StageRecord& record_;
    const reference::PipelineParameters& parameters_;
    LoadedStage stage_;
};

}  // namespace

LoadedStage prepare_stage(const Capture& capture, const StageRecord& stage) {
    return Preparation(capture, stage).run();
}

}  // namespace scotty::verify
