/// A process that crashes says what was under way, and ends as a failed verification.
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "emulation/check/bad_address.h"
#include "tests/catch.h"
#include "verify/base/exit_code.h"
#include "verify/sweep/crash_verdict.h"

namespace scotty::verify::test {
namespace {

struct Ended {
    int status;
    std::string said;
};

/// A child that lets `crash` happen. It starts no threads, and does not return from here.
template <class Crash>
Ended child_that(const Crash& crash) {
    std::array<int, 2> pipe{};
    REQUIRE(::pipe(pipe.data()) == 0);
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        ::dup2(pipe[1], STDERR_FILENO);
        // Not the test framework's.
        for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) {
            std::signal(signal, SIG_DFL);
        }
        crash();
        ::_exit(0);
    }
    ::close(pipe[1]);
    Ended ended{};
    std::array<char, 4096> some{};
    for (ssize_t got = 0; (got = ::read(pipe[0], some.data(), some.size())) > 0;) {
        ended.said.append(some.data(), static_cast<std::size_t>(got));
    }
    ::close(pipe[0]);
    ::waitpid(child, &ended.status, 0);
    return ended;
}

}  // namespace

TEST_CASE("crash: what was under way is said, and the verification has failed", "[verify][crash]") {
    for (const auto& [signal, word] : {std::pair{SIGSEGV, "SIGSEGV"},
                                       {SIGBUS, "SIGBUS"},
                                       {SIGFPE, "SIGFPE"},
                                       {SIGILL, "SIGILL"},
                                       {SIGABRT, "SIGABRT"}}) {
        CAPTURE(word);
        const Ended ended = child_that([number = signal] {
            catch_crashes();
            const UnderWay first("width 8", "scotty verify cornell --width 8");
            { const UnderWay over("width 4", "scotty verify cornell --width 4"); }
            const UnderWay second("width 2", "scotty verify cornell --width 2");
            ::raise(number);
        });
        REQUIRE(WIFEXITED(ended.status));
        CHECK(WEXITSTATUS(ended.status) == kExitFailed);
        CHECK(ended.said.find(word) != std::string::npos);
        CHECK(ended.said.find("scotty verify cornell --width 8\n") != std::string::npos);
        CHECK(ended.said.find("scotty verify cornell --width 2\n") != std::string::npos);
        CHECK(ended.said.find("--width 4") == std::string::npos);
        CHECK(ended.said.find("verify: FAILED") != std::string::npos);
    }
}

TEST_CASE("hang: where nothing ends any more, the verification has failed", "[verify][crash]") {
    using namespace std::chrono_literals;
    const Ended ended = child_that([] {
        catch_hangs(200ms);
        const UnderWay run("width 8", "scotty verify cornell --width 8");
        std::this_thread::sleep_for(60s);
    });
    REQUIRE(WIFEXITED(ended.status));
    CHECK(WEXITSTATUS(ended.status) == kExitFailed);
    CHECK(ended.said.find("first failure: [hang]") != std::string::npos);
    CHECK(ended.said.find("scotty verify cornell --width 8\n") != std::string::npos);
    CHECK(ended.said.find("verify: FAILED") != std::string::npos);
}

TEST_CASE("hang: what ends now and then does not hang, nor what nobody waits for",
          "[verify][crash]") {
    using namespace std::chrono_literals;
    const Ended ended = child_that([] {
        catch_hangs(2s);
        for (int i = 0; i < 25; ++i) {
            std::this_thread::sleep_for(100ms);
            note_progress();
        }
        catch_hangs(100ms);
        catch_hangs(0ms);
        std::this_thread::sleep_for(500ms);
    });
    REQUIRE(WIFEXITED(ended.status));
    CHECK(WEXITSTATUS(ended.status) == 0);
    CHECK(ended.said.empty());
}

TEST_CASE("crash: more runs than can be named are no harm", "[verify][crash]") {
    const Ended ended = child_that([] {
        catch_crashes();
        std::vector<std::unique_ptr<UnderWay>> all;
        for (int i = 0; i < 100; ++i) {
            all.push_back(std::make_unique<UnderWay>("run " + std::to_string(i), "command"));
        }
        all.erase(all.begin(), all.begin() + 10);
        const UnderWay again("run again", "command");
        ::raise(SIGSEGV);
    });
    REQUIRE(WIFEXITED(ended.status));
    CHECK(ended.said.find("run again") != std::string::npos);
    CHECK(ended.said.find("run 63\n") != std::string::npos);
    CHECK(ended.said.find("run 9\n") == std::string::npos);
}

TEST_CASE("crash: a kernel that reaches memory which is not there ends its launch, not the process",
          "[verify][crash]") {
    const Ended ended = child_that([] {
        catch_crashes();
        for (int again = 0; again < 2; ++again) {
            const std::string said = emulation::simt::bad_address_in([] {
                volatile int* const nowhere = reinterpret_cast<volatile int*>(std::uintptr_t{16});
                *nowhere = 1;
            });
            if (said.find("memory that is not there") == std::string::npos) ::_exit(3);
        }
    });
    REQUIRE(WIFEXITED(ended.status));
    CHECK(WEXITSTATUS(ended.status) == 0);
    CHECK(ended.said.empty());
}

TEST_CASE("crash: handlers of others stay", "[verify][crash]") {
    const Ended ended = child_that([] {
        std::signal(SIGSEGV, [](int) { ::_exit(42); });
        catch_crashes();
        ::raise(SIGSEGV);
    });
    REQUIRE(WIFEXITED(ended.status));
    CHECK(WEXITSTATUS(ended.status) == 42);
    CHECK(ended.said.empty());
}

}  // namespace scotty::verify::test
