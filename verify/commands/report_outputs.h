/// The files a report can be asked for, as verify and report share them.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "verify/commands/options.h"
#include "verify/report/report.h"

namespace scotty::verify {

/// Empty: not asked for.
struct ReportOutputs {
    JsonOutput json;
    std::string junit, html;
};

/// --json, --junit and --html.
void add_report_outputs(CLI::App& command, ReportOutputs& outputs);

/// Writes them; standard output gets the table, or `as_json` where that was asked for. Throws
/// bad_input where a file cannot be written.
void write_report(const ReportOutputs& outputs, const Report& report,
                  const nlohmann::json& as_json);

}  // namespace scotty::verify
