/// What a viewer may ask for, as the protocol of docs/view.md has it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "reference/contract/pipeline_parameters.h"
#include "reference/contract/records.h"

namespace scotty::verify {

/// What the picture shows.
enum class ViewSubject { picture, distance, primitive, normal, queues, bounces, variance };
inline constexpr std::size_t kViewSubjects = 7;
const char* to_string(ViewSubject subject);

enum class ToneMap { clamp, reinhard, filmic };
const char* to_string(ToneMap tone);

/// A camera by what it looks at.
struct LookAt {
    reference::Vec3 position, target, up;
    float tan_half_fov = 0.5f;
    bool moving = false;  ///< more of these will follow at once
};
/// The scene's own camera again, bit for bit, or one of the file's by its place in `hello`.
struct OwnCamera {
    std::optional<std::uint32_t> number;
};
/// All of the scene from where the camera looks.
struct FrameAll {};
/// Names and values of parameters (reference/contract/parameter_table.h), "size" as "640x480",
/// "backend" and "moving_samples".
struct SetValues {
    std::vector<std::pair<std::string, std::string>> values;
};
/// How the picture is shown; what is missing stays.
struct ShowAs {
    std::optional<ViewSubject> subject;
    std::optional<ToneMap> tone;
    std::optional<float> exposure;  ///< powers of two, -64 to 64
    std::optional<bool> filtered;   ///< false: the chosen filter is left out
    std::optional<bool> measured;   ///< true: launches are timed, on a device too
};
/// The path through a pixel of the full-size image.
struct Pick {
    std::uint32_t x = 0, y = 0;
};
/// Work that another process does.
struct StartJob {
    std::string kind;  ///< "verify", "queues", "compare"
    std::uint32_t x = 0, y = 0;
    // Of a comparison: the other side, and what is planted in this view's own back end.
    std::string backend, plant, own_plant;
};
struct StopJob {
    std::string kind;
};
/// A frame has been shown.
struct Seen {};

struct ViewMessage {
    /// The viewer's own number of the message; frames name the last one that they show.
    std::uint64_t id = 0;
    std::variant<LookAt, OwnCamera, FrameAll, SetValues, ShowAs, Pick, StartJob, StopJob, Seen>
        what;
};

/// Throws reference::Error (bad_input) saying what was expected.
ViewMessage parse_message(std::string_view text);

/// The camera that looks so. Throws bad_input where it has no direction or is out of range.
reference::Camera camera_of(const LookAt& look);

}  // namespace scotty::verify
