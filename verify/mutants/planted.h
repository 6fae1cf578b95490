/// The switch of the planted faults, which only scotty-mutants has.
#pragma once

namespace scotty::planted {

/// Position in the registry, from 1, of the fault that is switched on; 0: none. It is set before
/// anything runs.
extern int active;
/// The registry, as JSON.
extern const char* const kRegistry;

}  // namespace scotty::planted

/// generate.py puts this into its copies.
#define SCOTTY_PLANTED(number) (::scotty::planted::active == (number))
