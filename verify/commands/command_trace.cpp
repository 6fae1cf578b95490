/// scotty trace: rays that came from elsewhere, through our traversal or Embree.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <chrono>
#include <memory>
#include <optional>

#include "reference/base/error.h"
#include "reference/truth/tracers.h"
#include "verify/backends/backend.h"
#include "verify/base/output_path.h"
#include "verify/base/progress.h"
#include "verify/capture/ray_file.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/oracles/ray_compare.h"

namespace scotty::verify {
namespace {

using reference::Hit;
using reference::HitCandidate;
using reference::Scene;

struct TraceOptions {
    std::string scene, rays, output, reference;
    BackendChoice backend;
    bool any_hit = false;
    std::size_t threads = 0;
    reference::PipelineParameters parameters;
};

std::vector<HitCandidate> trace_with_embree(const Scene& scene, const RayFile& rays) {
    const reference::EmbreeTracer tracer(scene);
    std::vector<HitCandidate> out(rays.rays.size());
    if (rays.any_hit) {
        std::vector<std::uint8_t> occluded(rays.rays.size());
        tracer.occluded(rays.rays, occluded);
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = {0.0f, occluded[i]};
        return out;
    }
    std::vector<Hit> hits(rays.rays.size());
    tracer.closest(rays.rays, hits);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = hit_record(hits[i], false);
    return out;
}

std::vector<HitCandidate> trace_with_pipeline(const TraceOptions& options, const Scene& scene,
                                              const RayFile& rays, Progress& progress) {
    const Backend backend = chosen_backend(options.backend, options.threads, options.parameters);
    expect_arithmetic(backend, options.parameters);
    progress.show("building the BVH");
    const PipelineInput input{
        scene, build_wide_bvh(scene, bvh_parameters(options.parameters, options.threads)),
        options.parameters};
    progress.show("tracing");
    std::vector<Hit> hits(rays.rays.size());
    backend.pipeline(input)->trace(
        rays.rays, rays.any_hit ? reference::TraversalKind::any : reference::TraversalKind::closest,
        hits);
    std::vector<HitCandidate> out(hits.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = hit_record(hits[i], rays.any_hit);
    return out;
}

int run_trace(const TraceOptions& options) {
    reference::validate(options.parameters);
    std::optional<tbb::global_control> limit;
    if (options.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, options.threads);
    }
    RayFile rays = read_rays(options.rays);
    rays.any_hit = rays.any_hit || options.any_hit;
    std::vector<HitCandidate> expected;
    if (!options.reference.empty()) {
        expected = read_reference(options.reference, rays.rays.size());
    }
    const Scene scene = load_scene_argument(options.scene);
    for (const std::string& warning : scene.warnings) spdlog::warn("{}", warning);

    Progress progress;
    const auto start = std::chrono::steady_clock::now();
    const std::vector<HitCandidate> hits =
        options.backend.name == "embree" ? trace_with_embree(scene, rays)
                                         : trace_with_pipeline(options, scene, rays, progress);
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    if (!options.output.empty()) write_hits(options.output, hits);
    spdlog::info("{}: {} {} rays in {:.2f} s, building included ({})", options.rays,
                 rays.rays.size(), rays.any_hit ? "any-hit" : "closest-hit", taken.count(),
                 options.backend.name);
    if (options.reference.empty()) return kExitPassed;
    progress.show("comparing");
    const HitComparison comparison = compare_hits(scene, rays, hits, expected);
    progress.clear();
    print_result(to_text(comparison));
    return comparison.passed() ? kExitPassed : kExitFailed;
}

}  // namespace

void add_trace_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("trace",
                                       "Trace rays from a file; compare hits with those "
                                       "of another tracer.");
    command->footer(
        "Example:\n"
        "  scotty trace --scene coil.scn --rays coil.primary.ray -o coil.hit "
        "--compare coil.primary.ref\n\n"
        "File formats: docs/captures.md. Differences from the reference are adjudicated in double\n"
        "precision: ties and grazing edges pass, a hit of ours that is wrong does not.");
    auto options = std::make_shared<TraceOptions>();
    options->parameters.batch_rays = 1u << 16;
    command
        ->add_option("--scene", options->scene, "a built-in scene, a file, or a .scn of triangles")
        ->required();
    command->add_option("--rays", options->rays, "the .ray file")->required();
    command->add_option("-o,--output", options->output, "the file of hits to write")
        ->check(output_file());
    add_backend_options(*command, options->backend, "who traces: emulator, embree, simt or cuda",
                        true);
    command->add_flag("--any", options->any_hit, "ask only whether something is hit");
    command->add_option("--compare", options->reference, "a .ref file to hold the hits against");
    command
        ->add_option("--leaf-size", options->parameters.max_leaf_size, "triangles a leaf, at most")
        ->capture_default_str()
        ->group("Pipeline");
    add_thread_option(*command, options->threads);
    add_pipeline_options(*command, options->parameters);
    add_arithmetic_option(*command, options->parameters);
    command->callback([&action, options] { action = [options] { return run_trace(*options); }; });
}

}  // namespace scotty::verify
