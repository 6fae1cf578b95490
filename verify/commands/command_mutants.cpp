/// scotty mutants: is every planted fault caught, by the check and at the stage that it should?
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "reference/base/error.h"
#include "verify/backends/checked_program.h"
#include "verify/base/output_path.h"
#include "verify/base/progress.h"
#include "verify/base/shard.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/mutants/judge.h"
#include "verify/mutants/made_sweep.h"
#include "verify/mutants/plant.h"
#include "verify/report/report.h"

namespace scotty::verify {
namespace {

struct MutantsOptions {
    std::vector<std::string> names;
    std::string shard;
    JsonOutput json;
    bool list = false;
    std::size_t threads = 0;
    unsigned limit = 120;
    bool made = false;
    MadeSweep sweep;
};

/// What is run: faults first, then hostile conditions.
struct Selection {
    std::vector<PlantedFault> faults;
    std::vector<HostileCondition> hostile;
};

Selection select(const MutantsOptions& options) {
    Selection all{planted_faults(), hostile_conditions()};
    const auto asked = [&](const std::string& name) {
        return std::find(options.names.begin(), options.names.end(), name) != options.names.end();
    };
    if (!options.names.empty()) {
        std::erase_if(all.faults, [&](const auto& fault) { return !asked(fault.name); });
        std::erase_if(all.hostile, [&](const auto& condition) { return !asked(condition.name); });
        if (all.faults.size() + all.hostile.size() < options.names.size()) {
            throw reference::Error::bad_input(
                "mutants", "not all of these names are known; scotty mutants --list has them");
        }
    }
    const Shard shard = parse_shard(options.shard);
    std::size_t index = 0;
    const auto elsewhere = [&](const auto&) { return !shard.has(index++); };
    std::erase_if(all.faults, elsewhere);
    std::erase_if(all.hostile, elsewhere);
    return all;
}

std::vector<std::string> words_of(const std::string& text) {
    std::istringstream stream(text);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) words.push_back(word);
    return words;
}

std::string list(const Selection& selection) {
    std::string text;
    for (const PlantedFault& fault : selection.faults) {
        text += fmt::format("{:<32} {}\n", fault.name, fault.file);
        text += indented(fault.what + (fault.defect.empty() ? "" : " [" + fault.defect + "]"));
        if (!fault.unapplied.empty()) {
            text += indented("does not apply any more: " + fault.unapplied);
        }
    }
    for (const HostileCondition& condition : selection.hostile) {
        text += fmt::format("{:<32} no fault\n", condition.name) + indented(condition.what);
    }
    return text;
}

/// Of a fault that is not in the program nothing is run.
std::vector<std::vector<std::string>> commands_of(const Selection& selection) {
    std::vector<std::vector<std::string>> commands;
    for (const PlantedFault& fault : selection.faults) {
        if (!fault.unapplied.empty()) continue;
        commands.push_back(words_of(fault.run + " --threads 1 --json - --plant " + fault.name));
    }
    for (const HostileCondition& condition : selection.hostile) {
        commands.push_back(words_of(condition.run + " --json -"));
    }
    return commands;
}

int run_mutants(const MutantsOptions& options) {
    if (options.made) {
        MadeSweep sweep = options.sweep;
        sweep.shard = options.shard;
        sweep.json = options.json.file;
        sweep.threads = options.threads;
        become_made_sweep(sweep);
    }
    if (!has_planted_faults()) become_program("scotty-mutants", "mutants");
    const Selection selection = select(options);
    if (options.list) {
        print_result(list(selection));
        return kExitPassed;
    }
    const auto start = std::chrono::steady_clock::now();
    const auto commands = commands_of(selection);
    std::vector<ProcessOutcome> outcomes(commands.size());
    Progress progress;
    std::size_t ended = 0;
    const std::size_t cores = std::max(1u, std::thread::hardware_concurrency());
    run_in_processes(run_command, commands,
                     {options.threads != 0 ? options.threads : cores, options.limit},
                     [&](std::size_t index, const ProcessOutcome& outcome) {
                         outcomes[index] = outcome;
                         progress.show(fmt::format("{} of {} done", ++ended, commands.size()));
                     });
    progress.clear();
    MutantReport report;
    report.shard = options.shard;
    std::size_t index = 0;
    for (const auto& fault : selection.faults) {
        const bool ran = fault.unapplied.empty();
        report.faults.push_back(judge(fault, ran ? outcomes[index++] : ProcessOutcome{}));
    }
    for (const auto& condition : selection.hostile) {
        report.hostile.push_back(judge(condition, outcomes[index++]));
    }
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    print_result(options.json, to_json(report).dump(2), to_text(report));
    return report.passed() ? kExitPassed : kExitFailed;
}

}  // namespace

void add_mutants_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "mutants", "Plant faults in the kernels, one after the other: is each of them caught?");
    command->footer(
        "Examples:\n"
        "  scotty mutants                          all of them: a minute or two\n"
        "  scotty mutants --list                   their names, and what is wrong\n"
        "  scotty mutants visited_twice            one\n"
        "  scotty mutants --shard 2/4 --json 2.json\n"
        "  scotty mutants --made --sample 200      faults made by a machine: an hour, and a "
        "build\n\n"
        "A fault counts as caught where the check that has to see it is the first to, at the "
        "stage\n"
        "where it has to. Conditions that are hostile, with no fault, have to pass\n"
        "(docs/planted-faults.md).");
    auto options = std::make_shared<MutantsOptions>();
    command->add_option("names", options->names, "faults or hostile conditions; all by default");
    command->add_flag("--list", options->list, "say what there is, and run nothing");
    add_json_option(*command, options->json);
    add_shard_option(*command, options->shard);
    command->add_option("--limit", options->limit, "seconds that one of them may take")
        ->capture_default_str()
        ->check(CLI::Range(1u, 86400u));
    command->add_option("--threads", options->threads, "processes at once; 0: as many as cores")
        ->capture_default_str()
        ->check(CLI::Range(std::size_t{0}, std::size_t{4096}));
    auto* made = command->add_flag("--made", options->made,
                                   "faults made by a program from the text of all sources: which "
                                   "share of them is seen? (docs/trust.md)");
    command->add_option("--files", options->sweep.files, "only faults of such files")
        ->type_name("PATTERN")
        ->needs(made);
    command->add_option("--sample", options->sweep.sample, "how many are run; 200 by default")
        ->needs(made);
    command->add_option("--seed", options->sweep.seed, "of the sample; 1 by default")->needs(made);
    command->callback([&action, options] { action = [options] { return run_mutants(*options); }; });
}

}  // namespace scotty::verify
