/// scotty/kernels.h
#include "emulation/cuda/include/scotty/kernels.h"

#include <string>

#include "emulation/cuda/machine.h"
#include "reference/base/error.h"

namespace scotty_cuda {

using scotty::emulation::cuda::Machine;

const char* take_findings(bool warnings) {
    static std::string text;
    text = Machine::get().take_findings(warnings);
    return text.c_str();
}

bool use_schedule(const char* name) {
    try {
        Machine::get().use(scotty::emulation::parse_schedule(name));
    } catch (const scotty::reference::Error&) {
        return false;
    }
    return true;
}

}  // namespace scotty_cuda
