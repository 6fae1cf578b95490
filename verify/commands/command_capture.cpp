/// scotty capture: the stages of a run, or only its input, as a directory.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <memory>
#include <optional>

#include "reference/base/error.h"
#include "verify/base/output_path.h"
#include "verify/base/progress.h"
#include "verify/capture/capture_writer.h"
#include "verify/capture/pipeline_input.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/diff/replay.h"

namespace scotty::verify {
namespace {

struct CaptureOptions {
    std::string scene;
    std::string output;
    BackendChoice backend;
    std::vector<std::string> stages;
    bool input_only = false;
    std::size_t threads = 0;
    reference::PipelineParameters parameters;
};

/// Passes stages on and says which.
class ShownObserver : public reference::StageObserver {
 public:
    ShownObserver(Progress& progress, reference::StageObserver& to)
        : progress_(progress), to_(to) {}
    void on_stage(const reference::StageView& stage) override {
        progress_.show(fmt::format("capturing {}", stage.name));
        to_.on_stage(stage);
    }
    void on_retry(std::string_view stage, std::string_view reason) override {
        spdlog::info("{} is run again: {}", stage, reason);
        to_.on_retry(stage, reason);
    }

 private:
    Progress& progress_;
    reference::StageObserver& to_;
};

int run_capture(const CaptureOptions& options) {
    reference::validate(options.parameters);
    const Backend backend = chosen_backend(options.backend, options.threads, options.parameters);
    expect_arithmetic(backend, options.parameters);
    std::optional<tbb::global_control> limit;
    if (options.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, options.threads);
    }
    PipelineInput input;
    input.scene = load_scene_argument(options.scene);
    for (const std::string& warning : input.scene.warnings) spdlog::warn("{}", warning);
    input.parameters = options.parameters;
    Progress progress;
    progress.show("building the BVH");
    input.bvh = build_wide_bvh(input.scene, bvh_parameters(input.parameters, options.threads));

    const std::string made_by = options.input_only ? "none" : backend.name;
    CaptureWriter writer(options.output,
                         header_of(made_by, input.scene, input.bvh, input.parameters),
                         options.stages);
    write_pipeline_input(writer.input_folder(), input.scene, input.bvh, input.parameters);
    if (!options.input_only) {
        ShownObserver shown(progress, writer);
        try {
            backend.render(input, &shown);
        } catch (const reference::Error&) {
            // What was captured until then is what tells why.
            progress.clear();
            const std::size_t stages = writer.stage_count();
            writer.finish();
            spdlog::warn("{} holds the {} stages until the error", options.output, stages);
            throw;
        }
        if (writer.stage_count() == 0) {
            throw reference::Error::bad_input(
                "--stages",
                "no stage has such a name; names look like primary_rays, "
                "bounce0/level3/intersect or bounce1/light0/resolve_light");
        }
    }
    progress.clear();
    const std::size_t stages = writer.stage_count();
    writer.finish();
    spdlog::info("{}: {} triangles, {} stages", options.output, input.scene.triangles.size(),
                 stages);
    return kExitPassed;
}

}  // namespace

void add_capture_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "capture", "Write the stages of a run, with all their buffers, into a directory.");
    command->footer(
        "Examples:\n"
        "  scotty capture coil -o coil.capture --size 32x32 --spp 1\n"
        "  scotty capture coil -o hits.capture --stages '*/merge_intersections'\n"
        "  scotty capture coil -o coil.input --input-only      (for scotty-gpu)\n\n"
        "Buffers are .npy files, which numpy.load() reads; index.json says what they are.\n"
        "A pattern with * or ? stands for whole names, one without for a part of the name.");
    auto options = std::make_shared<CaptureOptions>();
    options->parameters.image_width = 64;
    options->parameters.image_height = 64;
    options->parameters.spp = 1;
    command->add_option("scene", options->scene, "a built-in scene (scotty list) or a file")
        ->required();
    command->add_option("-o,--output", options->output, "the directory to write")
        ->required()
        ->check(output_folder());
    command->add_option("--stage,--stages", options->stages, "only stages of such names [all]")
        ->type_name("PATTERN");
    command->add_flag("--input-only", options->input_only,
                      "run nothing: write scene, BVH and parameters");
    add_backend_options(*command, options->backend, "emulator, simt or cuda: who runs the pipeline",
                        true);
    add_image_filter_options(*command, options->parameters);
    add_thread_option(*command, options->threads);
    add_picture_options(*command, options->parameters);
    add_pipeline_options(*command, options->parameters);
    add_pass_option(*command, options->parameters);
    add_arithmetic_option(*command, options->parameters);
    command->callback([&action, options] { action = [options] { return run_capture(*options); }; });
}

}  // namespace scotty::verify
