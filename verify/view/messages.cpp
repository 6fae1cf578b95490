#include "verify/view/messages.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"

namespace scotty::verify {
namespace {

using nlohmann::json;
using reference::Error;
using reference::Vec3;

constexpr std::array kSubjects{"picture", "distance", "primitive", "normal",
                               "queues",  "bounces",  "variance"};
static_assert(kSubjects.size() == kViewSubjects);
constexpr std::array kTones{"clamp", "reinhard", "filmic"};
constexpr std::size_t kMostValues = 32;
constexpr std::size_t kMostWord = 200;

[[noreturn]] void fail(const std::string& where, const std::string& what) {
    throw Error::bad_input(where, what);
}

const json* find(const json& message, const char* name) {
    const auto found = message.find(name);
    return found == message.end() || found->is_null() ? nullptr : &*found;
}
const json& member(const json& message, const char* name) {
    const json* found = find(message, name);
    if (found == nullptr) fail("message", fmt::format("has no \"{}\"", name));
    return *found;
}

float number(const json& value, const char* name, float low, float high) {
    const double found = value.is_number() ? value.get<double>() : std::nan("");
    if (!(found >= static_cast<double>(low) && found <= static_cast<double>(high))) {
        fail(name, fmt::format("expected a number from {} to {}", low, high));
    }
    return static_cast<float>(found);
}
std::uint64_t count(const json& value, const char* name, std::uint64_t high) {
    const bool is_count = value.is_number_unsigned() && value.get<std::uint64_t>() <= high;
    if (!is_count) fail(name, fmt::format("expected a whole number from 0 to {}", high));
    return value.get<std::uint64_t>();
}
bool truth(const json& value, const char* name) {
    if (!value.is_boolean()) fail(name, "expected true or false");
    return value.get<bool>();
}
std::string word(const json& value, const char* name) {
    if (!value.is_string() || value.get_ref<const std::string&>().size() > kMostWord) {
        fail(name, "expected a short text");
    }
    return value.get<std::string>();
}
Vec3 vector(const json& message, const char* name) {
    const json& value = member(message, name);
    if (!value.is_array() || value.size() != 3) fail(name, "expected an array of three numbers");
    const auto at = [&](std::size_t i) {
        return number(value[i], name, -reference::kMaxCoordinate, reference::kMaxCoordinate);
    };
    return {at(0), at(1), at(2)};
}
template <class Enum, std::size_t N>
Enum choice(const json& value, const char* name, const std::array<const char*, N>& words) {
    const std::string found = word(value, name);
    for (std::size_t i = 0; i < N; ++i) {
        if (found == words[i]) return static_cast<Enum>(i);
    }
    fail(name, fmt::format("expected one of {}", fmt::join(words, ", ")));
}

LookAt look_at(const json& message) {
    constexpr float kLeastAngle = 0.1f;
    constexpr float kMostAngle = 170.0f;
    LookAt look;
    look.position = vector(message, "position");
    look.target = vector(message, "target");
    look.up = vector(message, "up");
    const float degrees = number(member(message, "fov"), "fov", kLeastAngle, kMostAngle);
    look.tan_half_fov =
        static_cast<float>(std::tan(static_cast<double>(degrees) * (std::acos(-1.0) / 360.0)));
    if (const json* moving = find(message, "moving")) look.moving = truth(*moving, "moving");
    return look;
}

SetValues set_values(const json& message) {
    const json& values = member(message, "values");
    if (!values.is_object() || values.size() > kMostValues) fail("values", "expected an object");
    SetValues out;
    for (const auto& [name, value] : values.items()) {
        out.values.emplace_back(name.substr(0, kMostWord), word(value, "values"));
    }
    return out;
}

ShowAs show_as(const json& message) {
    ShowAs out;
    if (const json* v = find(message, "what"))
        out.subject = choice<ViewSubject>(*v, "what", kSubjects);
    if (const json* v = find(message, "tone")) out.tone = choice<ToneMap>(*v, "tone", kTones);
    if (const json* v = find(message, "exposure")) out.exposure = number(*v, "exposure", -64, 64);
    if (const json* v = find(message, "filtered")) out.filtered = truth(*v, "filtered");
    if (const json* v = find(message, "measured")) out.measured = truth(*v, "measured");
    return out;
}

StartJob start_job(const json& message) {
    StartJob out;
    out.kind = word(member(message, "job"), "job");
    if (out.kind == "queues") {
        out.x = static_cast<std::uint32_t>(count(member(message, "x"), "x", 65535));
        out.y = static_cast<std::uint32_t>(count(member(message, "y"), "y", 65535));
    } else if (out.kind == "compare") {
        out.backend = word(member(message, "backend"), "backend");
        if (const json* plant = find(message, "plant")) out.plant = word(*plant, "plant");
        if (const json* own = find(message, "own_plant")) out.own_plant = word(*own, "own_plant");
    } else if (out.kind != "verify") {
        fail("job", "expected verify, queues or compare");
    }
    return out;
}

}  // namespace

const char* to_string(ViewSubject subject) { return kSubjects[static_cast<std::size_t>(subject)]; }
const char* to_string(ToneMap tone) { return kTones[static_cast<std::size_t>(tone)]; }

ViewMessage parse_message(std::string_view text) {
    const json message = json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!message.is_object()) fail("message", "expected a JSON object");
    ViewMessage out;
    if (const json* id = find(message, "id")) out.id = count(*id, "id", 1ull << 53);
    const std::string type = word(member(message, "type"), "type");
    if (type == "camera") {
        out.what = look_at(message);
    } else if (type == "own camera") {
        OwnCamera own;
        if (const json* number = find(message, "number")) {
            own.number = static_cast<std::uint32_t>(count(*number, "number", 65535));
        }
        out.what = own;
    } else if (type == "frame all") {
        out.what = FrameAll{};
    } else if (type == "set") {
        out.what = set_values(message);
    } else if (type == "show") {
        out.what = show_as(message);
    } else if (type == "pick") {
        out.what = Pick{static_cast<std::uint32_t>(count(member(message, "x"), "x", 65535)),
                        static_cast<std::uint32_t>(count(member(message, "y"), "y", 65535))};
    } else if (type == "start") {
        out.what = start_job(message);
    } else if (type == "stop") {
        out.what = StopJob{word(member(message, "job"), "job")};
    } else if (type == "seen") {
        out.what = Seen{};
    } else {
        fail("type", "no such message");
    }
    return out;
}

reference::Camera camera_of(const LookAt& look) {
    // Both lengths in double precision: coordinates reach 1e12, whose squares floats do not hold.
    const auto direction = [](const Vec3& v) {
        const double x = v.x;
        const double y = v.y;
        const double z = v.z;
        const double length = std::sqrt(x * x + y * y + z * z);
        if (!(length > 0.0)) return Vec3(0.0f, 0.0f, 0.0f);
        return Vec3(static_cast<float>(x / length), static_cast<float>(y / length),
                    static_cast<float>(z / length));
    };
    const Vec3 forward = direction(look.target - look.position);
    const Vec3 right = direction(reference::cross(forward, direction(look.up)));
    if (reference::is_zero(forward) || reference::is_zero(right)) {
        fail("camera", "position, target and up give no direction");
    }
    reference::Camera camera;
    camera.position = look.position;
    camera.forward = forward;
    camera.right = right;
    camera.up = direction(reference::cross(right, forward));
    camera.tan_half_fov = look.tan_half_fov;
    return camera;
}

}  // namespace scotty::verify
