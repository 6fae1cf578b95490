/// Stages run alone: inputs are uploaded, the pipeline's own kernel is launched, outputs come back.
#include <algorithm>
#include <memory>
#include <string>

#include "gpu/host/device_scene.h"
#include "gpu/host/launch_log.h"
#include "gpu/host/launch_subtrees.h"
#include "gpu/host/pipeline_build.h"
#include "gpu/kernels/dialect.h"
#include "gpu/kernels/direct_light_rays.h"
#include "gpu/kernels/filter_bilateral.h"
#include "gpu/kernels/filter_gaussian.h"
#include "gpu/kernels/filter_median.h"
#include "gpu/kernels/intersect.h"
#include "gpu/kernels/intersect_root.h"
#include "gpu/kernels/merge_intersections.h"
#include "gpu/kernels/primary_rays.h"
#include "gpu/kernels/publish_minimum.h"
#include "gpu/kernels/reconstruct_image.h"
#include "gpu/kernels/resolve_light.h"
#include "gpu/kernels/scan_counts.h"
#include "gpu/kernels/scene_rays.h"
#include "reference/base/assert.h"
#include "reference/contract/stage_inputs.h"

namespace SCOTTY_DEVICE_NAMESPACE {

using reference::EarlyOut;
using reference::GatheredHits;
using reference::Hit;
using reference::HitCandidate;
using reference::HitMode;
using reference::LevelInput;
using reference::LevelNodes;
using reference::PipelineParameters;
using reference::Ray;
using reference::StageKind;
using reference::Vec3;

namespace {

/// More than one a multiprocessor and few enough that blocks take several logical blocks.
constexpr std::uint32_t kLevelBlocks = 256;

/// One stage's run: scene, buffers, and where the outputs go.
class StageRun {
 public:
    StageRun(const reference::Scene& scene, const reference::WideBvh& bvh,
             const PipelineParameters& parameters, const reference::StageView& stage)
        : bvh_(bvh),
          parameters_(parameters),
          stage_(stage),
          scene_(scene, bvh, budget_),
          buffers_(stage),
          path_(reference::path_parameters(parameters)) {}

    std::vector<reference::OwnedBuffer> run();

 private:
    /// Device memory of this run, freed with it.
    template <class T>
    struct Array {
        std::shared_ptr<DeviceMemory<T>> memory;
        T* data() const { return memory->data(); }
        std::size_t size() const { return memory->size(); }
    };
    template <class T>
    Array<T> upload(std::span<const T> host, const char* name) {
        Array<T> array{std::make_shared<DeviceMemory<T>>(budget_)};
        array.memory->upload(host, name);
        return array;
    }
    template <class T>
    Array<T> input(const char* name) {
        return upload(buffers_.input<T>(name), name);
    }
    template <class T>
    Array<T> input(const char* name, std::size_t count) {
        return upload(buffers_.input<T>(name, count), name);
    }
    /// Filled with 0xff bytes: what the kernel leaves alone shows.
    template <class T>
    Array<T> empty(std::size_t count, const char* name) {
        Array<T> array{std::make_shared<DeviceMemory<T>>(budget_)};
        array.memory->resize(count, name);
        check(cudaMemset(array.data(), 0xff, count * sizeof(T)), name);
        return array;
    }
    template <class T>
    Array<T> zeros(std::size_t count, const char* name) {
        Array<T> array = empty<T>(count, name);
        check(cudaMemset(array.data(), 0, count * sizeof(T)), name);
        return array;
    }
    template <class T>
    void output(const char* name, const Array<T>& array) {
        check(cudaDeviceSynchronize(), "running " + stage_.name);
        buffers_.output(name, download(array.data(), array.size(), name),
                        reference::buffer_info(name).meaning);
    }
    void launched() { check(cudaGetLastError(), "launching " + stage_.name); }

    struct HitArrays {
        Array<std::uint32_t> counts;
        Array<HitCandidate> candidates;
        Array<std::uint64_t> packed;
        HitView view;
    };
    HitArrays hit_arrays(const GatheredHits& hits) {
        HitArrays arrays{upload(std::span<const std::uint32_t>(hits.counts), "hit_counts"),
                         upload(std::span<const HitCandidate>(hits.candidates), "hits"),
                         upload(std::span<const std::uint64_t>(hits.packed), "packed_hits"),
                         {}};
        arrays.view = {parameters_.hit_mode == HitMode::packed ? 1u : 0u,
                       hits.capacity,
                       arrays.counts.data(),
                       arrays.candidates.data(),
                       arrays.packed.data(),
                       faults().data()};
        return arrays;
    }
    const Array<FaultView>& faults() {
        if (!faults_.memory) {
            faults_ = zeros<FaultView>(1, "fault flags");
        }
        return faults_;
    }
    Array<Hit> path_hits(std::size_t rays) {
        return upload(hits_of_scene(buffers_, "path_hits", rays, scene_.view().triangle_count),
                      "path_hits");
    }

