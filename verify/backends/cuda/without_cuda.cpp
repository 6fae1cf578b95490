#include <fmt/format.h>

#include <filesystem>

#include "reference/base/error.h"
#include "verify/backends/checked_program.h"
#include "verify/backends/cuda/cuda_backend.h"

namespace scotty::verify {

namespace fs = std::filesystem;

Backend cuda_backend() {
    std::error_code ignored;
    const fs::path self = fs::read_symlink("/proc/self/exe", ignored);
    // Only from the plain program: one that was started for --check or --plant has no such twin.
    if (self.filename() != "scotty") {
        throw reference::Error::missing_environment(fmt::format(
            "back end cuda: {} has no CUDA pipeline, only scotty-cuda", self.filename().string()));
    }
    const fs::path with_cuda = self.parent_path() / "scotty-cuda";
    if (!fs::exists(with_cuda, ignored)) {
        throw reference::Error::missing_environment(fmt::format(
            "back end cuda: {} is not there; it is built where there is a CUDA compiler (./run "
            "builds it, or the target scotty_cuda), or capture on the other machine with "
            "scotty-gpu (docs/gpu.md)",
            with_cuda.string()));
    }
    become_program("scotty-cuda", "--backend cuda");
    throw reference::Error::internal("become_program() has returned");
}

std::optional<CudaDescription> find_cuda() { return std::nullopt; }

}  // namespace scotty::verify
