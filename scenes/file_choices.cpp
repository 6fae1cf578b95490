#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "reference/base/error.h"
#include "scenes/loaders.h"

namespace scotty::scenes {

namespace {

/// Sets what "camera=fit" or another choice says. Returns false where it is none.
bool apply(const std::string& choice, FileChoices& choices) {
    constexpr std::string_view kCamera = "camera=";
    if (choice == "camera=file") {
        choices.camera = CameraChoice::file;
    } else if (choice == "camera=fit") {
        choices.camera = CameraChoice::fit;
    } else if (choice == "lights=none") {
        choices.default_lights = false;
    } else if (choice.size() > kCamera.size() && choice.starts_with(kCamera)) {
        choices.viewpoint = choice.substr(kCamera.size());
    } else {
        return false;
    }
    return true;
}

}  // namespace

FileChoices take_choices(std::string& path) {
    FileChoices choices;
    const std::string whole = path;
    std::size_t mark = path.rfind('#');
    while (mark != std::string::npos && !std::filesystem::exists(path)) {
        for (std::size_t begin = mark + 1; begin <= path.size();) {
            const std::size_t end = std::min(path.find(',', begin), path.size());
            const std::string choice = path.substr(begin, end - begin);
            if (!apply(choice, choices)) {
                throw reference::Error::bad_input(
                    whole,
                    fmt::format(
                        "'#{}' is not understood; expected #camera=file (the file's "
                        "own), #camera=fit (frame everything), #camera=NAME (one of the file's), "
                        "#camera=FILE.camera (what scotty view has saved) or #lights=none (add "
                        "no light where the file has none), or two of them with a "
                        "comma between",
                        choice));
            }
            begin = end + 1;
        }
        path.resize(mark);
        mark = path.rfind('#');
    }
    return choices;
}

}  // namespace scotty::scenes
