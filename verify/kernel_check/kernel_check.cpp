#include "verify/kernel_check/kernel_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <utility>

#include "reference/base/error.h"
#include "verify/base/scratch_folder.h"
#include "verify/kernel_check/compile.h"
#include "verify/kernel_check/programs.h"

namespace scotty::verify {

namespace {

using Words = std::vector<std::string>;
namespace fs = std::filesystem;

/// The library and its headers: beside this program's own folder, in the build tree and installed.
fs::path executor_folder() {
    const fs::path program = fs::read_symlink("/proc/self/exe");
    fs::path folder = program.parent_path().parent_path() / "lib" / "cuda-scotty";
    if (!fs::exists(folder / "include" / "scotty_cuda" / "cuda.h")) {
        throw reference::Error::missing_environment(
            folder.string() +
            " has no include/scotty_cuda/cuda.h: the executor of CUDA programs "
            "is not installed");
    }
    return folder;
}

class Build {
 public:
    Build(const KernelCheck& check, fs::path scratch)
        : check_(check),
          compiler_(find_compiler(check.compiler)),
          executor_(executor_folder()),
          scratch_(std::move(scratch)) {}

    fs::path program() {
        Words link = {compiler_, "-o", (scratch_ / "program").string()};
        for (std::size_t i = 0; i < check_.sources.size(); ++i) {
            link.push_back(object(check_.sources[i], i).string());
        }
        const Words options = link_options_of_kernels(executor_);
        link.insert(link.end(), options.begin(), options.end());
        run(link, "is not linked");
        return scratch_ / "program";
    }

 private:
    fs::path object(const std::string& source, std::size_t number) {
        if (!fs::exists(source)) throw reference::Error::bad_input(source, "there is no such file");
        CudaCompile compile;
        compile.compiler = compiler_;
        compile.executor = executor_;
        compile.standard = check_.standard;
        for (const std::string& folder : check_.include_folders) {
            compile.options.push_back("-I" + folder);
        }
        for (const std::string& name : check_.definitions) compile.options.push_back("-D" + name);
        compile.source = source;
        compile.object = scratch_ / fmt::format("{}.o", number);
        if (number == 0 && !check_.launch.empty()) {
            compile.source = (scratch_ / "0.cu").string();
            write_text(compile.source,
                       fmt::format("#include \"{}\"\n#line 1 \"--launch\"\n{}",
                                   fs::absolute(source).string(), main_of_launch(check_.launch)));
            compile.shown_as = source;
        }
        compile_cuda(compile);
        return compile.object;
    }

    static void run(const Words& words, const std::string& what) {
        ProgramOptions options;
        options.keep_output = true;
        const ProgramRun ran = run_program(words, options);
        if (ran.output.find("undefined reference to `main'") != std::string::npos) {
            throw reference::Error::bad_input(
                "the program",
                "it has no main(); --launch 'kernel<<<grid, block>>>(arguments)' makes one");
        }
        if (ran.exit_code != 0) throw reference::Error::bad_input(what, "\n" + ran.output);
    }

