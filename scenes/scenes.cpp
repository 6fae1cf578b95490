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
#include "scenes/viewpoints.h"

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

/// Where a file is looked at from one of its cameras, all else stays as it is from its first.
void take_viewpoint(Scene& scene, const std::string& path, const std::string& name,
                    const std::vector<Viewpoint>& viewpoints) {
    const auto found =
        std::find_if(viewpoints.begin(), viewpoints.end(),
                     [&](const Viewpoint& viewpoint) { return viewpoint.name == name; });
    if (found != viewpoints.end()) {
        scene.camera = found->camera;
        return;
    }
    const std::string others =
        viewpoints.empty() ? "it has none" : fmt::format("it has {}", names_of(viewpoints));
    throw Error::bad_input(
        path, fmt::format("no camera '{}' in the file, {}; #camera=fit frames everything, "
                          "#camera=FILE.camera is one that scotty view has saved",
                          name, others));
}

Scene load_file(const std::string& specification, std::vector<Viewpoint>& viewpoints) {
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
    Scene scene = is_collada            ? load_collada(path, choices.camera, viewpoints)
                  : extension == ".obj" ? load_obj(path, choices.camera)
                  : extension == ".ply" ? load_ply(path, choices.camera)
                                        : load_gltf(path, choices.camera, viewpoints);
    if (choices.default_lights) {
        Notes notes;
        add_default_lights(scene, notes);
        notes.write_to(scene.warnings);
    }
    if (!choices.viewpoint.empty()) take_viewpoint(scene, path, choices.viewpoint, viewpoints);
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
    std::vector<Viewpoint> viewpoints;
    return load_scene(specification, viewpoints);
}

Scene load_scene(const std::string& specification, std::vector<Viewpoint>& viewpoints) {
    viewpoints.clear();
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
        scene = load_file(rest, viewpoints);
    }
    if (camera) scene.camera = read_camera_file(*camera);
    finish_normals(scene);
    scene.source = specification;
    reference::validate_and_repair(scene);
    return scene;
}

}  // namespace scotty::scenes
