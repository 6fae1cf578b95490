/// Pictures to frames, by a thread of its own: the renderer goes on meanwhile, and a picture that a
/// newer one has overtaken is never encoded.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "verify/view/render_loop.h"
#include "verify/view_module/view_module.h"

namespace scotty::verify {

/// A frame with what its header says of it, as JSON without the closing brace: a viewer's own part
/// follows.
struct EncodedFrame : ViewFrame {
    std::string header;
};

/// "type":"image/jpeg" where it moves, "image/png" at rest, in strips of rows, top to bottom, that
/// are encoded in parallel. The filter, false colours of the variance, hash and noise of a picture
/// at rest are made here, too, so that no renderer waits for them.
std::shared_ptr<EncodedFrame> encode_frame(const ViewModule& module, ShownPicture picture);

class Encoder {
 public:
    Encoder(const ViewModule& module,
            std::function<void(std::shared_ptr<const EncodedFrame>)> done);
    ~Encoder();
    Encoder(const Encoder&) = delete;
    Encoder& operator=(const Encoder&) = delete;

    void take(ShownPicture&& picture);

 private:
    void run();

    const ViewModule& module_;
    std::function<void(std::shared_ptr<const EncodedFrame>)> done_;
    std::mutex mutex_;
    std::condition_variable wake_;
    std::optional<ShownPicture> newest_;
    bool stop_ = false;
    std::uint64_t frames_ = 0;
    double frames_per_second_ = 0.0;
    std::thread thread_;
};

}  // namespace scotty::verify
