/// scotty render: one scene to one image file.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "reference/base/error.h"
#include "reference/contract/wide_bvh.h"
#include "scenes/scenes.h"
#include "verify/backends/backend.h"
#include "verify/base/progress.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/images/image_file.h"
#include "verify/render/render_defaults.h"
#include "verify/render/tev_display.h"
#include "verify/render/watched_render.h"

namespace scotty::verify {
namespace {

using reference::Image;
using reference::StageView;

struct RenderOptions {
    std::string scene;
    BackendChoice backend;
    RenderOutput output;
    bool progressive = false;
    std::size_t threads = 0;
    reference::PipelineParameters parameters;
    std::function<bool(std::string_view)> is_given;  ///< an option, on the command line
};

/// Says which batch is running.
class ProgressObserver : public reference::StageObserver {
 public:
    explicit ProgressObserver(Progress& progress) : progress_(progress) {}
    bool wants(reference::StageKind) const override { return false; }
    bool follows_launches() const override { return false; }
    void on_stage(const StageView&) override {}
    void on_batch(std::uint64_t done, std::uint64_t count) override {
        progress_.show("rendering: " + batch_text(done, count));
    }

 private:
    Progress& progress_;
};

Image render(const Backend& backend, const PipelineInput& input) {
    Progress progress;
    ProgressObserver observer(progress);
    return backend.render(input, &observer);
}

void warn_of_filter(const RenderOptions& options) {
    const reference::PipelineParameters& p = options.parameters;
    if (p.filter == reference::Filter::none) return;
    if (options.backend.name == "embree") {
        spdlog::warn("--filter is the pipeline's and is not applied by the Embree backend");
    } else if (p.spp >= p.filter_threshold && !options.progressive) {
        spdlog::warn(
            "--filter {} is not applied: {} samples a pixel are not below the threshold "
            "of {} (--filter-threshold)",
            to_string(p.filter), p.spp, p.filter_threshold);
    }
}

int run_render(RenderOptions options) {
    const auto start = std::chrono::steady_clock::now();
    reference::PipelineParameters& p = options.parameters;
    if (!options.output.display.empty()) {
        parse_display(options.output.display);
        options.progressive = true;
    }
    if (!options.progressive) p.samples_per_pass = 0;
    reference::validate(p);
    check_image_path(options.output.file);
    const bool by_embree = options.backend.name == "embree";
    const auto& names = backend_names();
    if (!by_embree && std::find(names.begin(), names.end(), options.backend.name) == names.end()) {
        throw reference::Error::bad_input(
            "--backend", fmt::format("expected one of {}, embree, found '{}'",
                                     fmt::join(names, ", "), options.backend.name));
    }
    const Backend backend = by_embree ? embree_backend(options.threads)
                                      : chosen_backend(options.backend, options.threads, p);
    if (!by_embree) expect_arithmetic(backend, p);
    // Whoever looks for a fault wants as much of the code as there is.
    const bool looks_for_faults = options.backend.check || !options.backend.plant.empty();
    if (!looks_for_faults) set_render_defaults(backend, p, options.is_given);
    std::optional<tbb::global_control> limit;
    if (options.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, options.threads);
    }
    PipelineInput input{scenes::load_scene(options.scene), {}, {}};
    for (const std::string& warning : input.scene.warnings) spdlog::warn("{}", warning);
    warn_of_filter(options);
    if (by_embree) {
        p.filter = reference::Filter::none;
    } else {
        Progress progress;
        progress.show("building the BVH");
        input.bvh = build_wide_bvh(input.scene, bvh_parameters(p, options.threads));
    }
    input.parameters = p;
    options.output.provenance = {{"scotty:scene", input.scene.name},
                                 {"scotty:backend", backend.name},
                                 {"scotty:parameters", to_json(p).dump()},
                                 {"scotty:version", SCOTTY_VERSION}};

