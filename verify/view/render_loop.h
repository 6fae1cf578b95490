/// The session: what is looked at, and the thread that renders it.
///
/// Requests change what is wanted; the thread renders the newest of it and never a queue of it.
/// While the camera moves it makes pictures of few samples at a size that holds the frame rate; at
/// rest it refines the whole picture pass by pass (verify/render/progressive.h).
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "reference/contract/image.h"
#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/scene.h"
#include "verify/backends/backend.h"
#include "verify/view/display.h"
#include "verify/view/features.h"
#include "verify/view/messages.h"

namespace scotty::verify {

/// All that a picture depends on.
struct ViewState {
    std::string backend;
    reference::Camera camera;
    /// Of the whole picture: image_width and image_height; spp: of a picture at rest; filter: the
    /// chosen one.
    reference::PipelineParameters parameters;
    std::uint32_t moving_samples = 1;
    ViewSubject subject = ViewSubject::picture;
    ToneMap tone = ToneMap::clamp;
    float exposure = 0.0f;
    bool filtered = true;
    bool measured = false;
};

/// A picture for the viewers.
struct ShownPicture {
    std::uint64_t state = 0;  ///< the state it shows; states count from 1
    /// Radiance; null where there are colours instead. At rest it is unfiltered.
    std::shared_ptr<const reference::Image> image;
    reference::Filter filter = reference::Filter::none;  ///< that is to be applied to it
    ColorImage colors;
    ColorLegend legend;
    ViewState shows;
    std::uint32_t samples = 0;
    bool at_rest = false;  ///< of full size
    double render_seconds = 0.0;
    double samples_per_second = 0.0;
    nlohmann::json statistics;
    std::size_t device_bytes = 0;
};

/// What a change did: the same number of samples before and after.
struct ChangeEffect {
    std::string what;  ///< "tree width 8 to 4"
    double seconds_before = 0.0, seconds_after = 0.0;
    bool same_picture = false;
    bool should_be_same = false;  ///< nothing was changed that a picture is made of
    std::uint32_t samples = 0;
    std::string hash;
};

/// Called by the render thread.
struct RenderLoopEvents {
    std::function<void(ShownPicture&&)> shown;
    std::function<void(const ChangeEffect&)> changed;
    std::function<void(std::uint64_t asker, const Pick&, const TracedPath&)> picked;
    /// A request cannot be carried out: said to all viewers.
    std::function<void(const std::string&)> failed;
    std::function<void()> state_changed;
};

struct RenderLoopOptions {
    std::size_t threads = 0;
    double frame_rate = 15.0;  ///< that a moving picture gives up resolution for
    /// Options that were given, by name: other back ends keep them.
    std::function<bool(std::string_view)> is_given;
};

/// Batches of a CPU's back end are this small where nobody asks for others, so that a new request
/// is seen soon.
inline constexpr std::uint32_t kCpuBatchRays = 1u << 14;

class RenderLoop {
 public:
    /// Builds the tree and starts the thread. Throws as backend_named() does.
    RenderLoop(reference::Scene scene, ViewState first, RenderLoopOptions options,
               RenderLoopEvents events);
    ~RenderLoop();
    RenderLoop(const RenderLoop&) = delete;
    RenderLoop& operator=(const RenderLoop&) = delete;

    // Requests, from any thread. Each returns the number of the state that it made.
    std::uint64_t look(const reference::Camera& camera, bool moving);
    std::uint64_t own_camera();
    std::uint64_t frame_all();
    /// Throws bad_input for values that are not valid.
    std::uint64_t set(const SetValues& values);
    std::uint64_t show(const ShowAs& how);
    /// Throws bad_input where the back end has no stages or there is no such pixel.
    void pick(std::uint64_t asker, const Pick& pixel);
    /// With none, the device idles once the first picture is made.
    void set_viewers(std::size_t count);

    ViewState state() const;
    std::uint64_t state_number() const;
    const reference::Scene& scene() const;
    /// The newest whole picture at rest, unfiltered, and how many samples it has; empty before the
    /// first. `state`: what it shows.
    std::shared_ptr<const reference::Image> picture_at_rest(std::uint32_t& samples,
                                                            ViewState& state) const;

    /// Names that this program can switch to while it runs.
    static std::vector<std::string> backends();
    /// Why the back end cannot give a subject; empty where it can.
    static std::string cannot_show(const std::string& backend, ViewSubject subject);

 private:
    class State;
    std::unique_ptr<State> state_;
};

}  // namespace scotty::verify
