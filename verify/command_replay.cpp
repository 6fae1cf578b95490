/// scotty replay: one captured stage again, on its captured inputs.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "verify/command.h"
#include "verify/options.h"
#include "verify/replay.h"

namespace scotty::verify {
namespace {

struct ReplayCommand {
    std::string capture, stage;
    BackendChoice backend;
    bool json = false;
    std::size_t threads = 0;
};

std::string to_text_of_stage(const DiffReport& report) {
    std::string text = to_text(report) + "\n";
    for (const StageResult& stage : report.stages) {
        for (const BufferResult& buffer : stage.buffers) {
            text += fmt::format("{:<22}{}", buffer.name, to_string(buffer.verdict));
            if (buffer.different != 0) text += fmt::format(" ({} elements)", buffer.different);
            text += '\n';
        }
    }
    return text;
}

int run_replay(const ReplayCommand& options) {
    const Capture capture = Capture::open(options.capture);
    const DiffReport report =
        replay_stage(capture, options.stage,
                     chosen_backend(options.backend, options.threads, capture.header().parameters));
    print_result(options.json ? to_json(report).dump(2) : to_text_of_stage(report));
    return report.passed() ? kExitPassed : kExitFailed;
}

}  // namespace

void add_replay_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "replay", "Run one captured stage alone, and compare with what was captured of it.");
    command->footer(
        "Example:\n"
        "  scotty replay coil.cuda --stage bounce0/level3/intersect --backend emulator");
    auto options = std::make_shared<ReplayCommand>();
    command->add_option("capture", options->capture, "a capture")->required();
    command->add_option("--stage", options->stage, "the stage's whole name")->required();
    add_backend_options(*command, options->backend, "emulator, simt or cuda: who runs the stage",
                        true);
    command->add_flag("--json", options->json, "the result as JSON");
    add_thread_option(*command, options->threads);
    command->callback([&action, options] { action = [options] { return run_replay(*options); }; });
}

}  // namespace scotty::verify
