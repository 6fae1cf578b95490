/// scotty replay: one captured stage again, on its captured inputs.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "verify/backends/checked_program.h"
#include "verify/base/output_path.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/diff/replay.h"
#include "verify/schedules/interleave.h"

namespace scotty::verify {
namespace {

struct ReplayCommand {
    std::string capture, stage;
    BackendChoice backend;
    JsonOutput json;
    std::size_t threads = 0;
    bool interleave = false;
    std::uint32_t preemptions = 0;
    emulation::simt::ExploreOptions orders;
    std::string save = "scotty.interleaving";
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

/// Orders of the stage's blocks: all, or the one of a file.
int run_orders(const ReplayCommand& options) {
    if (options.backend.name != "simt") {
        throw reference::Error::bad_input(
            "--backend", "orders of memory accesses are of simt, found " + options.backend.name);
    }
    become_checked_program();
    const Capture capture = Capture::open(options.capture);
    const auto say = [&](const auto& report, bool passed) {
        print_result(options.json, to_json(report).dump(2), to_text(report));
        return passed ? kExitPassed : kExitFailed;
    };
    if (!options.backend.interleaving.empty()) {
        const auto report =
            replay_interleaved(capture, options.stage, options.backend.interleaving);
        return say(report, report.same);
    }
    const auto report = interleave_stage(capture, options.stage, options.orders, options.save);
    return say(report, report.passed());
}

int run_replay(const ReplayCommand& options) {
    if (options.interleave || !options.backend.interleaving.empty()) return run_orders(options);
    const Capture capture = Capture::open(options.capture);
    const DiffReport report =
        replay_stage(capture, options.stage,
                     chosen_backend(options.backend, options.threads, capture.header().parameters));
    print_result(options.json, to_json(report).dump(2), to_text_of_stage(report));
    return report.passed() ? kExitPassed : kExitFailed;
}

}  // namespace

void add_replay_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "replay", "Run one captured stage alone, and compare with what was captured of it.");
    command->footer(
        "Examples:\n"
        "  scotty replay coil.cuda --stage bounce0/level3/intersect --backend emulator\n"
        "  scotty replay tiny --stage bounce0/level0/intersect_root --backend simt --interleave\n"
        "                                               blocks switched in their middle, in every "
        "order\n"
        "  scotty replay tiny --stage bounce0/level0/intersect_root --backend simt \\\n"
        "      --schedule scotty.interleaving           the order that failed");
    auto options = std::make_shared<ReplayCommand>();
    command->add_option("capture", options->capture, "a capture")->required();
    command->add_option("--stage", options->stage, "the stage's whole name")->required();
    add_backend_options(*command, options->backend, "emulator, simt or cuda: who runs the stage",
                        true);
    add_json_option(*command, options->json);
    auto* interleave = command->add_flag(
        "--interleave", options->interleave,
        "with simt: every order in which the blocks can touch memory that they share; the outcome "
        "has to be that of one block after the other");
    auto* preemptions =
        command
            ->add_option("--preemptions", options->preemptions,
                         "only orders in which blocks are preempted so often, at most")
            ->needs(interleave);
    command->add_option("--most", options->orders.most_schedules, "orders after which it gives up")
        ->capture_default_str()
        ->needs(interleave);
    command->add_option("--save", options->save, "where a failing order goes")
        ->type_name("FILE")
        ->check(output_file())
        ->capture_default_str()
        ->needs(interleave);
    add_thread_option(*command, options->threads);
    command->callback([&action, options, preemptions] {
        if (preemptions->count() != 0) options->orders.preemptions = options->preemptions;
        action = [options] { return run_replay(*options); };
    });
}

}  // namespace scotty::verify
