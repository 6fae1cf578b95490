/// A view with its viewers: messages to requests, pictures to frames, and what is beside the
/// picture.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "scenes/viewpoints.h"
#include "verify/view/render_loop.h"
#include "verify/view_module/view_module.h"

namespace scotty::verify {

struct ViewOptions {
    std::string address = "127.0.0.1";
    std::uint16_t port = 0;
    std::string token;  ///< empty: a random one
    std::string version;
    std::vector<scenes::Viewpoint> viewpoints;  ///< the cameras of the scene's file
    RenderLoopOptions loop;
};

/// Serves until it goes.
class ViewSession {
 public:
    /// Throws missing_environment where the module or the address cannot be had.
    ViewSession(reference::Scene scene, ViewState first, ViewOptions options);
    ~ViewSession();
    ViewSession(const ViewSession&) = delete;
    ViewSession& operator=(const ViewSession&) = delete;

    /// "http://127.0.0.1:40123/TOKEN/"
    std::string link() const;
    /// Waits until the first picture is made; returns at once afterwards.
    void wait_for_first_picture();

 private:
    class State;
    std::unique_ptr<State> state_;
};

/// 128 random bits as hexadecimal digits, from the system.
std::string random_token();

}  // namespace scotty::verify
