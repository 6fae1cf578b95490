/// What a person at a terminal sees: progress that fits, colours where they are wanted, help that
/// can be read, and a word about what was mistyped.
#include <pty.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <functional>

#include "tests/verify/command_tools.h"
#include "verify/base/output_path.h"
#include "verify/base/scratch_folder.h"
#include "verify/base/terminal.h"
#include "verify/commands/completion.h"
#include "verify/commands/help.h"

namespace {

using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

/// All that a program writes to a terminal of so many columns, and its exit code.
Result in_terminal(unsigned short columns, const std::vector<std::string>& words) {
    const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "scotty";
    std::vector<std::string> all{program.string()};
    all.insert(all.end(), words.begin(), words.end());
    std::vector<char*> argv;
    for (std::string& word : all) argv.push_back(word.data());
    argv.push_back(nullptr);
    winsize size{24, columns, 0, 0};
    int master = -1;
    const pid_t child = forkpty(&master, nullptr, nullptr, &size);
    REQUIRE(child >= 0);
    if (child == 0) {
        setenv("TERM", "xterm", 1);
        unsetenv("NO_COLOR");
        execv(argv[0], argv.data());
        _exit(127);
    }
    Result result;
    char piece[4096];
    for (ssize_t got = 0; (got = read(master, piece, sizeof piece)) > 0;) {
        result.out.append(piece, static_cast<std::size_t>(got));
    }
    int status = 0;
    waitpid(child, &status, 0);
    close(master);
    result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return result;
}

/// What stands on the screen's lines: without escape sequences, split where a line begins anew.
std::vector<std::string> screen_lines(const std::string& text) {
    std::vector<std::string> lines(1);
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '\x1b') {
            i = std::min(text.find_first_of("mKJ", i), text.size());
        } else if (text[i] == '\r' || text[i] == '\n') {
            lines.emplace_back();
        } else {
            lines.back() += text[i];
        }
    }
    return lines;
}

TEST_CASE("terminal: progress of a long run never wraps, at any width", "[verify][terminal]") {
    for (const unsigned short columns : std::vector<unsigned short>{80, 40}) {
        const Result result = in_terminal(
            columns, {"verify", "coil", "--no-golden", "--size", "64x64", "--width", "8,16"});
        REQUIRE(result.exit_code == 0);
        std::size_t shown = 0;
        for (const std::string& line : screen_lines(result.out)) {
            if (!line.starts_with("scene 1 of 1: coil")) continue;
            ++shown;
            INFO(line);
            CHECK(line.size() < columns);
        }
        CHECK(shown > 2);
    }
}

TEST_CASE("terminal: a verdict is coloured there, and nowhere else unless asked",
          "[verify][terminal]") {
    const std::vector<std::string> words{"verify", "cornell",      "--size",  "9x5", "--spp",
                                         "1",      "--no-oracles", "--width", "8",   "--no-golden"};
    const std::string green = "\x1b[32mpassed\x1b[0m";
    CHECK_THAT(in_terminal(80, words).out, ContainsSubstring(green));
    std::string line;
    for (const std::string& word : words) line += word + " ";
    CHECK_THAT(run_scotty(line).out, ContainsSubstring("passed") && !ContainsSubstring("\x1b"));
    CHECK_THAT(run_scotty(line + "--color always").out, ContainsSubstring(green));
    const Result quiet = run_scotty(line + "-q --color never");
    CHECK(quiet.err.empty());
    CHECK_THAT(quiet.out, ContainsSubstring("passed") && !ContainsSubstring("\x1b"));
    setenv("NO_COLOR", "1", 1);
    CHECK_FALSE(has_color(STDOUT_FILENO));
    unsetenv("NO_COLOR");
    CHECK(colored_verdicts("all passed, bypassed passed.") ==
          "all \x1b[32mpassed\x1b[0m, bypassed \x1b[32mpassed\x1b[0m.");
    CHECK(scotty_here("list --color sometimes").exit_code == 2);
}

TEST_CASE("terminal: text is cut by characters, and says so", "[verify][terminal]") {
    CHECK(cut_to("abc", 3) == "abc");
    CHECK(cut_to("abcd", 3) == "ab~");
    CHECK(cut_to("\xc3\xa4\xc3\xb6\xc3\xbc", 3) == "\xc3\xa4\xc3\xb6\xc3\xbc");
    CHECK(cut_to("\xc3\xa4\xc3\xb6\xc3\xbc!", 3) == "\xc3\xa4\xc3\xb6~");
}

/// Each command of the program with its help, as "scotty help X" prints it.
std::vector<std::pair<std::string, std::string>> all_help() {
    std::vector<std::pair<std::string, std::string>> texts{{"", scotty_here("--help").out}};
    std::istringstream lines(texts.front().second);
    bool inside = false;
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with("Subcommands:")) {
            inside = true;
        } else if (inside && line.empty()) {
            break;
        } else if (inside && line.starts_with("  ") && line[2] != ' ') {
            const std::string name = line.substr(2, line.find(' ', 2) - 2);
            texts.emplace_back(name, scotty_here("help " + name).out);
        }
    }
    return texts;
}

