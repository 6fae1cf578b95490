/// A kernel that reaches memory which the process does not have ends its launch, and not the
/// process.
#pragma once

#include <string>

namespace scotty::emulation::simt {

/// From now on bad_address_in() notices. Leaves alone what others have installed for SIGSEGV and
/// SIGBUS (sanitizers, debuggers): then those have their way.
void catch_bad_addresses();

/// Runs a block's threads: `body(argument)`, which may throw. Where one of them reaches memory that
/// is not there all are given up where they stand, what is on their stack is not destroyed, and the
/// text is "thread 33 reached memory that is not there at gpu/kernels/intersect.h:252"; else it is
/// empty. The line is that of the last access that instrumented code has announced; of other code
/// nobody knows it.
std::string bad_address_in(void (*body)(void* argument), void* argument);
template <class Body>
std::string bad_address_in(Body&& body) {
    return bad_address_in([](void* argument) { (*static_cast<Body*>(argument))(); }, &body);
}

}  // namespace scotty::emulation::simt
