#include "verify/sweep/crash_verdict.h"

#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "emulation/check/bad_address.h"
#include "emulation/execution/context.h"
#include "verify/base/exit_code.h"

namespace scotty::verify {

namespace {

struct CrashSignal {
    int number;
    const char* name;
};
constexpr std::array kCrashSignals{CrashSignal{SIGSEGV, "a bad address (SIGSEGV)"},
                                   CrashSignal{SIGBUS, "a bad address (SIGBUS)"},
                                   CrashSignal{SIGFPE, "an arithmetic fault (SIGFPE)"},
                                   CrashSignal{SIGILL, "an illegal instruction (SIGILL)"},
                                   CrashSignal{SIGABRT, "abort() (SIGABRT)"}};

constexpr std::size_t kSlots = 64;
/// Texts of what is under way; null where a slot is free.
std::array<std::atomic<const char*>, kSlots> named_under_way{};
struct sigaction executor_of_bad_address {};

/// Only what a signal handler may do.
void say(std::string_view text) {
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text.data(), text.size());
}

[[noreturn]] void end_as_failed() {
    for (const auto& slot : named_under_way) {
        const char* const text = slot.load();
        if (text != nullptr) say(text);
    }
    say("verify: FAILED\n");
    ::_exit(kExitFailed);
}

extern "C" void judge_crash(int signal) {
    if (emulation::simt::context.way_out != nullptr &&
        executor_of_bad_address.sa_handler != nullptr && (signal == SIGSEGV || signal == SIGBUS)) {
        executor_of_bad_address.sa_handler(signal);  // ends the launch, and does not return
    }
    const char* name = "a signal";
    for (const CrashSignal& known : kCrashSignals) {
        if (known.number == signal) name = known.name;
    }
    say("scotty: error: first failure: [crash] ");
    say(name);
    say(" ended the process, so there is no report; under way was:\n");
    end_as_failed();
}

std::atomic<std::uint64_t> things_ended{0};
std::atomic<std::int64_t> patience_in_ms{0};

void watch_for_hangs() {
    using Clock = std::chrono::steady_clock;
    std::uint64_t known = things_ended;
    Clock::time_point since = Clock::now();
    while (true) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        const std::uint64_t now = things_ended;
        const std::int64_t patience = patience_in_ms;
        if (now != known || patience == 0) {
            known = now;
            since = Clock::now();
        } else if (Clock::now() - since > std::chrono::milliseconds(patience)) {
            say("scotty: error: first failure: [hang] nothing has ended for " +
                std::to_string(patience / 1000) + " s, so there is no report; under way was:\n");
            end_as_failed();
        }
    }
}

}  // namespace

void catch_crashes() {
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    const auto handler_of = [](int signal) {
        struct sigaction installed {};
        ::sigaction(signal, nullptr, &installed);
        return installed.sa_handler;
    };
    const bool is_free = handler_of(SIGSEGV) == SIG_DFL;
    if (is_free) {
        emulation::simt::catch_bad_addresses();  // stays, behind the handler below
        ::sigaction(SIGSEGV, nullptr, &executor_of_bad_address);
    }
    for (const CrashSignal& signal : kCrashSignals) {
        const bool is_address = signal.number == SIGSEGV || signal.number == SIGBUS;
        if (is_address ? !is_free : handler_of(signal.number) != SIG_DFL) continue;
        struct sigaction judged {};
        judged.sa_handler = judge_crash;
        judged.sa_flags = SA_NODEFER;  // as the executor's, which jumps out of it
        ::sigaction(signal.number, &judged, nullptr);
    }
}

void catch_hangs(std::chrono::milliseconds patience) {
    patience_in_ms = patience.count();
    if (patience.count() == 0) return;
    static const bool watched = [] {
        std::thread(watch_for_hangs).detach();
        return true;
    }();
    static_cast<void>(watched);
}

void note_progress() { ++things_ended; }

UnderWay::UnderWay(const std::string& what, const std::string& command)
    : text_("  " + what + "\n    " + command + "\n"), slot_(kSlots) {
    for (std::size_t i = 0; i < kSlots; ++i) {
        const char* free = nullptr;
        if (!named_under_way[i].compare_exchange_strong(free, text_.c_str())) continue;
        slot_ = i;
        return;
    }
}

UnderWay::~UnderWay() {
    if (slot_ < kSlots) named_under_way[slot_].store(nullptr);
    note_progress();
}

}  // namespace scotty::verify
