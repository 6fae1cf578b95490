/// scotty check: races and other faults in a CUDA program, without a GPU.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <memory>

#include "emulation/execution/schedule.h"
#include "reference/base/error.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/kernel_check/kernel_check.h"

namespace scotty::verify {

namespace {

constexpr const char* kHelp =
    "Examples:\n"
    "  scotty check program.cu             compile and run it, and say what is wrong\n"
    "  scotty check a.cu b.cu -I include -- 1024\n"
    "                                      two files, and what the program is given\n"
    "  scotty check kernel.cu --launch 'k<<<4, 256>>>(float[1024], 1024)'\n"
    "                                      a file without main(): arrays get small numbers\n"
    "  scotty check program.cu --schedules 20 --junit check.xml\n\n"
    "The host's C++ compiler compiles the program; neither a GPU nor CUDA is needed. What of CUDA\n"
    "is supported: docs/cuda-support.md. Exit code 1: something is wrong with the program.";

struct Options {
    KernelCheck check;
    std::size_t schedules = 1;
    std::string schedule;
    std::string junit;
    JsonOutput json;
};

bool is_source(const std::string& word) {
    const auto extensions = {".cu", ".cpp", ".cc", ".cxx"};
    return std::any_of(extensions.begin(), extensions.end(),
                       [&](const char* extension) { return word.ends_with(extension); });
}

int run(Options& options) {
    KernelCheck& check = options.check;
    const auto other = std::find_if_not(check.sources.begin(), check.sources.end(), is_source);
    if (other != check.sources.end()) {
        throw reference::Error::bad_input(
            *other,
            "expected a source file (.cu, .cpp, .cc or .cxx); what the program itself is "
            "given stands behind --");
    }
    check.schedules.clear();
    if (!options.schedule.empty()) {
        check.schedules.push_back(to_string(emulation::parse_schedule(options.schedule)));
    } else {
        for (const auto& one : emulation::seeded_schedules(options.schedules)) {
            check.schedules.push_back(to_string(one));
        }
    }
    const KernelReport report = check_kernels(check);
    if (!options.junit.empty()) {
        std::ofstream file(options.junit);
        file << to_junit(report);
        if (!file) throw reference::Error::bad_input(options.junit, "cannot be written");
    }
    std::string text = report.text;
    text += fmt::format("{}: {}, {} finding{} in {} schedule{}, {:.1f} s\n", report.name,
                        report.failed ? "FAILED" : "passed", report.findings.size(),
                        report.findings.size() == 1 ? "" : "s", report.schedules.size(),
                        report.schedules.size() == 1 ? "" : "s", report.seconds);
    if (report.exit_code != 0) {
        text += fmt::format("the program itself ended with exit code {}\n", report.exit_code);
    }
    print_result(options.json, to_json(report).dump(2), text);
    return report.failed ? kExitFailed : kExitPassed;
}

}  // namespace

void add_check_command(CLI::App& app, Action& action, const std::vector<std::string>& for_program) {
    auto* command = app.add_subcommand(
        "check", "Find races, bad accesses and divergence in a CUDA program, without a GPU.");
    command->footer(kHelp);
    auto options = std::make_shared<Options>();
    options->check.arguments = for_program;
    command
        ->add_option("files", options->check.sources,
                     "source files; behind --: what the program is given")
        ->required()
        ->type_name("FILE");
    command
        ->add_option("--launch", options->check.launch,
                     "launch this kernel: the file has no main()")
        ->type_name("TEXT");
    command
        ->add_option("--schedules", options->schedules,
                     "run under the first N orders of blocks and threads")
        ->type_name("N")
        ->check(CLI::Range(1, 1000));
    command
        ->add_option("--schedule", options->schedule,
                     "run under this order: linear, reversed, strided, adversarial, shuffle:SEED")
        ->type_name("ORDER");
    command->add_option("-I,--include", options->check.include_folders, "look for headers here")
        ->type_name("FOLDER")
        ->allow_extra_args(false);
    command->add_option("-D,--define", options->check.definitions, "define a macro")
        ->type_name("NAME[=VALUE]")
        ->allow_extra_args(false);
    command->add_option("--std", options->check.standard, "c++17 or another standard")
        ->type_name("STANDARD");
    command->add_option("--compiler", options->check.compiler, "the C++ compiler to use")
        ->type_name("PROGRAM");
    command
        ->add_option("--seconds", options->check.seconds, "processor time that each run may take")
        ->type_name("N")
        ->check(CLI::Range(1, 100000));
    command->add_flag("--strict", options->check.strict,
                      "warnings fail, and so does a return before a barrier");
    add_json_option(*command, options->json);
    command->add_option("--junit", options->junit, "write JUnit to this file")->type_name("FILE");
    command->callback([&action, options] { action = [options] { return run(*options); }; });
}

}  // namespace scotty::verify
