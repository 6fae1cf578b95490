#include "scenes/camera_file.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"

namespace scotty::scenes {

using nlohmann::json;
using reference::Camera;
using reference::Error;
using reference::Vec3;

namespace {

constexpr std::size_t kMostBytes = 4096;  // a camera has a few hundred

json to_json(const Vec3& v) { return json::array({v.x, v.y, v.z}); }

const json& member(const std::string& path, const json& camera, const char* name) {
    const auto found = camera.find(name);
    if (found == camera.end()) {
        throw Error::bad_input(path, fmt::format("the camera has no \"{}\"", name));
    }
    return *found;
}

float number(const std::string& path, const json& value, const char* name) {
    if (!value.is_number()) {
        throw Error::bad_input(path, fmt::format("\"{}\" is not made of numbers", name));
    }
    return value.get<float>();
}

Vec3 vector(const std::string& path, const json& camera, const char* name) {
    const json& value = member(path, camera, name);
    if (!value.is_array() || value.size() != 3) {
        throw Error::bad_input(path, fmt::format("\"{}\" is no array of three numbers", name));
    }
    return {number(path, value[0], name), number(path, value[1], name),
            number(path, value[2], name)};
}

}  // namespace

std::string camera_text(const Camera& camera) {
    nlohmann::ordered_json text{{"position", to_json(camera.position)},
                                {"right", to_json(camera.right)},
                                {"up", to_json(camera.up)},
                                {"forward", to_json(camera.forward)},
                                {"tan_half_fov", camera.tan_half_fov}};
    if (camera.tan_half_width != 0.0f) text["tan_half_width"] = camera.tan_half_width;
    return text.dump(1) + "\n";
}

Camera read_camera_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error::bad_input(path, "no such camera file");
    std::string text;
    for (auto at = std::istreambuf_iterator<char>(file); at != std::istreambuf_iterator<char>();
         ++at) {
        text += *at;
        if (text.size() > kMostBytes) throw Error::bad_input(path, "is too long for a camera");
    }
    const json camera = json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!camera.is_object()) {
        throw Error::bad_input(path, "expected a camera as a JSON object, as scotty view saves it");
    }
    Camera out;
    out.position = vector(path, camera, "position");
    out.right = vector(path, camera, "right");
    out.up = vector(path, camera, "up");
    out.forward = vector(path, camera, "forward");
    out.tan_half_fov = number(path, member(path, camera, "tan_half_fov"), "tan_half_fov");
    if (camera.contains("tan_half_width")) {
        out.tan_half_width = number(path, camera["tan_half_width"], "tan_half_width");
    }
    return out;
}

std::optional<std::string> take_camera_file(std::string& specification) {
    constexpr std::string_view kChoice = "camera=";
    constexpr std::string_view kEnd = ".camera";
    for (std::size_t mark = specification.rfind(kChoice);
         mark != std::string::npos && mark > 0 && specification.find('#') < mark;
         mark = specification.rfind(kChoice, mark - 1)) {
        const char before = specification[mark - 1];
        if (before != '#' && before != ',') continue;
        const std::size_t end =
            std::min(specification.find_first_of("#,", mark), specification.size());
        const std::size_t begin = mark + kChoice.size();
        const std::string file = specification.substr(begin, end - begin);
        if (!file.ends_with(kEnd)) continue;
        const bool another_follows = end < specification.size() && specification[end] == ',';
        if (another_follows) {
            specification.erase(mark, end + 1 - mark);
        } else {
            specification.erase(mark - 1, end - (mark - 1));
        }
        return file;
    }
    return std::nullopt;
}

}  // namespace scotty::scenes
