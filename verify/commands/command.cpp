#include "verify/commands/command.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "scenes/scenes.h"
#include "verify/base/terminal.h"
#include "verify/commands/completion.h"
#include "verify/commands/help.h"
#include "verify/commands/options.h"
#include "verify/mutants/judge.h"

#ifndef SCOTTY_VERSION
#define SCOTTY_VERSION "unknown"
#endif

namespace scotty::verify {

namespace {

constexpr const char* kFooter = R"(Examples:
  scotty verify                          verify all built-in scenes, within a minute
  scotty render coil -o coil.png         draw a picture through the emulator
  scotty bench emulator                  how fast, beside Embree
  scotty help COMMAND                    more about one command

Exit codes: 0 passed, 1 verification failed, 2 usage or bad input (or nothing matched),
3 a required environment is missing, 70 internal error, 130 stopped by Ctrl-C.)";

/// CLI11 says what is wrong, but not what there is, nor what may have been meant.
std::string complaint(const CLI::App& app, const CLI::ParseError& error,
                      const std::vector<std::string>& words) {
    std::string text = error.what();
    const CLI::App* chosen = &app;
    std::string path = "scotty";
    while (!chosen->get_subcommands().empty()) {
        chosen = chosen->get_subcommands().front();
        path += " " + chosen->get_name();
    }
    const auto unknown = std::find_if(
        words.begin(), words.end(), [](const std::string& word) { return !word.starts_with("-"); });
    if (chosen == &app && unknown != words.end()) {
        text = "'" + *unknown + "' is no command" + did_you_mean(app, *unknown);
    } else if (!chosen->remaining(true).empty()) {
        text += did_you_mean(*chosen, chosen->remaining(true).front());
    } else if (!app.remaining(true).empty()) {
        text += did_you_mean(*chosen, app.remaining(true).front());
    }
    if (!chosen->get_subcommands(nullptr).empty()) {
        text += "; commands are";
        const char* separator = " ";
        for (const CLI::App* command : chosen->get_subcommands(nullptr)) {
            text += separator + command->get_name();
            separator = ", ";
        }
    }
    return text + " (see " + path + " --help)";
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

/// -q and --color, which hold for all commands.
void add_terminal_options(CLI::App& app) {
    set_quiet(false);
    set_color_choice(ColorChoice::automatic);
    app.add_flag_callback(
        "-q,--quiet", [] { set_quiet(true); },
        "no progress and no remarks: results and faults only");
    app.add_option_function<std::string>(
           "--color", [](const std::string& word) { set_color_choice(parse_color_choice(word)); },
           "auto: on a terminal, unless NO_COLOR is set")
        ->type_name("auto|always|never");
}

void set_up_messages() {
    if (is_quiet()) spdlog::set_level(spdlog::level::warn);
    const auto& sinks = spdlog::default_logger()->sinks();
    if (sinks.empty()) return;
    auto* sink = dynamic_cast<spdlog::sinks::stderr_color_sink_mt*>(sinks.front().get());
    if (sink == nullptr) return;
    sink->set_color_mode(has_color(STDERR_FILENO) ? spdlog::color_mode::always
                                                  : spdlog::color_mode::never);
}

/// `scotty completion SHELL` and `scotty manual`, which `cmake --install` asks.
void add_completion_commands(CLI::App& app, Action& action) {
    auto* manual = app.add_subcommand("manual", "Print the manual page, for man -l -.");
    manual->footer("Examples:\n  scotty manual | man -l -");
    manual->callback([&app, &action] {
        action = [&app] {
            print_result(manual_page(app, SCOTTY_VERSION));
            return kExitPassed;
        };
    });
    auto* shells = app.add_subcommand("completion", "Print completions for a shell.");
    shells->footer("Examples:\n  source <(scotty completion bash)");
    auto shell = std::make_shared<std::string>();
    shells->add_option("shell", *shell, "bash, zsh or fish")->required()->type_name("SHELL");
    shells->callback([&app, &action, shell] {
        action = [&app, shell] {
            std::vector<std::string> scenes;
            for (const auto& scene : scenes::built_in_scenes()) scenes.push_back(scene.name);
            print_result(completion(app, *shell, scenes));
            return kExitPassed;
        };
    });
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
    app.formatter(help_formatter());
    app.set_help_flag("-h,--help", "say what there is, and end");
    app.set_version_flag("-V,--version", "scotty " SCOTTY_VERSION, "print the version, and end");
    std::vector<std::string> words(argv + 1, argv + argc);
    // What stands behind "--" is for the program that `scotty check` runs.
    std::vector<std::string> for_program;
    const auto mark = std::find(words.begin(), words.end(), "--");
    if (mark != words.end() && words.front() == "check") {
        for_program.assign(mark + 1, words.end());
        words.erase(mark, words.end());
    }
    add_terminal_options(app);
    app.require_subcommand(1);
    app.fallthrough();  // -q and --color may stand behind the command, too
    Action action;
    add_list_command(app, action);
    add_info_command(app, action);
    add_render_command(app, action);
    add_view_command(app, action);
    add_verify_command(app, action, join(argc, argv));
    add_bench_command(app, action);
    add_analyze_command(app, action);
    add_doctor_command(app, action);
    add_check_command(app, action, for_program);
    add_capture_command(app, action);
    add_diff_command(app, action, join(argc, argv));
    add_replay_command(app, action);
    add_trace_command(app, action);
    add_golden_command(app, action);
    add_queues_command(app, action);
    add_report_command(app, action);
    add_mutants_command(app, action);
    add_completion_commands(app, action);
    // `scotty help X` is `scotty X --help`.
    if (!words.empty() && words.front() == "help") {
        std::rotate(words.begin(), words.begin() + 1, words.end());
        words.back() = "--help";
    }
    try {
        words = json_words(std::move(words));
        std::vector<std::string> last_first(words.rbegin(), words.rend());
        app.parse(std::move(last_first));
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
            return app.exit(error);  // help and version
        }
        spdlog::error("{}", complaint(app, error, words));
        return kExitUsage;
    }
    return [kept, action] { return action(); };  // options are asked for what they were given
}

void print_table(const std::string& text) {
    print_result(has_color(STDOUT_FILENO) ? colored_verdicts(text) : text);
}

void print_result(const JsonOutput& output, const std::string& json, const std::string& text) {
    if (output.in_place()) return print_result(json);
    if (!output.file.empty()) reference::write_file(output.file, json + "\n");
    print_table(text);
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
        spdlog::set_level(spdlog::level::info);
        spdlog::set_pattern("scotty: %^%l%$: %v");
        const auto read = read_command_line(argc, argv);
        const auto* action = std::get_if<Action>(&read);
        set_up_messages();
        return action != nullptr ? (*action)() : std::get<int>(read);
    } catch (const reference::Error& error) {
        spdlog::error("{}", error.what());
        // The kernels are what is under test: a race or a divergence is a finding, not our fault.
        const bool found = error.kind() == reference::ErrorKind::internal &&
                           kind_of_error(error.what()) != "error";
        return found ? kExitFailed : exit_code_of(error.kind());
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
