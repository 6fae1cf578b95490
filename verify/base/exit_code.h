/// The exit codes of `scotty`.
#pragma once

namespace scotty::verify {

/// Exit codes, the same for every subcommand.
inline constexpr int kExitPassed = 0;
inline constexpr int kExitFailed = 1;              ///< a verification failed
inline constexpr int kExitUsage = 2;               ///< usage or input is wrong, or nothing matched
inline constexpr int kExitMissingEnvironment = 3;  ///< this machine lacks something required
inline constexpr int kExitInternal = 70;
/// Plus the signal's number, as in a shell: stopped by Ctrl-C (130); finished work is kept.
inline constexpr int kExitStopped = 128;

}  // namespace scotty::verify
