#include "verify/backends/temporary_capture.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <system_error>

#include "verify/capture/capture_writer.h"

namespace scotty::verify {

namespace fs = std::filesystem;

namespace {

fs::path temporary_folder() {
    static std::atomic<int> made{0};
    return fs::temp_directory_path() / fmt::format("scotty-{}-{}", getpid(), made++);
}

}  // namespace

TemporaryCapture::TemporaryCapture(const Backend& backend, const PipelineInput& input)
    : folder_(temporary_folder()) {
    CaptureWriter writer(folder_,
                         header_of(backend.name, input.scene, input.bvh, input.parameters));
    write_pipeline_input(writer.input_folder(), input.scene, input.bvh, input.parameters);
    backend.render(input, &writer);
    writer.finish();
    capture_.emplace(Capture::open(folder_));
}

TemporaryCapture::~TemporaryCapture() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
}

}  // namespace scotty::verify
