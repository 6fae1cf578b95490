#include "verify/view/jobs.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <utility>

extern char** environ;

namespace scotty::verify {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMostOutput = 1u << 16;
constexpr std::chrono::milliseconds kPoll{10};
/// A command that was asked to end has so long for it.
constexpr std::chrono::seconds kGrace{3};

/// The plain program beside this one: it goes on as another where that is needed.
fs::path program() {
    std::error_code ignored;
    const fs::path self = fs::read_symlink("/proc/self/exe", ignored);
    const fs::path plain = self.parent_path() / "scotty";
    return fs::exists(plain, ignored) ? plain : self;
}

std::string tail_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (text.size() > kMostOutput) text.erase(0, text.size() - kMostOutput);
    return text;
}

}  // namespace

Job::Job(std::vector<std::vector<std::string>> commands, const fs::path& folder,
         std::function<void(const JobResult&)> done)
    : output_(folder / "output.txt"), done_(std::move(done)) {
    thread_ = std::thread([this, all = std::move(commands)] { run(all); });
}

Job::~Job() {
    stop();
    thread_.join();
}

void Job::run(const std::vector<std::vector<std::string>>& commands) {
    JobResult result;
    for (const auto& words : commands) {
        result.exit_code = run_one(words, result);
        if (result.stopped || result.signal != 0 || result.exit_code > 1) break;
    }
    result.output += tail_of(output_);
    is_done_ = true;
    done_(result);
}

int Job::run_one(const std::vector<std::string>& words, JobResult& result) const {
    std::vector<std::string> copy{"scotty"};
    copy.insert(copy.end(), words.begin(), words.end());
    std::vector<char*> arguments;
    arguments.reserve(copy.size() + 1);
    for (std::string& word : copy) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, output_.c_str(),
                                     O_WRONLY | O_CREAT | O_APPEND, 0600);
    posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    // A group of its own: Ctrl-C is the view's, which then ends it.
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGDEF);
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGINT);
    sigaddset(&usual, SIGTERM);
    sigaddset(&usual, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    pid_t process = -1;
    const int error =
        posix_spawn(&process, program().c_str(), &files, &attributes, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    if (error != 0) {
        result.output += program().string() + ": " + std::strerror(error) + "\n";
        return 127;
    }
    int status = 0;
    std::chrono::steady_clock::time_point asked{};
    while (waitpid(process, &status, WNOHANG) == 0) {
        if (stop_ && !result.stopped) {
            result.stopped = true;
            asked = std::chrono::steady_clock::now();
            kill(-process, SIGTERM);
        }
        if (result.stopped && std::chrono::steady_clock::now() - asked > kGrace) {
            kill(-process, SIGKILL);
        }
        std::this_thread::sleep_for(kPoll);
    }
    if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace scotty::verify