TEST_CASE("help: fits 80 columns and speaks no CLI11, for every command", "[verify][cli]") {
    const auto texts = all_help();
    REQUIRE(texts.size() > 12);
    for (const auto& [name, text] : texts) {
        std::istringstream lines(text);
        bool options = true;
        for (std::string line; std::getline(lines, line);) {
            options &= !line.starts_with("Examples:");
            const bool is_command = line.starts_with("  scotty");
            INFO("scotty help " << name << ": " << line);
            // Commands to be pasted are not broken.
            if (options && !is_command) CHECK(line.size() <= 80);
            for (const char* raw :
                 {"{false}", "UINT", " in [", "Excludes:", "Needs:", "REQUIRED"}) {
                CHECK(line.find(raw) == std::string::npos);
            }
        }
        CHECK(text == scotty_here(name + " --help").out);
    }
    CHECK(scotty_here("help").out == texts.front().second);
    CHECK_THAT(scotty_here("help verify").out,
               ContainsSubstring("--threads N") && ContainsSubstring("(0..4096)"));
    CHECK_THAT(scotty_here("-V").out, ContainsSubstring("scotty 0."));
}

TEST_CASE("help: what was mistyped, command or option, is guessed", "[verify][cli]") {
    const std::vector<std::pair<std::string, std::string>> table{
        {"verfiy", "did you mean verify?"},   {"quues", "did you mean queues?"},
        {"verify --stag x", "--stage?"},      {"verify --no-orcales", "--no-oracles?"},
        {"render cornell --ssp 3", "--spp?"}, {"golden chekc", "did you mean check?"}};
    for (const auto& [arguments, expected] : table) {
        const Result result = scotty_here(arguments);
        INFO("scotty " << arguments << "\n" << result.err);
        CHECK(result.exit_code == 2);
        CHECK_THAT(result.err, ContainsSubstring(expected));
    }
    CHECK_THAT(scotty_here("frobnicate").err, !ContainsSubstring("did you mean"));
    CHECK_THAT(scotty_here("verify --frobnicate").err, !ContainsSubstring("did you mean"));
}

TEST_CASE("completion: every shell gets commands, options, choices and scenes", "[verify][cli]") {
    for (const std::string shell : {"bash", "zsh", "fish"}) {
        const Result result = scotty_here("completion " + shell);
        REQUIRE(result.exit_code == 0);
        for (const char* word : {"verify", "fail-fast", "golden", "approve", "coil", "immediate"}) {
            INFO(shell);
            CHECK_THAT(result.out, ContainsSubstring(word));
        }
    }
    CHECK(scotty_here("completion ksh").exit_code == 2);
    const TemporaryFolder folder;
    std::ofstream(folder.file("script")) << scotty_here("completion bash").out << R"(
complete_words() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _scotty; echo "${COMPREPLY[*]}"; }
complete_words scotty ver
complete_words scotty verify --fail
complete_words scotty render --early-out im
complete_words scotty golden appr
complete_words scotty verify corn
)";
    const std::string command =
        "bash '" + folder.file("script") + "' >'" + folder.file("out") + "' 2>&1";
    REQUIRE(std::system(command.c_str()) == 0);
    CHECK(slurp(folder.file("out")) == "verify\n--fail-fast\nimmediate\napprove\ncornell\n");
}

TEST_CASE("manual: has every command and option, and no line that roff would take for its own",
          "[verify][cli]") {
    const Result result = scotty_here("manual");
    REQUIRE(result.exit_code == 0);
    CHECK_THAT(result.out, ContainsSubstring(".TH SCOTTY 1") &&
                               ContainsSubstring(".SH scotty verify") &&
                               ContainsSubstring("\\-\\-fail\\-fast"));
    std::istringstream lines(result.out);
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] != '.') continue;
        INFO(line);
        const std::string macro = line.substr(1, 2);
        const std::vector<std::string> known{"TH", "SH", "TP", "B ", "PP", "nf", "fi"};
        CHECK(std::find(known.begin(), known.end(), macro) != known.end());
    }
}

TEST_CASE("outputs: a folder that is not there is said before the work starts", "[verify][cli]") {
    const TemporaryFolder folder;
    const std::string gone = folder.file("gone/out");
    for (const std::string command :
         {"verify --json ", "verify --html ", "verify --junit ", "verify --report ",
          "capture cornell -o ", "bench emulator --json ", "mutants --json ",
          "diff a.exr b.exr --heatmap ", "render cornell -o "}) {
        const Result result =
            scotty_here(command + gone + (command.ends_with("--json ") ? ".json" : ".png"));
        INFO("scotty " << command << "\n" << result.err);
        CHECK(result.exit_code == 2);
        CHECK_THAT(result.err, ContainsSubstring("does not exist"));
    }
    CHECK_FALSE(fs::exists(folder.file("gone")));
    CHECK_THAT(why_not_writable(folder.path().string()), ContainsSubstring("is a folder"));
    CHECK(why_not_writable("-").empty());
    CHECK(why_not_writable(folder.file("new")).empty());
}

TEST_CASE("scratch: a folder goes with its object, and with the process that a signal ends",
          "[verify][scratch]") {
    fs::path kept;
    {
        const ScratchFolder folder;
        kept = folder.path();
        fs::create_directories(kept / "inside");
        std::ofstream(kept / "inside" / "file") << "?";
    }
    CHECK_FALSE(fs::exists(kept));
    const pid_t child = fork();
    if (child == 0) {
        std::signal(SIGTERM, SIG_DFL);  // Catch2 has a handler of its own
        const ScratchFolder folder;
        fs::create_directories(folder.path() / "inside");
        std::raise(SIGTERM);
        _exit(0);
    }
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    CHECK((WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM));
    for (const auto& entry : fs::directory_iterator(fs::temp_directory_path())) {
        CHECK_FALSE(
            entry.path().filename().string().starts_with("scotty-" + std::to_string(child)));
    }
}

}  // namespace
