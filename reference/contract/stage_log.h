/// What every back end notes of its launches, and the observer that it shows them to.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "reference/contract/launch_record.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/stage_observer.h"
#include "reference/contract/stages.h"

namespace scotty::reference {

class StageLog {
 public:
    explicit StageLog(StageObserver* observer) : observer_(observer) {}

    /// Shows what follows to another observer, and hands back the one before.
    StageObserver* exchange_observer(StageObserver* observer) {
        return std::exchange(observer_, observer);
    }
    StageObserver* observer() const { return observer_; }
    /// Whether somebody follows every launch.
    bool observed() const { return observer_ != nullptr && observer_->follows_launches(); }
    bool wants(StageKind kind) const { return observer_ != nullptr && observer_->wants(kind); }
    /// Shows the launch just noted, where the observer wants it, with the buffers of its stage's
    /// table; with `alone` also what it lowers. `view_of(const BufferInfo&)` is a BufferView that
    /// stays valid during the call.
    template <class ViewOf>
    void show(const PipelineParameters& parameters, StageKind kind, const StagePlace& place,
              std::uint32_t blocks, std::uint32_t threads, const ViewOf& view_of,
              bool alone = false) {
        if (!wants(kind)) return;
        StageView view = stage(kind, place);
        if (kind == StageKind::filter) {
            view.name = std::string("filter_") + to_string(parameters.filter);
        }
        view.blocks = blocks;
        view.threads = threads;
        const auto add = [&](std::vector<BufferView>& to, const auto& table) {
            for (const StageBuffer& each : table) {
                if (applies(each.when, parameters, place.level))
                    to.push_back(view_of(*each.buffer));
            }
        };
        const StageInfo& info = stage_info(kind);
        add(view.inputs, info.inputs);
        add(view.outputs, info.outputs);
        if (alone) add(view.outputs, info.lowers);
        observer_->on_stage(view);
    }
    void retry(const std::string& stage, const std::string& reason) {
        if (observer_ != nullptr) observer_->on_retry(stage, reason);
    }

    const std::vector<LaunchRecord>& records() const { return records_; }
    void clear() { records_.clear(); }

 protected:
    void note(StageKind kind, const StagePlace& place, std::uint32_t blocks, std::uint64_t items,
              double seconds) {
        records_.push_back(
            {kind, place.batch, place.bounce, place.light, place.level, blocks, items, seconds});
    }
    std::vector<LaunchRecord> records_;

 private:
    StageView stage(StageKind kind, const StagePlace& place) const {
        StageView view;
        view.name = place.name(kind);
        view.kind = kind;
        view.launch = static_cast<std::uint32_t>(records_.size() - 1);
        view.batch = place.batch;
        view.bounce = place.bounce;
        view.light = place.light;
        view.level = place.level;
        return view;
    }

    StageObserver* observer_;
};

}  // namespace scotty::reference