    const KernelCheck& check_;
    std::string compiler_;
    fs::path executor_;
    fs::path scratch_;
};

std::string dim_text(const nlohmann::json& dim) {
    return fmt::format("({},{},{})", dim[0].get<unsigned>(), dim[1].get<unsigned>(),
                       dim[2].get<unsigned>());
}

std::string actor_text(const nlohmann::json& actor) {
    std::string text = "    ";
    if (actor.contains("thread")) {
        text += fmt::format("thread {} of block {}", dim_text(actor["thread"]),
                            dim_text(actor["block"]));
    } else {
        text += "the host";
    }
    const auto does = actor["does"].get<std::string>();
    const auto line = actor["line"].get<std::string>();
    if (!does.empty()) text += " " + does;
    if (!line.empty()) text += " at " + line;
    text += "\n";
    if (actor.contains("called_from")) {
        for (const auto& caller : actor["called_from"]) {
            text += "        called at " + caller.get<std::string>() + "\n";
        }
    }
    return text;
}

std::string finding_text(const nlohmann::json& finding, std::size_t schedules) {
    std::string text =
        fmt::format("{}{}: {}", finding["warning"].get<bool>() ? "warning: " : "",
                    finding["kind"].get<std::string>(), finding["what"].get<std::string>());
    const auto kernel = finding["kernel"].get<std::string>();
    if (!kernel.empty()) text += ", in kernel " + kernel;
    if (finding["times"].get<std::uint64_t>() > 1) {
        text += fmt::format(" ({} times)", finding["times"].get<std::uint64_t>());
    }
    if (finding["schedules"].size() < schedules) {
        std::string names;
        for (const auto& name : finding["schedules"]) {
            names += (names.empty() ? "" : ", ") + name.get<std::string>();
        }
        text += ", only under " + names;
    }
    text += "\n";
    for (const char* const side : {"other", "one"}) {
        if (finding.contains(side)) text += actor_text(finding[side]);
    }
    if (finding.contains("allocated")) {
        text += "    allocated at " + finding["allocated"].get<std::string>() + "\n";
    }
    return text;
}

/// What makes findings of two runs the same one.
std::string key_of(const nlohmann::json& finding) {
    const auto line = [&](const char* side) {
        return finding.contains(side) ? finding[side]["line"].get<std::string>() : std::string();
    };
    const auto [low, high] = std::minmax(line("one"), line("other"));
    const auto what = finding["what"].get<std::string>();
    return finding["kind"].get<std::string>() + "|" + finding["kernel"].get<std::string>() + "|" +
           low + "|" + high + "|" + what.substr(0, what.find(','));
}

}  // namespace

KernelReport check_kernels(const KernelCheck& check) {
    const auto begin = std::chrono::steady_clock::now();
    const ScratchFolder scratch;
    fs::create_directories(scratch.path());
    const fs::path program = Build(check, scratch.path()).program();
    KernelReport report;
    report.name = check.sources.front();
    report.schedules = check.schedules;
    report.findings = nlohmann::json::array();
    std::map<std::string, std::size_t> known;
    for (const std::string& schedule : check.schedules) {
        const fs::path file = scratch.path() / "report.json";
        fs::remove(file);
        Words words = {program.string()};
        words.insert(words.end(), check.arguments.begin(), check.arguments.end());
        ProgramOptions options;
        options.seconds = check.seconds;
        options.environment = {"SCOTTY_CHECK_SCHEDULE=" + schedule,
                               "SCOTTY_CHECK_REPORT=" + file.string()};
        if (check.strict) options.environment.emplace_back("SCOTTY_CHECK_STRICT=1");
        const ProgramRun run = run_program(words, options);
        if (run.exit_code != 0 && report.exit_code == 0) report.exit_code = run.exit_code;
        const nlohmann::json found = nlohmann::json::parse(text_of_file(file), nullptr, false);
        if (found.is_discarded()) {
            report.ended_by_itself = false;
            report.findings.push_back(
                {{"kind", run.out_of_time ? "endless program" : "program ended"},
                 {"warning", false},
                 {"kernel", ""},
                 {"what",
                  run.out_of_time
                      ? fmt::format("it did not end within {} seconds", check.seconds)
                      : fmt::format("it ended with exit code {} without a report", run.exit_code)},
                 {"times", 1},
                 {"schedules", {schedule}}});
            continue;
        }
        for (nlohmann::json finding : found["findings"]) {
            const auto [at, is_new] = known.try_emplace(key_of(finding), report.findings.size());
            if (is_new) {
                finding["schedules"] = {schedule};
                report.findings.push_back(std::move(finding));
            } else {
                auto& names = report.findings[at->second]["schedules"];
                if (names.back() != schedule) names.push_back(schedule);
            }
        }
    }
    for (const auto& finding : report.findings) {
        if (check.strict || !finding["warning"].get<bool>()) report.failed = true;
        report.text += finding_text(finding, check.schedules.size());
    }
    if (report.exit_code != 0) report.failed = true;
    report.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
}

nlohmann::json to_json(const KernelReport& report) {
    return {{"program", report.name},        {"verdict", report.failed ? "failed" : "passed"},
            {"findings", report.findings},   {"schedules", report.schedules},
            {"exit_code", report.exit_code}, {"seconds", report.seconds}};
}

}  // namespace scotty::verify
