/// The switch of the planted faults: in scotty-mutants, and in nothing else.
#pragma once

namespace scotty::planted {

/// Position in the registry, from 1, of the fault that is switched on; 0: none. Set before anything
/// runs.
extern int active;
/// The registry, as JSON.
extern const char* const kRegistry;

}  // namespace scotty::planted

/// What generate.py puts into the copies that it makes.
#define SCOTTY_PLANTED(number) (::scotty::planted::active == (number))
