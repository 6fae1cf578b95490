/// The CUDA pipeline as a back end. The program scotty-cuda links with_cuda.cpp, all others
/// without_cuda.cpp, so that an edit of a kernel waits for the CUDA compiler only where a device is
/// asked for.
#pragma once

#include <optional>

#include "verify/backends/backend.h"
#include "verify/backends/machine.h"

namespace scotty::verify {

/// In scotty-cuda: throws missing_environment without a device. In scotty: goes on as scotty-cuda
/// and does not return; throws missing_environment where that is not there. In other programs:
/// throws missing_environment.
Backend cuda_backend();

/// What scotty-cuda sees; nothing in other programs.
std::optional<CudaDescription> find_cuda();

}  // namespace scotty::verify
