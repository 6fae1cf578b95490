/// Launch bookkeeping: names, times, and the observer.
#pragma once

#include <chrono>
#include <cstdint>
#include <utility>
#include <vector>

#include "emulation/device/watch.h"
#include "reference/contract/launch_record.h"
#include "reference/contract/stage_observer.h"

namespace scotty::emulation {

using reference::StagePlace;

class LaunchLog {
 public:
    explicit LaunchLog(reference::StageObserver* observer) : observer_(observer) {}

    /// Runs and times one launch.
    template <class Launch>
    void timed(reference::StageKind kind, const StagePlace& place, std::uint32_t blocks,
               std::uint64_t items, Launch&& launch) {
        Watch::name_launch(kind, place, records_.size());
        const auto begin = std::chrono::steady_clock::now();
        launch();
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - begin;
        records_.push_back({kind, place.batch, place.bounce, place.light, place.level, blocks,
                            items, taken.count()});
    }

    /// Shows what follows to another observer, and hands back the one before.
    reference::StageObserver* exchange_observer(reference::StageObserver* observer) {
        return std::exchange(observer_, observer);
    }
    bool wants(reference::StageKind kind) const {
        return observer_ != nullptr && observer_->wants(kind);
    }
    /// A stage view for the launch just recorded, to be filled with buffers.
    reference::StageView stage(reference::StageKind kind, const StagePlace& place,
                               std::uint32_t blocks, std::uint32_t threads) const {
        reference::StageView view;
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
    void show(const reference::StageView& view) { observer_->on_stage(view); }
    void batch(std::uint64_t done, std::uint64_t count) {
        if (observer_ != nullptr) observer_->on_batch(done, count);
    }
    void retry(const std::string& stage, const std::string& reason) {
        if (observer_ != nullptr) observer_->on_retry(stage, reason);
    }

    const std::vector<reference::LaunchRecord>& records() const { return records_; }
    void clear() { records_.clear(); }

 private:
    reference::StageObserver* observer_;
    std::vector<reference::LaunchRecord> records_;
};

}  // namespace scotty::emulation
