#include "verify/commands/command.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <new>
#include <string>

#include "reference/base/error.h"

#ifndef SCOTTY_VERSION
#define SCOTTY_VERSION "unknown"
#endif

namespace scotty::verify {

namespace {

constexpr const char* kFooter = R"(Examples:
  scotty verify                          verify all built-in scenes, within a minute
  scotty render coil -o coil.png         draw a picture through the emulator
  scotty bench emulator                  how fast, beside Embree
  scotty COMMAND --help                  more about one command

Exit codes: 0 passed, 1 verification failed, 2 usage or bad input (or nothing matched),
3 a required environment is missing, 70 internal error, 130 stopped by Ctrl-C.)";

/// CLI11 says what is wrong, but not what there is.
std::string complaint(const CLI::App& app, const CLI::ParseError& error, const char* first) {
    std::string text = error.what();
    const bool chosen = !app.get_subcommands().empty();
    if (!chosen) {
        if (first != nullptr) text = std::string("'") + first + "' is no command";
        text += "; commands are";
        const char* separator = " ";
        for (const CLI::App* command : app.get_subcommands(nullptr)) {
            text += separator + command->get_name();
            separator = ", ";
        }
        return text + " (see scotty --help)";
    }
    return text + " (see scotty " + app.get_subcommands().front()->get_name() + " --help)";
}

int exit_code_of(reference::ErrorKind kind) {
    switch (kind) {
        case reference::ErrorKind::bad_input:
            return kExitUsage;
        case reference::ErrorKind::missing_environment:
            return kExitMissingEnvironment;
        case reference::ErrorKind::internal:
            return kExitInternal;
    }
    return kExitInternal;
}

std::string join(int argc, char** argv) {
    std::string line = "scotty";
    for (int i = 1; i < argc; ++i) line += std::string(" ") + argv[i];
    return line;
}

}  // namespace

std::variant<Action, int> read_command_line(int argc, char** argv) {
    const auto kept = std::make_shared<CLI::App>(
        "CUDA-Scotty: a breadth-first path tracer and the suite that verifies it.");
    CLI::App& app = *kept;
    app.name("scotty");
    app.footer(kFooter);
    app.set_version_flag("--version", "scotty " SCOTTY_VERSION);
    app.require_subcommand(1);
    Action action;
    add_list_command(app, action);
    add_info_command(app, action);
    add_render_command(app, action);
    add_verify_command(app, action, join(argc, argv));
    add_bench_command(app, action);
    add_analyze_command(app, action);
    add_doctor_command(app, action);
    add_capture_command(app, action);
    add_diff_command(app, action);
    add_replay_command(app, action);
    add_trace_command(app, action);
    add_golden_command(app, action);
    add_queues_command(app, action);
    add_report_command(app, action);
    add_mutants_command(app, action);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
            return app.exit(error);  // help and version
        }
        spdlog::error("{}", complaint(app, error, argc > 1 ? argv[1] : nullptr));
        return kExitUsage;
    }
    return [kept, action] { return action(); };  // options are asked for what they were given
}

void print_result(const std::string& text) {
    std::cout << text;
    if (text.empty() || text.back() != '\n') std::cout << '\n';
    std::cout.flush();
    if (!std::cout) throw reference::Error::bad_input("standard output", "cannot be written");
}

int run_command(int argc, char** argv) {
    try {
        // Tests call this more than once in one process.
        auto logger = spdlog::get("scotty");
        spdlog::set_default_logger(logger ? logger : spdlog::stderr_color_mt("scotty"));
        spdlog::set_pattern("scotty: %^%l%$: %v");
        const auto read = read_command_line(argc, argv);
        const auto* action = std::get_if<Action>(&read);
        return action != nullptr ? (*action)() : std::get<int>(read);
    } catch (const reference::Error& error) {
        spdlog::error("{}", error.what());
        return exit_code_of(error.kind());
    } catch (const std::bad_alloc&) {
        std::fputs("scotty: error: out of memory; a smaller image or --batch-rays needs less\n",
                   stderr);
        return kExitMissingEnvironment;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scotty: internal error: %s\n", error.what());
        return kExitInternal;
    }
}

}  // namespace scotty::verify