    void primary();
    void scan();
    void level();
    template <int Width>
    void launch_level(const LevelView& view, const Array<Ray>& rays, const HitView& hits,
                      const MinimumView& minimum, std::uint32_t blocks);
    void publish();
    void merge();
    void direct_light();
    void resolve();
    void scatter();
    void reconstruct();
    void filter();

    const reference::WideBvh& bvh_;
    const PipelineParameters& parameters_;
    const reference::StageView& stage_;
    MemoryBudget budget_;
    DeviceScene scene_;
    reference::StageBuffers buffers_;
    reference::PathParameters path_;
    Array<FaultView> faults_;
};

std::vector<reference::OwnedBuffer> StageRun::run() {
    switch (stage_.kind) {
        case StageKind::primary_rays:
            primary();
            break;
        case StageKind::scan_counts:
            scan();
            break;
        case StageKind::intersect_root:
        case StageKind::intersect:
            level();
            break;
        case StageKind::publish_minimum:
            publish();
            break;
        case StageKind::merge_intersections:
            merge();
            break;
        case StageKind::direct_light_rays:
            direct_light();
            break;
        case StageKind::resolve_light:
            resolve();
            break;
        case StageKind::scene_rays:
            scatter();
            break;
        case StageKind::reconstruct_image:
            reconstruct();
            break;
        case StageKind::filter:
            filter();
            break;
    }
    return std::move(buffers_).take();
}

void StageRun::primary() {
    const BatchView view = batch_of(parameters_, stage_);
    const std::size_t n = std::size_t{view.pixels} * view.samples;
    const auto rays = empty<Ray>(n, "rays");
    const auto throughput = empty<Vec3>(n, "throughput");
    const auto radiance = empty<Vec3>(n, "radiance");
    const auto potential = empty<Vec3>(n, "potential");
    const auto pixel = empty<std::uint32_t>(n, "pixel");
    const auto sample = empty<std::uint32_t>(n, "sample");
    const auto depth = empty<std::uint32_t>(n, "depth");
    const auto flags = empty<std::uint32_t>(n, "flags");
    const PathView paths{rays.data(),  throughput.data(), radiance.data(), potential.data(),
                         pixel.data(), sample.data(),     depth.data(),    flags.data()};
    SCOTTY_LAUNCH(primary_rays, item_blocks(view.pixels), kItemThreads, nullptr, view,
                  scene_.view().camera, path_, paths);
    launched();
    output("rays", rays);
    output("throughput", throughput);
    output("radiance", radiance);
    output("potential", potential);
    output("pixel", pixel);
    output("sample", sample);
    output("depth", depth);
    output("flags", flags);
}

void StageRun::scan() {
    const LevelNodes nodes = nodes_of(bvh_, stage_);
    const auto counts = input<std::uint32_t>("node_counts", nodes.count);
    const auto block_offsets = empty<std::uint32_t>(nodes.count + 1, "block_offsets");
    const auto child_offsets = empty<std::uint32_t>(nodes.child_count + 1, "child_offsets");
    LevelView view{};
    view.first_node = nodes.first;
    view.node_count = nodes.count;
    view.first_child_node = nodes.first_child;
    view.child_node_count = nodes.child_count;
    view.queue_capacity = 0xffffffffu;
    view.parents = scene_.parent_positions() + nodes.first_child;
    view.node_counts = counts.data();
    view.block_offsets = block_offsets.data();
    view.child_offsets = child_offsets.data();
    view.faults = faults().data();
    const std::uint32_t blocks = scan_blocks(nodes.count, nodes.child_count);
    const auto tiles = zeros<std::uint64_t>(1 + blocks, "scan tiles");
    view.scan_ticket = reinterpret_cast<std::uint32_t*>(tiles.data());
    view.scan_tiles = tiles.data() + 1;
    SCOTTY_LAUNCH(scan_counts, blocks, kScanThreads, nullptr, view,
                  static_cast<std::uint32_t>(parameters_.rays_per_block));
    launched();
    output("block_offsets", block_offsets);
    output("child_offsets", child_offsets);
}

void StageRun::level() {
    const LevelNodes nodes = nodes_of(bvh_, stage_);
    const LevelInput in = level_input(buffers_, nodes, parameters_, stage_);
    const std::size_t n = in.rays.size();
    const GatheredHits gathered = gathered_hits(buffers_, parameters_, n);
    const HitArrays hits = hit_arrays(gathered);
    const EarlyOut policy = parameters_.early_out;
    Array<float> minimum, lowered;
    if (policy != EarlyOut::off) minimum = input<float>("minimum", n);
    lowered = policy == EarlyOut::level ? input<float>("lowered", n) : minimum;
    MinimumView minimum_view{};
    if (policy != EarlyOut::off) {
        const bool any = stage_.light != reference::kNotApplicable &&
                         parameters_.shadow_query == reference::ShadowQuery::any;
        minimum_view = {1, any ? 1u : 0u, minimum.data(), lowered.data()};
    }
    const auto rays = upload(in.rays, "rays");
    const auto node_counts = upload(in.node_counts, "node_counts");
    const auto queue_offsets = upload(in.queue_offsets, "queue_offsets");
    const auto queue = upload(in.queue, "queue");
    const auto block_offsets = upload(in.block_offsets, "block_offsets");
    const auto child_offsets = upload(in.child_offsets, "child_offsets");
    const auto child_queue = empty<std::uint32_t>(in.child_offsets.back(), "child_queue");
    const auto child_counts = empty<std::uint32_t>(nodes.child_count, "child_counts");
    check(cudaMemset(child_counts.data(), 0, nodes.child_count * 4), "clearing child_counts");
    const auto ray_ticket = zeros<RayTicket>(1, "ray ticket");
    const LevelView view{nodes.first,
                         nodes.count,
                         nodes.first_child,
                         nodes.child_count,
                         in.child_offsets.back(),
                         scene_.parent_positions() + nodes.first_child,
                         node_counts.data(),
                         queue_offsets.data(),
                         stage_.level == 0 ? nullptr : queue.data(),
                         block_offsets.data(),
                         child_counts.data(),
                         child_offsets.data(),
                         child_queue.data(),
                         nullptr,
                         nullptr,
                         faults().data(),
                         ray_ticket.data()};
    const std::uint32_t blocks = std::min(kLevelBlocks, in.block_offsets.back());
    switch (bvh_.width) {
        case 2:
            launch_level<2>(view, rays, hits.view, minimum_view, blocks);
            break;
        case 4:
            launch_level<4>(view, rays, hits.view, minimum_view, blocks);
            break;
        case 8:
            launch_level<8>(view, rays, hits.view, minimum_view, blocks);
            break;
        default:
            launch_level<16>(view, rays, hits.view, minimum_view, blocks);
            break;
    }
    output("child_counts", child_counts);
    output("child_queue", child_queue);
    if (parameters_.hit_mode == HitMode::packed) {
        output("packed_hits", hits.packed);
    } else {
        output("hit_counts", hits.counts);
        output("hits", hits.candidates);
        buffers_.shape_last({n, gathered.capacity, 2});
    }
    if (policy == EarlyOut::level) {
        output("lowered", lowered);
    } else if (policy == EarlyOut::immediate) {
        output("minimum", minimum);
    }
}

template <int Width>
void StageRun::launch_level(const LevelView& view, const Array<Ray>& rays, const HitView& hits,
                            const MinimumView& minimum, std::uint32_t blocks) {
    if (blocks == 0) return;
    const auto threads = static_cast<std::uint32_t>(parameters_.rays_per_block);
    const bool strided = parameters_.block_order == reference::BlockOrder::strided;
    if (bvh_.is_level_of_subtrees(stage_.level)) {
        launch_subtrees<Width>(
            {scene_.bvh<Width>(), rays.data(), view, hits, minimum}, blocks,
            {static_cast<std::uint32_t>(rays.size()), threads, strided, false, scene_.root()}, {},
            nullptr);
    } else if (stage_.kind == StageKind::intersect_root) {
        SCOTTY_LAUNCH(intersect_root<Width>, blocks, threads, nullptr, scene_.bvh<Width>(),
                      rays.data(), static_cast<std::uint32_t>(rays.size()), view, hits, minimum);
    } else {
        SCOTTY_LAUNCH(intersect<Width>, blocks, threads, nullptr, scene_.bvh<Width>(), rays.data(),
                      view, hits, minimum, strided);
    }
    launched();
}

void StageRun::publish() {
    const auto lowered = input<float>("lowered");
    const auto minimum = empty<float>(lowered.size(), "minimum");
    SCOTTY_LAUNCH(publish_minimum, item_blocks(lowered.size()), kItemThreads, nullptr,
                  static_cast<std::uint32_t>(lowered.size()), lowered.data(), minimum.data());
    launched();
    output("minimum", minimum);
}

void StageRun::merge() {
    const auto rays = input<Ray>("rays");
    const GatheredHits gathered = gathered_hits(buffers_, parameters_, rays.size());
    expect_primitives(buffers_, gathered, scene_.view().triangle_count);
    const HitArrays hits = hit_arrays(gathered);
    const auto merged = empty<Hit>(rays.size(), "merged");
    SCOTTY_LAUNCH(merge_intersections, item_blocks(rays.size()), kItemThreads, nullptr,
                  static_cast<std::uint32_t>(rays.size()), scene_.view(), rays.data(), hits.view,
                  merged.data());
    launched();
    output("merged", merged);
}

void StageRun::direct_light() {
    const auto rays = input<Ray>("rays");
    const std::size_t n = rays.size();
    const auto throughput = input<Vec3>("throughput", n);
    const auto flags = input<std::uint32_t>("flags", n);
    const auto pixel = input<std::uint32_t>("pixel", n);
    const auto sample = input<std::uint32_t>("sample", n);
    const auto hits = path_hits(n);
    const auto potential = empty<Vec3>(n, "potential");
    const auto shadow_rays = empty<Ray>(n, "shadow_rays");
    const PathView paths{rays.data(),  throughput.data(), nullptr, potential.data(),
                         pixel.data(), sample.data(),     nullptr, flags.data()};
    SCOTTY_LAUNCH(direct_light_rays, item_blocks(n), kItemThreads, nullptr,
                  static_cast<std::uint32_t>(n), scene_.view(), path_, stage_.bounce, stage_.light,
                  paths, hits.data(), shadow_rays.data());
    launched();
    output("shadow_rays", shadow_rays);
    output("potential", potential);
}

void StageRun::resolve() {
    const auto shadow_rays = input<Ray>("shadow_rays");
    const std::size_t n = shadow_rays.size();
    const auto hits = input<Hit>("shadow_hits", n);
    const auto potential = input<Vec3>("potential", n);
    const auto radiance = input<Vec3>("radiance", n);
    PathView paths{};
    paths.potential = potential.data();
    paths.radiance = radiance.data();
    SCOTTY_LAUNCH(resolve_light, item_blocks(n), kItemThreads, nullptr,
                  static_cast<std::uint32_t>(n), shadow_rays.data(), hits.data(), paths);
    launched();
    output("radiance", radiance);
}

void StageRun::scatter() {
    const auto rays = input<Ray>("rays");
    const std::size_t n = rays.size();
    const auto throughput = input<Vec3>("throughput", n);
    const auto radiance = input<Vec3>("radiance", n);
    const auto flags = input<std::uint32_t>("flags", n);
    const auto depth = input<std::uint32_t>("depth", n);
    const auto pixel = input<std::uint32_t>("pixel", n);
    const auto sample = input<std::uint32_t>("sample", n);
    const auto hits = path_hits(n);
    const PathView paths{rays.data(),  throughput.data(), radiance.data(), nullptr,
                         pixel.data(), sample.data(),     depth.data(),    flags.data()};
    SCOTTY_LAUNCH(scene_rays, item_blocks(n), kItemThreads, nullptr, static_cast<std::uint32_t>(n),
                  scene_.view(), path_, stage_.bounce, hits.data(), paths);
    launched();
    output("rays", rays);
    output("throughput", throughput);
    output("radiance", radiance);
    output("flags", flags);
    output("depth", depth);
}

void StageRun::reconstruct() {
    const BatchView view = batch_of(parameters_, stage_);
    const auto radiance = input<Vec3>("radiance", std::size_t{view.pixels} * view.samples);
    const auto image =
        input<Vec3>("image", std::size_t{parameters_.image_width} * parameters_.image_height);
    SCOTTY_LAUNCH(reconstruct_image, item_blocks(view.pixels), kItemThreads, nullptr, view,
                  parameters_.spp, radiance.data(), image.data());
    launched();
    output("image", image);
}

void StageRun::filter() {
    const std::uint32_t pixels = parameters_.image_width * parameters_.image_height;
    const auto image = input<Vec3>("image", pixels);
    const auto filtered = empty<Vec3>(pixels, "filtered");
    const FilterView view{parameters_.image_width, parameters_.image_height, image.data(),
                          filtered.data()};
    switch (parameters_.filter) {
        case reference::Filter::gaussian:
            SCOTTY_LAUNCH(filter_gaussian, item_blocks(pixels), kItemThreads, nullptr, view);
            break;
        case reference::Filter::bilateral:
            SCOTTY_LAUNCH(filter_bilateral, item_blocks(pixels), kItemThreads, nullptr, view);
            break;
        default:
            SCOTTY_LAUNCH(filter_median, item_blocks(pixels), kItemThreads, nullptr, view);
            break;
    }
    launched();
    output("filtered", filtered);
}

}  // namespace

std::vector<reference::OwnedBuffer> run_stage(const reference::Scene& scene,
                                              const reference::WideBvh& bvh,
                                              const PipelineParameters& parameters,
                                              const reference::StageView& stage) {
    SCOTTY_ASSERT(bvh.width, ==, parameters.width);
    return StageRun(scene, bvh, parameters, stage).run();
}

}  // namespace SCOTTY_DEVICE_NAMESPACE
