#include "verify/capture/replay_inputs.h"

#include <fmt/format.h>

#include <cstring>
#include <string>
#include <utility>

#include "reference/base/error.h"
#include "reference/contract/records.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using reference::BufferView;
using reference::ElementType;
using reference::Error;
using reference::kNotApplicable;
using reference::OwnedBuffer;
using reference::Source;
using reference::StageKind;
using reference::StageNeed;

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
        for (const StageNeed& need : reference::stage_info(record_.kind).needs) {
            if (applies(need.when, parameters_, record_.level)) supply(need);
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
    std::string level_before() const {
        const std::uint32_t level = record_.level - 1;
        return name(level == 0 ? StageKind::intersect_root : StageKind::intersect, record_.bounce,
                    record_.light, level);
    }

    void supply(const StageNeed& need) {
        const std::string buffer(need.buffer->name);
        switch (need.source) {
            case Source::blank:
                return blank(buffer);
            case Source::minimum:
                return copy_minimum_to_lowered();
            case Source::level_before:
                return take_from_level_before(buffer);
            case Source::primary_rays:
                return take_output(name(StageKind::primary_rays, kNotApplicable, kNotApplicable),
                                   buffer);
            case Source::vertex_before:
                return take_output(path_writer(record_.bounce), buffer);
            case Source::light_before:
                return take_output(radiance_writer(record_.bounce, record_.light), buffer);
            case Source::last_light:
                return take_output(radiance_writer(record_.bounce, parameters_.light_samples),
                                   buffer);
            case Source::batch_before:
                if (record_.batch == 0) return zeros(buffer);
                return take_output(name(StageKind::reconstruct_image, kNotApplicable,
                                        kNotApplicable, kNotApplicable, 1),
                                   buffer);
        }
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

    void take_output(const std::string& stage, const std::string& buffer) {
        const StageRecord& from = stage_named(stage, buffer);
        take(from, from.output(buffer), buffer);
    }

    /// What a level shows is the minimum after its launch: the level before shows, among its
    /// inputs, what this one began with.
    void take_from_level_before(const std::string& buffer) {
        const StageRecord& from = stage_named(level_before(), buffer);
        const BufferRecord* output = from.output(buffer);
        take(from, output != nullptr ? output : from.input(buffer), buffer);
    }

    void replace_input(OwnedBuffer buffer) {
        auto& inputs = stage_.view.inputs;
        std::erase_if(inputs, [&](const BufferView& view) { return view.name == buffer.name; });
        stage_.add_input(std::move(buffer));
    }

    /// Nothing is known yet: each row holds what the table calls blank.
    void blank(const std::string& wanted) {
        const BufferRecord* like = record_.output(wanted);
        if (like == nullptr) return;
        OwnedBuffer buffer = like_record(*like);
        const auto fields = reference::buffer_info(wanted).fields;
        for (std::size_t i = 0; i < buffer.bytes.size() / sizeof(std::uint32_t); ++i) {
            std::memcpy(buffer.bytes.data() + i * sizeof(std::uint32_t),
                        &fields[i % fields.size()].blank, sizeof(std::uint32_t));
        }
        replace_input(std::move(buffer));
    }
    void zeros(const std::string& wanted) {
        if (const BufferRecord* like = record_.output(wanted)) replace_input(like_record(*like));
    }
    /// Of that type and shape, zero.
    static OwnedBuffer like_record(const BufferRecord& like) {
        OwnedBuffer buffer{like.name, like.type, like.shape, like.meaning, {}};
        buffer.bytes.resize(element_count(like.shape) * size_of(like.type));
        return buffer;
    }

    /// Between levels all that was lowered has been published.
    void copy_minimum_to_lowered() {
        for (const BufferView& view : stage_.view.inputs) {
            if (view.name != buffers::minimum.name) continue;
            OwnedBuffer lowered = own(view);
            lowered.name = buffers::lowered.name;
            replace_input(std::move(lowered));
            return;
        }
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
