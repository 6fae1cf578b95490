/// scotty render: one scene to one image file.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "reference/embree_renderer.h"
#include "reference/error.h"
#include "reference/tracers.h"
#include "reference/wide_bvh.h"
#include "scenes/scenes.h"
#include "verify/backend.h"
#include "verify/command.h"
#include "verify/image_file.h"
#include "verify/options.h"
#include "verify/progress.h"

namespace scotty::verify {
namespace {

using reference::Image;
using reference::StageView;

struct RenderOptions {
    std::string scene;
    std::string output;
    BackendChoice backend;
    float exposure = 0.0f;
    std::size_t threads = 0;
    reference::PipelineParameters parameters;
};

/// Says which launch is running. Wants one cheap stage kind a bounce, so that nothing is prepared
/// for it that is not shown.
class ProgressObserver : public reference::StageObserver {
 public:
    ProgressObserver(Progress& progress, const reference::PipelineParameters& p)
        : progress_(progress) {
        const std::uint64_t paths = std::uint64_t{p.image_width} * p.image_height * p.spp;
        batches_ = (paths + p.batch_rays - 1) / p.batch_rays;
    }
    bool wants(reference::StageKind kind) const override {
        return kind == reference::StageKind::scan_counts ||
               kind == reference::StageKind::scene_rays;
    }
    void on_stage(const StageView& stage) override {
        progress_.show(fmt::format("rendering: batch {} of about {}, {}", stage.batch + 1, batches_,
                                   stage.name));
    }

 private:
    Progress& progress_;
    std::uint64_t batches_;
};

Image render(const RenderOptions& options, reference::Scene scene) {
    Progress progress;
    if (options.backend.name == "embree") {
        const reference::EmbreeTracer tracer(scene);
        progress.show("rendering with Embree");
        return render_with_embree(scene, options.parameters, tracer, options.threads);
    }
    progress.show("building the BVH");
    const Backend backend = chosen_backend(options.backend, options.threads, options.parameters);
    reference::WideBvh bvh =
        build_wide_bvh(scene, bvh_parameters(options.parameters, options.threads));
    const PipelineInput input{std::move(scene), std::move(bvh), options.parameters};
    ProgressObserver observer(progress, options.parameters);
    return backend.render(input, &observer);
}

/// An EXR says how many paths a pixel has, unless a filter mixed pixels: `scotty diff` can then
/// judge it by a golden image's noise.
void write(const RenderOptions& options, const Image& image) {
    const reference::PipelineParameters& p = options.parameters;
    const bool filtered = options.backend.name != "embree" && p.filter != reference::Filter::none &&
                          p.spp < p.filter_threshold;
    if (std::filesystem::path(options.output).extension() != ".exr" || filtered) {
        write_image(image, options.output, options.exposure);
        return;
    }
    MeasuredImage measured{image.width, image.height, {}, {}, p.spp, 1};
    measured.mean.reserve(image.pixels.size());
    for (const reference::Vec3& pixel : image.pixels) {
        measured.mean.push_back({pixel.x, pixel.y, pixel.z});
    }
    write_measured_image(measured, options.output);
}

int run_render(const RenderOptions& options) {
    const auto start = std::chrono::steady_clock::now();
    reference::validate(options.parameters);
    check_image_path(options.output);
    if (options.backend.name != "embree") {
        expect_arithmetic(chosen_backend(options.backend, options.threads, options.parameters),
                          options.parameters);
    }
    std::optional<tbb::global_control> limit;
    if (options.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, options.threads);
    }
    reference::Scene scene = scenes::load_scene(options.scene);
    for (const std::string& warning : scene.warnings) spdlog::warn("{}", warning);
    const bool filtered = options.parameters.filter != reference::Filter::none;
    if (filtered && options.backend.name == "embree") {
        spdlog::warn("--filter is the pipeline's and is not applied by the Embree backend");
    } else if (filtered && options.parameters.spp >= options.parameters.filter_threshold) {
        spdlog::warn(
            "--filter {} is not applied: {} samples a pixel are not below the threshold "
            "of {} (--filter-threshold)",
            to_string(options.parameters.filter), options.parameters.spp,
            options.parameters.filter_threshold);
    }
    const std::size_t triangles = scene.triangles.size();
    const Image image = render(options, std::move(scene));
    write(options, image);
    spdlog::info("{}: {} triangles, {}x{} pixels, {} samples, {}, {:.1f} s", options.output,
                 triangles, image.width, image.height, options.parameters.spp, options.backend.name,
                 std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    return kExitPassed;
}

}  // namespace

void add_render_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("render", "Render a scene to an .exr or .png file.");
    command->footer(
        "Examples:\n"
        "  scotty render coil -o coil.png --size 640x400 --spp 16\n"
        "  scotty render CBspheres.dae -o spheres.exr --backend embree\n"
        "  scotty render spheres -o smooth.png --filter median --exposure 1\n\n"
        "EXR holds linear radiance in float32, and the samples a pixel; PNG holds 8-bit sRGB of "
        "radiance * 2^exposure.");
    auto options = std::make_shared<RenderOptions>();
    command->add_option("scene", options->scene, "a built-in scene (scotty list) or a file")
        ->required();
    command->add_option("-o,--output", options->output, "the .exr or .png file to write")
        ->required();
    add_backend_options(*command, options->backend,
                        "who traces the rays: emulator, embree, simt or cuda", true);
    command->add_option("--exposure", options->exposure, "PNG: brightness in powers of two")
        ->check(CLI::Range(-64.0f, 64.0f))
        ->capture_default_str();
    command
        ->add_option_function<std::string>(
            "--filter",
            [options](const std::string& word) {
                options->parameters.filter = reference::parse_filter(word);
            },
            "smooth a noisy image [none]")
        ->type_name("none|gaussian|bilateral|median");
    command
        ->add_option("--filter-threshold", options->parameters.filter_threshold,
                     "a filter is applied only below so many samples a pixel")
        ->capture_default_str();
    add_thread_option(*command, options->threads);
    add_picture_options(*command, options->parameters);
    add_pipeline_options(*command, options->parameters);
    add_arithmetic_option(*command, options->parameters);
    command->callback([&action, options] { action = [options] { return run_render(*options); }; });
}

}  // namespace scotty::verify
