/// For tests of CUDA kernels that run on a CPU (scotty_add_kernel_program): what the checker found.
#pragma once

#include <cstddef>
#include <string>

namespace scotty_cuda {

/// What was found since the last call, as text; forgets it. `warnings`: also same-value races.
/// Valid until the next call.
const char* take_findings(bool warnings);
/// Kernels that run later do so in that order: "linear", "reversed", "adversarial", "shuffle:7".
/// False where there is no such order.
bool use_schedule(const char* name);

}  // namespace scotty_cuda

namespace scotty::kernels {

/// Empty where every kernel since the last call was sound: CHECK(take_findings() == "").
inline std::string take_findings(bool warnings = false) {
    return scotty_cuda::take_findings(warnings);
}
inline bool use_schedule(const std::string& name) {
    return scotty_cuda::use_schedule(name.c_str());
}

}  // namespace scotty::kernels
