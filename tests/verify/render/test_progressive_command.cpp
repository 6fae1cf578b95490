/// scotty render --progressive and --display, as a user runs them: Ctrl-C included.
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <future>
#include <regex>

#include "tests/verify/command_tools.h"
#include "tests/verify/image_tools.h"
#include "tests/verify/tev_server.h"
#include "verify/images/image_read.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;

constexpr const char* kPicture = "render spheres --size 16x12 --bounces 1 --light-samples 1 ";

/// The program as a child whose signals are as a terminal's are.
class Child {
 public:
    Child(const std::string& arguments, const std::string& errors) {
        std::vector<std::string> words{"scotty"};
        std::istringstream split(arguments);
        for (std::string word; split >> word;) words.push_back(word);
        std::vector<char*> argv;
        for (std::string& word : words) argv.push_back(word.data());
        argv.push_back(nullptr);
        const std::string program =
            (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "scotty").string();
        const int file = open(errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
        REQUIRE(file >= 0);
        process_ = fork();
        if (process_ == 0) {
            std::signal(SIGINT, SIG_DFL);
            std::signal(SIGTERM, SIG_DFL);
            dup2(file, STDERR_FILENO);
            execv(program.c_str(), argv.data());
            _exit(127);
        }
        close(file);
        REQUIRE(process_ > 0);
    }
    ~Child() {
        if (process_ > 0) {
            kill(SIGKILL);
            wait();
        }
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    void kill(int signal) const { ::kill(process_, signal); }
    /// As waitpid() has it.
    int wait() {
        int status = -1;
        waitpid(std::exchange(process_, -1), &status, 0);
        return status;
    }

 private:
    pid_t process_ = -1;
};

/// The picture in a file, as floats.
std::vector<float> values_of(const std::string& file) {
    std::vector<float> values;
    for (const Color& pixel : read_image(file).image.mean) {
        for (const double value : pixel) values.push_back(static_cast<float>(value));
    }
    return values;
}

}  // namespace

TEST_CASE("render --progressive: the same file as without", "[verify][cli][progressive]") {
    const TemporaryFolder folder;
    const std::string a = folder.file("a.exr");
    const std::string b = folder.file("b.exr");
    for (const char* options : {"--spp 5", "--spp 5 --backend embree", "--spp 3 --backend simt",
                                "--spp 5 --batch-rays 50", "--spp 5 --filter median",
                                "--spp 5 --filter median --filter-threshold 4"}) {
        INFO(options);
        REQUIRE(scotty_here(kPicture + std::string(options) + " -o " + a).exit_code == 0);
        const Result progressive =
            scotty_here(kPicture + std::string(options) + " --progressive -o " + b);
        CHECK(progressive.exit_code == 0);
        CHECK(progressive.out.empty());
        CHECK_THAT(progressive.err, !ContainsSubstring("warning"));
        CHECK(same_picture(a, b));
        CHECK(scotty_here(kPicture + std::string(options) +
                          " --progressive --samples-per-pass 2 -o " + b)
                  .exit_code == 0);
        CHECK(same_picture(a, b));
    }
}

TEST_CASE("render --display: the viewer ends up with the picture in the file",
          "[verify][cli][progressive]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.exr");
    for (const char* options : {"--spp 6", "--spp 6 --filter median", "--spp 4 --backend embree"}) {
        TevServer server;
        const Result result = scotty_here(kPicture + std::string(options) + " -o " + file +
                                          " --display " + server.address());
        server.wait();
        CHECK(result.exit_code == 0);
        CHECK_THAT(result.err, !ContainsSubstring("warning"));
        CHECK(server.fault() == "");
        CHECK(server.packets() >= 1 + 2);  // created, the first pass, the whole
        REQUIRE(server.images().size() == 1);
        CHECK(server.images().begin()->first == file);
        CHECK(server.images().begin()->second.values == values_of(file));
    }
}

TEST_CASE("render --display: a viewer that is not there, or leaves, costs a warning and no picture",
          "[verify][cli][progressive]") {
    const TemporaryFolder folder;
    const std::string file = folder.file("a.exr");
    const std::string plain = folder.file("plain.exr");
    REQUIRE(scotty_here(kPicture + std::string("--spp 6 -o ") + plain).exit_code == 0);
    const auto check = [&](const std::string& address) {
        const Result result =
            scotty_here(kPicture + std::string("--spp 6 -o ") + file + " --display " + address);
        CHECK(result.exit_code == 0);
        CHECK_THAT(result.err, ContainsSubstring("warning: the display " + address) &&
                                   ContainsSubstring("rendering goes on without it"));
        CHECK(same_picture(file, plain));
    };
    std::string nobody;
    {
        const TevServer gone;
        nobody = gone.address();
    }
    check(nobody);
    for (const std::size_t packets : {std::size_t{1}, std::size_t{2}}) {
        const TevServer leaves([=](std::size_t got) { return got < packets; });
        check(leaves.address());
    }
}

TEST_CASE("render --progressive: Ctrl-C keeps the last complete image and says of how many samples",
          "[verify][cli][progressive]") {
    const TemporaryFolder folder;
    const std::string kept = folder.file("kept.exr");
    const std::string plain = folder.file("plain.exr");
    for (const auto& [signal, options] : {std::pair{SIGINT, ""},
                                          {SIGTERM, "--filter median --filter-threshold 1000000"},
                                          {SIGINT, "--backend embree"}}) {
        INFO(options);
        std::promise<void> shown;  // created, and two passes
        TevServer server([&](std::size_t packets) {
            if (packets == 3) shown.set_value();
            return true;
        });
        Child child(kPicture + std::string(options) + " --spp 1048576 -o " + kept + " --display " +
                        server.address(),
                    folder.file("err"));
        REQUIRE(shown.get_future().wait_for(std::chrono::minutes(2)) == std::future_status::ready);
        child.kill(signal);
        const int status = child.wait();
        server.wait();
        const std::string errors = slurp(folder.file("err"));
        INFO(errors);
        REQUIRE(WIFEXITED(status));
        CHECK(WEXITSTATUS(status) == 128 + signal);
        std::smatch found;
        REQUIRE(std::regex_search(errors, found,
                                  std::regex("stopped.* is a whole image of ([0-9]+) samples")));
        CHECK(scotty_here(kPicture + std::string(options) + " --spp " + found[1].str() + " -o " +
                          plain)
                  .exit_code == 0);
        CHECK(same_picture(kept, plain));
        CHECK(server.fault() == "");
        REQUIRE(server.images().count(kept) == 1);
        CHECK(server.images().at(kept).values == values_of(kept));
        CHECK_FALSE(std::filesystem::exists(folder.file("kept.unfinished.exr")));
    }
}

TEST_CASE("render --progressive: killed, the file is a whole image", "[verify][cli][progressive]") {
    const TemporaryFolder folder;
    const std::string kept = folder.file("kept.exr");
    std::promise<void> shown;
    TevServer server([&](std::size_t packets) {
        if (packets == 3) shown.set_value();
        return true;
    });
    Child child(
        kPicture + std::string("--spp 1048576 -o ") + kept + " --display " + server.address(),
        folder.file("err"));
    REQUIRE(shown.get_future().wait_for(std::chrono::minutes(2)) == std::future_status::ready);
    child.kill(SIGKILL);
    CHECK(WIFSIGNALED(child.wait()));
    CHECK(values_of(kept).size() == std::size_t{16} * 12 * 3);
}

}  // namespace scotty::verify::test
