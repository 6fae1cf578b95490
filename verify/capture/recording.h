/// What a run of the pipeline is compared by: rays and hits of every traversal, radiance, image.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "reference/contract/image.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/records.h"
#include "reference/contract/stage_observer.h"
#include "verify/capture/failure.h"

namespace scotty::verify {

/// Everything here is by path: index = pixel * spp + sample, whatever batch a path ran in.
struct TraversalRecord {
    std::uint32_t bounce = 0;
    std::uint32_t light = reference::kNotApplicable;
    std::vector<reference::Ray> rays;  ///< dead_ray() for paths that were not traced
    std::vector<reference::Hit> hits;

    bool is_shadow() const { return light != reference::kNotApplicable; }
    /// "bounce1/light0/merge_intersections": where its hits come from.
    std::string stage() const;
};

struct Recording {
    std::vector<TraversalRecord> traversals;  ///< in the order in which they ran
    std::vector<reference::Vec3> radiance;
    reference::Image image;
    /// What the last reconstruct_image and the filter have shown; empty where none was.
    std::vector<reference::Vec3> reconstructed;
    std::vector<reference::Vec3> filtered;

    /// Rays traced, without the dead.
    std::uint64_t living_rays() const;
};

/// Fills a Recording while the pipeline renders. The image is the caller's to add.
class Recorder : public reference::StageObserver {
 public:
    Recorder(const reference::PipelineParameters& parameters, Recording& recording);
    bool wants(reference::StageKind kind) const override;
    void on_stage(const reference::StageView& stage) override;

 private:
    TraversalRecord& record_of(std::uint32_t bounce, std::uint32_t light);

    std::size_t paths_;
    std::uint32_t spp_;
    Recording& recording_;
    std::vector<std::uint32_t> path_of_;  ///< by ray id of the batch
};

/// Shows every stage to several observers.
class Observers : public reference::StageObserver {
 public:
    explicit Observers(std::vector<reference::StageObserver*> observers)
        : observers_(std::move(observers)) {}
    bool wants(reference::StageKind kind) const override;
    bool follows_launches() const override;
    void on_batch(std::uint64_t done, std::uint64_t count) override;
    void on_stage(const reference::StageView& stage) override;
    void on_retry(std::string_view stage, std::string_view reason) override;

 private:
    std::vector<reference::StageObserver*> observers_;
};

/// Bit for bit: rays and merged hits of every traversal, radiance, image and variance.
/// `occlusion_only`: of shadow rays only whether something was hit. At most one failure each for
/// rays, hits, radiance and image, in the order in which they arose.
std::vector<Failure> compare(const Recording& baseline, const Recording& other, bool occlusion_only,
                             std::uint32_t spp);
/// The first pixel whose bits differ; images of one size.
std::optional<Failure> compare_images(const reference::Image& baseline,
                                      const reference::Image& other, std::uint32_t spp);

}  // namespace scotty::verify
