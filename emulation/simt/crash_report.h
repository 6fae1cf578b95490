/// Names kernel, block and thread when a kernel reaches memory that the process does not have.
#pragma once

namespace scotty::emulation::simt {

/// Once a process; leaves alone what others have installed (sanitizers, debuggers). The process
/// still ends by its signal.
void report_crashes();

}  // namespace scotty::emulation::simt
