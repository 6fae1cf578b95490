/// What the tests of golden verdicts share.
#pragma once

#include <string_view>

#include "tests/verify/stage_copies.h"
#include "verify/backends/backend.h"

namespace scotty::verify::test {

/// Shows an observer stages in which every path's radiance is `factor` times what it is.
class LightScaled : public reference::StageObserver {
 public:
    LightScaled(reference::StageObserver& to, float factor) : to_(to), factor_(factor) {}

    bool wants(reference::StageKind kind) const override { return to_.wants(kind); }
    void on_stage(const reference::StageView& stage) override {
        if (stage.kind != reference::StageKind::reconstruct_image) {
            to_.on_stage(stage);
            return;
        }
        StageCopies copies;
        copies.on_stage(stage);
        StageCopy& copy = copies.at(stage.name);
        for (float& value : copy.input<float>("radiance")) value *= factor_;
        for (float& value : copy.output<float>("image")) value *= factor_;
        copies.show_to(to_);
    }
    void on_retry(std::string_view stage, std::string_view reason) override {
        to_.on_retry(stage, reason);
    }

 private:
    reference::StageObserver& to_;
    float factor_;
};

/// The emulator, but every path's radiance is `factor` times what it should be.
inline Backend with_light_scaled(float factor) {
    return render_only(
        "emulator",
        [factor](const reference::Scene& scene, const reference::WideBvh& bvh,
                 const reference::PipelineParameters& p, reference::StageObserver* observer) {
            LightScaled scaled(*observer, factor);
            reference::Image image =
                backend_named("emulator", 0).make(scene, bvh, p, {.observer = &scaled})->render();
            for (reference::Vec3& pixel : image.pixels) pixel *= factor;
            return image;
        });
}

}  // namespace scotty::verify::test
