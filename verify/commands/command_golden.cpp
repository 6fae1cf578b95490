/// scotty golden: what is wrong with the golden files, new ones, and which of those to take.
#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <memory>
#include <optional>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "scenes/scenes.h"
#include "verify/base/ask.h"
#include "verify/base/progress.h"
#include "verify/commands/command.h"
#include "verify/commands/options.h"
#include "verify/golden/golden.h"
#include "verify/golden/golden_proposal.h"
#include "verify/report/report.h"
#include "verify/sweep/cases.h"
#include "verify/sweep/verify.h"

namespace scotty::verify {
namespace {

namespace fs = std::filesystem;

struct GoldenOptions {
    std::string golden, output;
    std::vector<std::string> names;
    std::string reason;
    std::size_t threads = 0;
    JsonOutput json;
    bool ledger_only = false;

    fs::path golden_folder() const {
        return golden.empty() ? find_golden_folder() : fs::path(golden);
    }
    /// Where proposals lie: in the build tree that this program is of.
    fs::path output_folder() const {
        if (!output.empty()) return output;
        std::error_code ignored;
        return fs::read_symlink("/proc/self/exe", ignored).parent_path().parent_path() / "golden";
    }
};

int run_check(const GoldenOptions& options) {
    const fs::path folder = options.golden_folder();
    const std::vector<GoldenCase> cases = golden_cases();
    const std::vector<GoldenFinding> findings = check_golden(folder, cases, today());
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    std::string text;
    for (const GoldenFinding& f : findings) {
        list.push_back({{"problem", to_string(f.problem)},
                        {"case", f.name},
                        {"file", f.file},
                        {"text", f.text},
                        {"way_out", f.way_out}});
        text += fmt::format("{:<9} {:<10} {}{}{}\n{:<20} way out: {}\n", to_string(f.problem),
                            f.name, f.file, f.file.empty() ? "" : ": ", f.text, "", f.way_out);
    }
    text += findings.empty()
                ? fmt::format("{} golden cases, nothing is wrong with them\n", cases.size())
                : fmt::format("{} golden cases: {} findings\n", cases.size(), findings.size());
    const nlohmann::ordered_json out{{"golden", folder.string()},
                                     {"cases", cases.size()},
                                     {"passed", findings.empty()},
                                     {"findings", list}};
    print_result(options.json, out.dump(2), text);
    return findings.empty() ? kExitPassed : kExitFailed;
}

/// Of the source tree that the golden folder is in; "-dirty" where it has changes.
std::string commit_of(const fs::path& golden) {
    const std::string commit = ask("git -C " + shell_word(golden.string()) +
                                   " describe --always --dirty --abbrev=40 --exclude '*'");
    return commit.empty() ? "unknown" : commit;
}

/// Of everything that `scotty verify` runs by default. Throws bad_input where that fails: what is
/// known to be wrong is not to be approved.
Hashes hashes_now(const GoldenOptions& options) {
    HashBook book;
    VerifySettings settings;
    settings.parameters = default_verify_parameters();
    settings.threads = options.threads;
    settings.hashes = &book;
    Progress progress;
    settings.progress = [&](const std::string& what, std::size_t done, std::size_t total) {
        progress.show(fmt::format("hashes: {} of {}: {}", done + 1, total, what));
    };
    std::vector<SceneReport> reports{
        verify_cases(covering_cases(Budget::standard).cases, settings)};
    for (const auto& scene : scenes::built_in_scenes()) {
        reports.push_back(verify_scene(scenes::load_scene(scene.name), settings));
    }
    settings.backend = "simt";
    settings.oracles = false;
    reports.push_back(verify_cases(covering_cases(Budget::quick).cases, settings));
    progress.clear();
    for (const SceneReport& report : reports) {
        if (report.passed()) continue;
        throw reference::Error::bad_input(
            "hashes",
            fmt::format("{} fails its verification, so its hashes are no truth: {}", report.scene,
                        to_string(placed_failures(report).front().failure)));
    }
    return book.recorded();
}

int run_propose(const GoldenOptions& options) {
    std::optional<tbb::global_control> limit;
    if (options.threads != 0) {
        limit.emplace(tbb::global_control::max_allowed_parallelism, options.threads);
    }
    const std::vector<GoldenCase> cases = golden_cases();
    std::vector<GoldenCase> chosen;
    bool hashes = options.names.empty();
    for (const std::string& name : options.names) {
        if (name == kHashesName) {
            hashes = true;
        } else {
            chosen.push_back(find_case(cases, name));
        }
    }
    if (options.names.empty()) chosen = cases;

    Progress progress;
    ProposalSettings settings;
    settings.golden = options.golden_folder();
    settings.output = options.output_folder();
    settings.threads = options.threads;
    settings.ledger_only = options.ledger_only;
    settings.commit = commit_of(settings.golden);
    settings.progress = [&](const std::string& what, std::uint64_t done, std::uint64_t total) {
        progress.show(fmt::format("{}: {} of {}", what, done, total));
    };
    std::vector<Proposal> proposals;
    for (const GoldenCase& golden : chosen) {
        settings.command =
            "scotty golden propose " + golden.name + (options.ledger_only ? " --ledger-only" : "");
        proposals.push_back(propose_golden(golden, settings));
    }
    progress.clear();
    std::string text = to_text(proposals);
    nlohmann::ordered_json json = to_json(proposals);
    if (hashes) {
        settings.command = fmt::format("scotty golden propose {}", kHashesName);
        const HashProposal proposal = propose_hashes(hashes_now(options), settings);
        text += to_text(proposal);
        json.push_back({{"case", kHashesName}, {"hashes", to_json(proposal)}});
    }
    reference::write_file((settings.output / "report.txt").string(), text);
    reference::write_file((settings.output / "report.json").string(), json.dump(2) + "\n");
    spdlog::info("{} holds the files and report.txt", settings.output.string());
    print_result(options.json, json.dump(2), text);
    return kExitPassed;
}

int run_approve(const GoldenOptions& options) {
    const std::vector<GoldenCase> cases = golden_cases();
    const fs::path folder = options.golden_folder();
    const std::string& name = options.names.front();
    if (name == kHashesName) {
        approve_hashes(folder, options.output_folder(), options.reason);
    } else {
        approve_golden(find_case(cases, name), folder, options.output_folder(), options.reason);
    }
    const nlohmann::ordered_json out{
        {"case", name}, {"golden", folder.string()}, {"reason", options.reason}};
    print_result(options.json, out.dump(2),
                 fmt::format("{}: approved; commit {}", name, folder.string()));
    return kExitPassed;
}

CLI::App* add_part(CLI::App& command, const std::string& name, const std::string& help,
                   const std::shared_ptr<GoldenOptions>& options) {
    CLI::App* part = command.add_subcommand(name, help);
    part->add_option("--golden", options->golden,
                     "the folder [golden/ above this program or the current folder]");
    add_json_option(*part, options->json);
    return part;
}

}  // namespace

void add_golden_command(CLI::App& app, Action& action) {
    auto* command = app.add_subcommand(
        "golden", "Check the golden images and ledgers, propose new ones, approve them.");
    command->footer(
        "Examples:\n"
        "  scotty golden check\n"
        "  scotty golden propose coil              (minutes; goes on where it was interrupted)\n"
        "  scotty golden propose --ledger-only     (seconds)\n"
        "  scotty golden propose hashes            (minutes)\n"
        "  scotty golden approve coil --reason \"the coil has more turns now\"\n\n"
        "Only approve writes to golden/, and only the files of the case that it names.\n"
        "Exit code 1 where check finds something.");
    command->require_subcommand(1);
    auto options = std::make_shared<GoldenOptions>();

    CLI::App* check =
        add_part(*command, "check", "What is missing, orphaned, stale or corrupted", options);
    check->callback([&action, options] { action = [options] { return run_check(*options); }; });

    CLI::App* propose = add_part(*command, "propose",
                                 "Render golden files into the build tree and compare", options);
    propose->add_option("case", options->names, "which [all]");
    propose->add_option("-o,--output", options->output,
                        "where to [the folder golden of the build tree]");
    propose->add_flag("--ledger-only", options->ledger_only,
                      "keep the golden images: a stage or a buffer has changed, and no picture");
    add_thread_option(*propose, options->threads);
    propose->callback([&action, options] { action = [options] { return run_propose(*options); }; });

    CLI::App* approve =
        add_part(*command, "approve", "Move one proposal into the golden folder", options);
    approve->add_option("case", options->names, "which")->required()->expected(1);
    approve->add_option("--reason", options->reason, "why the truth changes, in a sentence")
        ->required();
    approve->add_option("-o,--output", options->output,
                        "where the proposal is [the folder golden of the build tree]");
    approve->callback([&action, options] { action = [options] { return run_approve(*options); }; });
}

}  // namespace scotty::verify
