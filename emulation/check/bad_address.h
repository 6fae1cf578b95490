/// A kernel that uses memory which the process does not have ends its launch, not the process.
#pragma once

#include <string>

namespace scotty::emulation::simt {

/// From now on bad_address_in() notices bad addresses. Handlers that others have installed for
/// SIGSEGV and SIGBUS (sanitizers, debuggers) stay, and take precedence.
void catch_bad_addresses();

/// Runs a block's threads: `body(argument)`, which may throw. If one of them reaches memory that is
/// not there, all are abandoned where they are, nothing on their stacks is destroyed, and the text
/// is "thread 33 reached memory that is not there at gpu/kernels/intersect.h:252"; otherwise it is
/// empty. The line is that of the last access that instrumented code has announced; for other code
/// it is not known.
std::string bad_address_in(void (*body)(void* argument), void* argument);
template <class Body>
std::string bad_address_in(Body&& body) {
    return bad_address_in([](void* argument) { (*static_cast<Body*>(argument))(); }, &body);
}

}  // namespace scotty::emulation::simt