    WatchedRender done;
    if (options.progressive) {
        done = render_watched(backend, input, options.output);
    } else {
        done.picture = {render(backend, input), p.spp};
        write_picture(options.output, p, done.picture.image, p.spp);
    }
    const auto& [picture, signal] = done;
    if (picture.samples == 0) {
        spdlog::warn("stopped ({}) before the first pass was complete: {} was not written",
                     strsignal(signal), options.output.file);
        return kExitStopped + signal;
    }
    spdlog::info("{}: {} triangles, {}x{} pixels, {} samples, {}, {:.1f} s", options.output.file,
                 input.scene.triangles.size(), picture.image.width, picture.image.height,
                 picture.samples, backend.name,
                 std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    if (signal == 0) return kExitPassed;
    spdlog::warn("stopped ({}) after {} of {} samples: {} is a whole image of {} samples",
                 strsignal(signal), picture.samples, p.spp, options.output.file, picture.samples);
    return kExitStopped + signal;
}

}  // namespace

void add_render_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("render", "Render a scene to an .exr, .png or .npy file.");
    command->footer(
        "Examples:\n"
        "  scotty render coil -o coil.png --size 640x400 --spp 16\n"
        "  scotty render CBspheres.dae -o spheres.exr --backend embree\n"
        "  scotty render spheres -o smooth.png --filter median --exposure 1\n"
        "  scotty render coil -o coil.exr --spp 4096 --progressive           # Ctrl-C when it is "
        "good\n"
        "  scotty render coil -o coil.exr --spp 4096 --display localhost:14158\n\n"
        "EXR holds linear radiance in float32, the variance of each pixel's mean, the samples per "
        "pixel, and scene, parameters, back end and version; PNG holds 8-bit sRGB of "
        "radiance * 2^exposure. NumPy's .npy holds linear radiance, with the variance in "
        "X.variance.npy and the rest in X.json beside it, and needs no library for images.\n\n"
        "Without --width, --queue-levels, --early-out, --hit-mode and --batch-rays each back end "
        "takes what is fastest for it, or with --check and --plant what verify begins with; the "
        "picture is the same. A progressive render is the same picture, too, bit for bit. Ctrl-C "
        "(or SIGTERM) ends it at the next batch: FILE then holds the last pass that every pixel "
        "had, which is the picture of that many --spp, and the exit code is 130 (143). A second "
        "Ctrl-C ends it at once; FILE is whole even so. --filter applies as long as there are "
        "fewer samples than "
        "--filter-threshold.");
    auto options = std::make_shared<RenderOptions>();
    options->parameters.samples_per_pass = 1;
    command->add_option("scene", options->scene, "a built-in scene (scotty list) or a file")
        ->required();
    command->add_option("-o,--output", options->output.file, "the .exr, .png or .npy file to write")
        ->required();
    add_backend_options(*command, options->backend,
                        "who traces the rays: emulator, embree, simt or cuda", true);
    command->add_option("--exposure", options->output.exposure, "PNG: brightness in powers of two")
        ->check(CLI::Range(-64.0f, 64.0f))
        ->capture_default_str();
    auto* progressive =
        command->add_flag("--progressive", options->progressive,
                          "refine the whole image pass by pass, and write it about once a second");
    command
        ->add_option("--samples-per-pass", options->parameters.samples_per_pass,
                     "--progressive: samples a pixel gets before all others have theirs; more are "
                     "quicker where the image is small")
        ->check(CLI::PositiveNumber)
        ->needs(progressive)
        ->capture_default_str();
    command
        ->add_option("--display", options->output.display,
                     "show the image in the viewer tev, running there (port 14158 unless given); "
                     "implies --progressive")
        ->type_name("HOST:PORT");
    add_image_filter_options(*command, options->parameters);
    add_thread_option(*command, options->threads);
    add_picture_options(*command, options->parameters);
    add_pipeline_options(*command, options->parameters, kBackendDefaults);
    add_arithmetic_option(*command, options->parameters);
    options->is_given = [command](std::string_view option) {
        return command->count(std::string(option)) != 0;
    };
    command->callback([&action, options] { action = [options] { return run_render(*options); }; });
}

}  // namespace scotty::verify
