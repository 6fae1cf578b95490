/// The order of a render's launches, once for all back ends; how a stage is launched is theirs.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "reference/contract/pipeline_interface.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/stage_log.h"
#include "reference/contract/views.h"

namespace scotty::reference {

class StagedPipeline : public PipelineInterface {
 public:
    std::vector<OwnedBuffer> run_stage(const StageView& stage) final;
    void look(const Camera& camera, const PipelineParameters& parameters) final;

 protected:
    /// Throws bad_input where the parameters are not valid.
    StagedPipeline(const PipelineParameters& parameters, std::uint32_t triangle_count);

    /// All launches of a render, batch by batch, and the filter. Image and variance are zero
    /// before.
    void launch_render();
    bool filters() const;
    TraversalKind shadow_query() const {
        return parameters_.shadow_query == ShadowQuery::any ? TraversalKind::any
                                                            : TraversalKind::closest;
    }
    /// A filtered image has no variance, since neighbours share their noise; nor has one sample.
    bool knows_variance() const { return !filters() && parameters_.spp > 1; }
    std::uint32_t pixel_count() const { return parameters_.image_width * parameters_.image_height; }
    /// Throws bad_input naming the ray that traversal cannot take.
    static void expect_traceable(std::span<const Ray> rays);

    /// From the hits of the paths' rays to those of the next: light samples, scattering, traversal.
    /// A back end may have another way for renders that nobody follows.
    virtual void shade_vertex(StagePlace place);

    /// Batches of half as many rays, now and after every look().
    void halve_batches() { most_batch_rays_ = parameters_.batch_rays /= 2; }

    PipelineParameters parameters_;

 private:
    /// The camera of later renders, which are of parameters_.
    virtual void take_view(const Camera& camera) = 0;
    virtual StageLog& log() = 0;
    /// Makes room for the paths in flight.
    virtual void resize_paths(std::size_t rays) = 0;
    virtual void launch_primary_rays(const StagePlace& place, const BatchView& batch) = 0;
    virtual void launch_direct_light(const StagePlace& place) = 0;
    virtual void launch_resolve_light(const StagePlace& place) = 0;
    virtual void launch_scene_rays(const StagePlace& place) = 0;
    virtual void launch_reconstruct(const StagePlace& place, const BatchView& batch) = 0;
    virtual void launch_filter() = 0;
    /// Returns when all that was launched is complete.
    virtual void wait() = 0;
    /// From the paths' rays to their hits.
    virtual void trace_paths(const StagePlace& place) = 0;
    /// From shadow rays to the radiance that they let through, resolve_light included.
    virtual void trace_shadow_rays(const StagePlace& place, TraversalKind kind) = 0;

    // For a stage that is run alone.

    /// What the stage reads of path state comes from its view; the rest has the size of it.
    virtual void load_paths(const StageView& stage, std::size_t rays) = 0;
    /// The same for image and variance.
    virtual void load_image(const StageView& stage) = 0;
    virtual void run_traversal_stage(const StageView& stage) = 0;

    void launch_batch(StagePlace place, const BatchView& batch);
    void launch_alone(const StageView& stage);
    void load_paths_of(const StageView& stage, const Buffer<Ray>& rays);

    std::uint32_t triangle_count_;
    std::uint32_t most_batch_rays_ = kNotApplicable;  ///< that fit the memory
};

}  // namespace scotty::reference
