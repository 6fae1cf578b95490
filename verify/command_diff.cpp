/// scotty diff: two captures, or a capture and a fresh run, launch by launch.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "reference/error.h"
#include "verify/command.h"
#include "verify/diff.h"
#include "verify/options.h"
#include "verify/replay.h"

namespace scotty::verify {
namespace {

using reference::Error;

struct DiffCommand {
    std::string a, b;
    std::string backend;
    std::vector<std::string> stages;
    bool isolated = false;
    reference::Arithmetic arithmetic = reference::Arithmetic::exact;
    bool json = false;
    std::size_t threads = 0;
};

DiffReport compare(const DiffCommand& options) {
    const Capture a = Capture::open(options.a);
    DiffOptions diff;
    diff.patterns = options.stages;
    if (!options.b.empty()) {
        if (options.isolated || !options.backend.empty()) {
            throw Error::bad_input("scotty diff",
                                   "expected a second capture, or --backend (with --isolated or "
                                   "without), found both");
        }
        return diff_captures(a, Capture::open(options.b), std::move(diff));
    }
    const Backend backend =
        backend_named(options.backend.empty() ? "emulator" : options.backend, options.threads);
    reference::PipelineParameters b;
    b.arithmetic = options.arithmetic;
    expect_arithmetic(backend, b);
    diff.b_arithmetic = options.arithmetic;
    return options.isolated ? diff_isolated(a, backend, std::move(diff))
                            : diff_with_run(a, backend, std::move(diff));
}

int run_diff(const DiffCommand& options) {
    const DiffReport report = compare(options);
    if (report.stages.empty()) {
        throw Error::bad_input("scotty diff",
                               "no stage was compared: --stages matches none, or the captures "
                               "hold none in common");
    }
    print_result(options.json ? to_json(report).dump(2) : to_text(report));
    return report.passed() ? kExitPassed : kExitFailed;
}

}  // namespace

void add_diff_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "diff", "Compare two captures, or a capture with a fresh run, kernel launch by launch.");
    command->footer(
        "Examples:\n"
        "  scotty diff coil.emulator coil.cuda\n"
        "  scotty diff coil.cuda                       (with a fresh run of the emulator)\n"
        "  scotty diff coil.cuda --isolated            (each stage alone, on the capture's "
        "inputs:\n"
        "                                               tells a wrong kernel from wrong data)\n"
        "  scotty diff A B --stages '*/intersect' --json\n\n"
        "Verdicts: identical, reordered (where the order is free), differs. Exit code 1 where\n"
        "anything differs, is missing on one side, or is not finite.");
    auto options = std::make_shared<DiffCommand>();
    command->add_option("a", options->a, "a capture: what is expected")->required();
    command->add_option("b", options->b, "another capture; none: --backend runs");
    command->add_option("--backend", options->backend,
                        "emulator, simt or cuda: who runs the pipeline [emulator]");
    command->add_flag("--isolated", options->isolated, "each stage alone, on A's inputs");
    command
        ->add_option_function<std::string>(
            "--arithmetic",
            [options](const std::string& word) {
                options->arithmetic = reference::parse_arithmetic(word);
            },
            "fast: what runs computes approximately, and is held to tolerances [exact]")
        ->type_name("exact|fast");
    command->add_option("--stages", options->stages, "only stages of such names [all]")
        ->type_name("PATTERN");
    command->add_flag("--json", options->json, "the result as JSON");
    add_thread_option(*command, options->threads);
    command->callback([&action, options] { action = [options] { return run_diff(*options); }; });
}

}  // namespace scotty::verify
