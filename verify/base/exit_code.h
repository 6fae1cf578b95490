/// What the exit code of `scotty` says.
#pragma once

namespace scotty::verify {

/// Exit codes, the same for every subcommand.
inline constexpr int kExitPassed = 0;
inline constexpr int kExitFailed = 1;              ///< a verification failed
inline constexpr int kExitUsage = 2;               ///< usage or input is wrong, or nothing matched
inline constexpr int kExitMissingEnvironment = 3;  ///< something required is not on this machine
inline constexpr int kExitInternal = 70;
/// Plus the signal's number, as a shell has it: stopped by Ctrl-C (130), and what was done is kept.
inline constexpr int kExitStopped = 128;

}  // namespace scotty::verify
