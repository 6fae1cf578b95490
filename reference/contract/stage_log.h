/// What every back end notes of its launches, and the observer that it shows them to.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "reference/contract/launch_record.h"
#include "reference/contract/stage_observer.h"

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
    /// A stage view for the launch just noted, to be filled with buffers.
    StageView stage(StageKind kind, const StagePlace& place, std::uint32_t blocks,
                    std::uint32_t threads) const {
        StageView view;
        view.name = place.name(kind);
        view.kind = kind;
        view.launch = static_cast<std::uint32_t>(records_.size() - 1);
        view.batch = place.batch;
        view.bounce = place.bounce;
        view.light = place.light;
        view.level = place.level;
        view.blocks = blocks;
        view.threads = threads;
        return view;
    }
    void show(const StageView& view) { observer_->on_stage(view); }
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
    StageObserver* observer_;
};

}  // namespace scotty::reference
