#include "verify/backends/temporary_capture.h"

#include "verify/capture/capture_writer.h"

namespace scotty::verify {

namespace {

/// Small runs, of which a verification makes hundreds, never touch the disk; large ones do not take
/// all memory.
constexpr std::size_t kMostInMemory = std::size_t{1} << 30;

}  // namespace

TemporaryCapture::TemporaryCapture(const Backend& backend, const PipelineInput& input) {
    CaptureWriter writer(folder_.path(),
                         header_of(backend.name, input.scene, input.bvh, input.parameters));
    write_pipeline_input(writer.input_folder(), input.scene, input.bvh, input.parameters);
    writer.keep_in_memory(kMostInMemory);
    backend.render(input, &writer);
    capture_.emplace(writer.finish_here());
}

}  // namespace scotty::verify
