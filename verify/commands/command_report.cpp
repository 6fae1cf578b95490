/// scotty report: the parts of a sweep as one verdict and page.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "verify/capture/capture_format.h"
#include "verify/commands/command.h"
#include "verify/commands/report_outputs.h"
#include "verify/mutants/judge.h"
#include "verify/report/report_file.h"

namespace scotty::verify {
namespace {

struct ReportOptions {
    std::vector<std::string> files;
    ReportOutputs outputs;
};

int run_report(const ReportOptions& options) {
    std::vector<ReportPart> parts;
    std::vector<MutantReport> mutants;
    std::vector<std::string> part_names;
    std::vector<std::string> mutant_names;
    for (const std::string& file : options.files) {
        nlohmann::json object = read_json(file);
        if (is_part(object)) {
            parts.push_back(read_part(file, std::move(object)));
            part_names.push_back(file);
        } else if (is_mutant_report(object)) {
            mutants.push_back(read_mutants(file, object));
            mutant_names.push_back(file);
        } else {
            throw reference::Error::bad_input(
                file,
                "expected what scotty verify --shard I/N --json or scotty mutants --json has "
                "written; a report that was not split needs no joining");
        }
    }
    Report report;
    if (!parts.empty()) report = join(parts, part_names);
    if (!mutants.empty()) report.mutants = join(mutants, mutant_names);
    spdlog::info("{} parts of a verification, {} of planted faults", parts.size(), mutants.size());
    write_report(options.outputs, report, to_json(report));
    return report.passed() ? kExitPassed : kExitFailed;
}

}  // namespace

void add_report_command(CLI::App& app, Action& action) {
    auto* command =
        app.add_subcommand("report", "Join the parts of a sweep to one verdict and page.");
    command->footer(
        "Examples:\n"
        "  scotty verify --shard 1/2 --json 1.json && scotty verify --shard 2/2 --json 2.json\n"
        "  scotty mutants --json mutants.json\n"
        "  scotty report 1.json 2.json mutants.json --html all.html\n\n"
        "A shard that is missing, there twice or of another sweep is an error (exit code 2). See\n"
        "docs/at-scale.md.");
    auto options = std::make_shared<ReportOptions>();
    command
        ->add_option("files", options->files,
                     "of scotty verify --shard and scotty mutants, in any order")
        ->required()
        ->type_name("FILE");
    add_report_outputs(*command, options->outputs);
    command->callback([&action, options] { action = [options] { return run_report(*options); }; });
}

}  // namespace scotty::verify
