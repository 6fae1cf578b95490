/// The `scotty` command: one function a subcommand, each in its own file.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "verify/base/exit_code.h"

namespace scotty::verify {

/// Set by the subcommand that was chosen; run after the whole command line has been read.
using Action = std::function<int()>;

void add_list_command(CLI::App& app, Action& action);
void add_info_command(CLI::App& app, Action& action);
void add_render_command(CLI::App& app, Action& action);
void add_view_command(CLI::App& app, Action& action);
void add_verify_command(CLI::App& app, Action& action, const std::string& command_line);
void add_bench_command(CLI::App& app, Action& action);
void add_analyze_command(CLI::App& app, Action& action);
void add_doctor_command(CLI::App& app, Action& action);
/// `for_program` stood behind "--".
void add_check_command(CLI::App& app, Action& action, const std::vector<std::string>& for_program);
void add_capture_command(CLI::App& app, Action& action);
void add_diff_command(CLI::App& app, Action& action, const std::string& command_line);
void add_replay_command(CLI::App& app, Action& action);
void add_trace_command(CLI::App& app, Action& action);
void add_golden_command(CLI::App& app, Action& action);
void add_queues_command(CLI::App& app, Action& action);
void add_report_command(CLI::App& app, Action& action);
void add_mutants_command(CLI::App& app, Action& action);

/// Reads a whole command line and carries nothing out: the action, or the exit code where it ends
/// here (help, or a complaint, which has been printed). May throw reference::Error.
std::variant<Action, int> read_command_line(int argc, char** argv);

/// What main() does; also sets up logging. Never throws.
int run_command(int argc, char** argv);

/// Prints text with verdicts in it: in colours, where the terminal wants them.
void print_table(const std::string& text);
/// Prints a result: text, or JSON followed by a line's end, to standard output.
void print_result(const std::string& text);

}  // namespace scotty::verify
