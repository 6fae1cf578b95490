#include "verify/backends/temporary_capture.h"

#include "verify/capture/capture_writer.h"

namespace scotty::verify {

TemporaryCapture::TemporaryCapture(const Backend& backend, const PipelineInput& input) {
    CaptureWriter writer(folder_.path(),
                         header_of(backend.name, input.scene, input.bvh, input.parameters));
    write_pipeline_input(writer.input_folder(), input.scene, input.bvh, input.parameters);
    backend.render(input, &writer);
    writer.finish();
    capture_.emplace(Capture::open(folder_.path()));
}

}  // namespace scotty::verify
