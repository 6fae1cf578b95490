#include "emulation/check/bad_address.h"

#include <csignal>

#include "emulation/check/deliberate.h"
#include "emulation/check/source_line.h"
#include "emulation/execution/context.h"

namespace scotty::emulation::simt {

namespace {

struct WayOut {
    explicit WayOut(sigjmp_buf* here) { context.way_out = here; }
    ~WayOut() { context.way_out = nullptr; }
    WayOut(const WayOut&) = delete;
    WayOut& operator=(const WayOut&) = delete;
};

/// The signal comes from the very instruction that used the address: a kernel's, which holds no
/// lock and is inside no allocation.
void give_up(int signal) {
    if (context.way_out != nullptr) ::siglongjmp(*context.way_out, 1);
    std::signal(signal, SIG_DFL);
    ::raise(signal);
}

}  // namespace

void catch_bad_addresses() {
    for (const int signal : {SIGSEGV, SIGBUS}) {
        struct sigaction installed {};
        if (::sigaction(signal, nullptr, &installed) != 0) continue;
        if (installed.sa_handler != SIG_DFL) continue;
        struct sigaction ours {};
        ours.sa_handler = give_up;
        ours.sa_flags = SA_NODEFER;  // the jump out of the handler would not unblock the signal
        ::sigaction(signal, &ours, nullptr);
    }
}

std::string bad_address_in(void (*body)(void* argument), void* argument) {
    sigjmp_buf here;
    const WayOut open(&here);
    if (sigsetjmp(here, 0) == 0) {
        body(argument);
        return {};
    }
    // Comes first: in an instrumented program the functions of strings announce accesses.
    const auto place = reinterpret_cast<std::uintptr_t>(context.last_access);
    deliberate_read = false;  // the access may have been one
    const std::string what =
        "thread " + std::to_string(context.thread) + " reached memory that is not there";
    if (place == 0) return what + "; --check names the line";
    return what + " at " + source_line(static_cast<std::uint32_t>(place - program_begin()));
}

}  // namespace scotty::emulation::simt
