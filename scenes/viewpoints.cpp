#include "scenes/viewpoints.h"

#include <fmt/format.h>

#include <algorithm>

namespace scotty::scenes {

namespace {

constexpr std::size_t kMostViewpoints = 256;

/// Names that mean something else after "#camera=".
bool is_taken(const std::vector<Viewpoint>& viewpoints, const std::string& name) {
    const bool is_choice = name == "file" || name == "fit" || name.ends_with(".camera");
    return is_choice || std::any_of(viewpoints.begin(), viewpoints.end(),
                                    [&](const Viewpoint& other) { return other.name == name; });
}

}  // namespace

void add_viewpoint(std::vector<Viewpoint>& viewpoints, const std::string& name,
                   const reference::Camera& camera) {
    if (viewpoints.size() >= kMostViewpoints) return;
    std::string plain = name.empty() ? fmt::format("camera {}", viewpoints.size() + 1) : name;
    for (char& c : plain) {
        if (c == ',' || c == '#' || static_cast<unsigned char>(c) < ' ') c = '_';
    }
    std::string own = plain;
    for (std::size_t number = 2; is_taken(viewpoints, own); ++number) {
        own = fmt::format("{} {}", plain, number);
    }
    viewpoints.push_back({own, camera});
}

std::string names_of(const std::vector<Viewpoint>& viewpoints) {
    constexpr std::size_t kMostNames = 8;
    std::string names;
    for (std::size_t i = 0; i < std::min(viewpoints.size(), kMostNames); ++i) {
        names += (i == 0 ? "" : ", ") + viewpoints[i].name;
    }
    if (viewpoints.size() > kMostNames) {
        names += fmt::format(" and {} more", viewpoints.size() - kMostNames);
    }
    return names;
}

}  // namespace scotty::scenes
