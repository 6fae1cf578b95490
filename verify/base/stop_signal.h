/// Ctrl-C as a request: finished work is kept.
#pragma once

#include <array>
#include <csignal>

namespace scotty::verify {

/// While it lives, a long run can ask about the first SIGINT or SIGTERM; the second ends the
/// program as usual. An ignored signal (nohup) stays ignored. Only one may live at a time.
class StopSignals {
 public:
    StopSignals();
    ~StopSignals();
    StopSignals(const StopSignals&) = delete;
    StopSignals& operator=(const StopSignals&) = delete;

    /// The signal that came, or 0.
    int received() const;

 private:
    std::array<struct sigaction, 2> before_{};
};

}  // namespace scotty::verify
