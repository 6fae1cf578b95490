#include "scenes/scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <optional>

#include "reference/base/error.h"
#include "scenes/built_in.h"
#include "scenes/camera_file.h"
#include "scenes/file_scene.h"
#include "scenes/loaders.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Error;
using reference::Scene;

namespace {

const std::array<const Generator*, 8>& generators() {
    static const std::array<const Generator*, 8> table = {
        &kCornell, &kSpheres, &kCoil, &kBlob, &kFurnace, &kVeil, &kSlivers, &kMetals};
    return table;
}

const Generator* find_generator(const std::string& name) {
    for (const Generator* generator : generators()) {
        if (name == generator->name) return generator;
    }
    return name == kProbe.name ? &kProbe : nullptr;
}

std::string lower_extension(const std::string& path) {
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

Error unknown_scene(const std::string& specification) {
    std::string names;
    for (const Generator* generator : generators()) {
        names += fmt::format("{}{}", names.empty() ? "" : ", ", generator->name);
    }
    return Error::bad_input(
        fmt::format("scene '{}'", specification),
        fmt::format("no such scene; built in are {}; or give the path of a .dae, .obj, .ply, "
                    ".gltf or .glb file",
                    names));
}

Scene load_file(const std::string& specification) {
    std::string path = specification;
    const FileChoices choices = take_choices(path);
    const std::string extension = lower_extension(path);
    const bool is_collada = extension == ".dae";
    const bool is_other =
        extension == ".obj" || extension == ".ply" || extension == ".gltf" || extension == ".glb";
    std::error_code ignored;
    const auto status = std::filesystem::status(path, ignored);
    if (!std::filesystem::exists(status)) {
        if (!is_collada && !is_other) throw unknown_scene(specification);
        throw Error::bad_input(path, "no such file");
    }
    if (!std::filesystem::is_regular_file(status)) {
        throw Error::bad_input(path, "expected a scene file, found a directory or device");
    }
    if (!is_collada && !is_other) {
        throw Error::bad_input(path, fmt::format("expected a .dae, .obj, .ply, .gltf or .glb "
                                                 "file, found the extension '{}'",
                                                 extension));
    }
    const auto load = is_collada            ? load_collada
                      : extension == ".obj" ? load_obj
                      : extension == ".ply" ? load_ply
                                            : load_gltf;
    Scene scene = load(path, choices.camera);
    if (choices.default_lights) {
        Notes notes;
        add_default_lights(scene, notes);
        notes.write_to(scene.warnings);
    }
    scene.name = std::filesystem::path(path).filename().string();
    return scene;
}

}  // namespace

const std::vector<BuiltIn>& built_in_scenes() {
    static const std::vector<BuiltIn> list = [] {
        std::vector<BuiltIn> all;
        for (const Generator* generator : generators()) {
            all.push_back(
                {generator->name, standard_text(generator->parameters), generator->description});
        }
        return all;
    }();
    return list;
}

Scene load_scene(const std::string& specification) {
    std::string rest = specification;
    const std::optional<std::string> camera = take_camera_file(rest);
    const std::size_t colon = std::min(rest.find(':'), rest.size());
    const std::string name = rest.substr(0, colon);
    Scene scene;
    if (const Generator* generator = find_generator(name)) {
        const bool has_text = colon + 1 < rest.size();
        const Parameters parameters(name, has_text ? rest.substr(colon + 1) : "",
                                    generator->parameters);
        scene = generator->generate(parameters);
        scene.name = name;
    } else {
        scene = load_file(rest);
    }
    if (camera) scene.camera = read_camera_file(*camera);
    finish_normals(scene);
    scene.source = specification;
    reference::validate_and_repair(scene);
    return scene;
}

}  // namespace scotty::scenes
