/// Ctrl-C as a request: what is complete is kept.
#pragma once

#include <array>
#include <csignal>

namespace scotty::verify {

/// While it lives, the first SIGINT or SIGTERM is noted, for a long run to ask about; the second
/// ends the program as ever. A signal that was ignored (nohup) stays so. One at a time.
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
