#include "verify/base/stop_signal.h"

#include <cstddef>

#include "verify/base/scratch_folder.h"

namespace scotty::verify {
namespace {

constexpr std::array kStopSignals{SIGINT, SIGTERM};
volatile std::sig_atomic_t stop_signal = 0;
std::array<struct sigaction, kStopSignals.size()> handlers_before;

extern "C" void note_stop_signal(int signal) {
    stop_signal = signal;
    for (std::size_t i = 0; i < kStopSignals.size(); ++i) {
        sigaction(kStopSignals[i], &handlers_before[i], nullptr);
    }
}

}  // namespace

StopSignals::StopSignals() {
    stop_signal = 0;
    remove_scratch_folders_on_signals();
    for (std::size_t i = 0; i < kStopSignals.size(); ++i) {
        sigaction(kStopSignals[i], nullptr, &before_[i]);
        handlers_before[i] = before_[i];
        if (before_[i].sa_handler == SIG_IGN) continue;
        struct sigaction noted {};
        noted.sa_handler = note_stop_signal;
        noted.sa_flags = SA_RESTART;
        sigaction(kStopSignals[i], &noted, nullptr);
    }
}

StopSignals::~StopSignals() {
    for (std::size_t i = 0; i < kStopSignals.size(); ++i) {
        sigaction(kStopSignals[i], &before_[i], nullptr);
    }
}

int StopSignals::received() const { return stop_signal; }

}  // namespace scotty::verify
