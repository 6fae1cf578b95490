/// scotty view: a live, interactive view of a scene, in the browser.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "reference/base/error.h"
#include "scenes/viewpoints.h"
#include "verify/base/stop_signal.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/render/render_defaults.h"
#include "verify/view/view_library.h"
#include "verify/view/view_session.h"

namespace scotty::verify {
namespace {

struct ViewCommand {
    std::string scene;
    ViewState state;
    ViewOptions options;
    std::function<bool(std::string_view)> is_given;
};

/// Fails before a scene is loaded; for cuda the program goes on as scotty-cuda.
void expect_backend(const std::string& name) {
    if (name == "embree") return;
    const Backend backend = backend_named(name, 0);
}

int run_view(ViewCommand command) {
    expect_backend(command.state.backend);
    view_module();
    reference::PipelineParameters& p = command.state.parameters;
    if (command.state.backend == "simt" && !command.is_given("--size")) {
        p.image_width = 160;
        p.image_height = 120;
    }
    reference::validate(p);
    std::optional<tbb::global_control> limit;
    if (command.options.loop.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, command.options.loop.threads);
    }
    reference::Scene scene = scenes::load_scene(command.scene, command.options.viewpoints);
    for (const std::string& warning : scene.warnings) spdlog::warn("{}", warning);
    command.options.version = SCOTTY_VERSION;
    command.options.loop.is_given = command.is_given;
    const StopSignals signals;
    const ViewSession session(std::move(scene), command.state, command.options);
    print_result(session.link());
    spdlog::info(
        "open the link in a browser; Ctrl-C ends the view. From another machine: ssh -L "
        "PORT:127.0.0.1:PORT, and the same link");
    while (signals.received() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return kExitPassed;
}

}  // namespace

void add_view_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand("view", "Look at a scene live, in the browser.");
    command->footer(
        "Examples:\n"
        "  scotty view coil                                   # then open the link it prints\n"
        "  scotty view CBspheres.dae --backend cuda --size 1024x1024\n"
        "  scotty view coil --port 8080                       # for ssh -L 8080:127.0.0.1:8080\n"
        "  scotty view 'coil#camera=mine.camera'              # from a camera that was saved\n\n"
        "The picture is refined up to --spp samples while nothing moves, and is then the one of "
        "scotty render, bit for bit. The view listens on this machine only, and answers only who "
        "has the link with its token. Ctrl-C ends it, with exit code 0. See docs/view.md.");
    auto options = std::make_shared<ViewCommand>();
    ViewState& state = options->state;
    state.backend = "emulator";
    state.parameters.image_width = 512;
    state.parameters.image_height = 384;
    state.parameters.spp = 256;
    state.parameters.filter = reference::Filter::median;
    command->add_option("scene", options->scene, "a built-in scene (scotty list) or a file")
        ->required();
    command->add_option("--backend", state.backend, "who renders: emulator, embree, simt or cuda")
        ->capture_default_str();
    command->add_option("--port", options->options.port, "where it listens; 0: any free port")
        ->capture_default_str();
    command
        ->add_option("--listen", options->options.address,
                     "the address to listen on; one beyond this machine lets others see the link")
        ->type_name("ADDRESS")
        ->capture_default_str();
    command
        ->add_option("--frame-rate", options->options.loop.frame_rate,
                     "frames a second for which a moving picture gives up resolution")
        ->check(CLI::Range(1.0, 240.0))
        ->capture_default_str();
    add_image_filter_options(*command, state.parameters);
    add_thread_option(*command, options->options.loop.threads);
    add_picture_options(*command, state.parameters);
    add_pipeline_options(*command, state.parameters, kBackendDefaults);
    add_arithmetic_option(*command, state.parameters);
    options->is_given = [command](std::string_view option) {
        return command->count(std::string(option)) != 0;
    };
    command->callback([&action, options] { action = [options] { return run_view(*options); }; });
}

}  // namespace scotty::verify
