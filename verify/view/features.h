/// What stages give besides the picture, for one sample of each pixel: false colours and paths.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "reference/contract/scene.h"
#include "reference/contract/stage_observer.h"
#include "verify/view/display.h"

namespace scotty::verify {

/// Watches a render of one sample, and keeps a number for each pixel.
class FeatureObserver : public reference::StageObserver {
 public:
    /// `subject` is one that stages give: distance, primitive, normal, queues or bounces.
    FeatureObserver(const reference::Scene& scene, std::uint32_t width, std::uint32_t height,
                    ViewSubject subject);

    bool wants(reference::StageKind kind) const override;
    /// Queues are seen only where every launch is followed.
    bool follows_launches() const override { return image_.subject == ViewSubject::queues; }
    void on_stage(const reference::StageView& stage) override;
    void on_retry(std::string_view stage, std::string_view reason) override;

    /// After the render.
    FeatureImage take();
    /// Of ViewSubject::queues: entries of the primary rays' queues, level by level.
    const std::vector<std::uint64_t>& queue_lengths() const { return lengths_; }

 private:
    void take_hits(const reference::StageView& stage);
    void count_queues(const reference::StageView& stage);

    const reference::Scene& scene_;
    FeatureImage image_;
    std::vector<std::uint32_t> pixel_;  ///< by ray of the batch in flight
    std::vector<std::uint32_t> counts_;
    std::vector<std::uint64_t> lengths_, in_flight_;  ///< of finished traversals; of the one now
};

/// A path, vertex by vertex.
struct PathVertex {
    reference::Vec3 position{0.0f, 0.0f, 0.0f};
    std::uint32_t primitive = reference::kNone;
    float distance = 0.0f;  ///< from the vertex before
    /// Shadow rays from here: where they end, and whether something is in the way.
    struct Light {
        reference::Vec3 end{0.0f, 0.0f, 0.0f};
        bool blocked = false;
    };
    std::vector<Light> lights = {};
};
struct TracedPath {
    std::uint32_t batch = 0, ray = 0;
    reference::Vec3 origin{0.0f, 0.0f, 0.0f};
    std::vector<PathVertex> vertices;
    bool escaped = false;                                ///< the last ray hit nothing
    reference::Vec3 escape_direction{0.0f, 0.0f, 0.0f};  ///< of that ray
};

/// Watches a render of one sample, and keeps the path of one pixel.
class PathObserver : public reference::StageObserver {
 public:
    explicit PathObserver(std::uint32_t pixel) : wanted_(pixel) {}

    bool wants(reference::StageKind kind) const override;
    bool follows_launches() const override { return true; }
    void on_stage(const reference::StageView& stage) override;

    const TracedPath& path() const { return path_; }

 private:
    std::uint32_t wanted_;
    bool here_ = false;  ///< the pixel's ray is in the batch in flight
    bool alive_ = true;
    TracedPath path_;
};

}  // namespace scotty::verify
