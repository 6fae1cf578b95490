#include "scenes/gltf_document.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

namespace scotty::scenes {

using nlohmann::json;
using reference::Error;

namespace {

json parse(const std::string& path, const std::string& text) {
    try {
        json root = json::parse(text);
        if (root.is_object()) return root;
    } catch (const json::exception& wrong) {
        std::string why = wrong.what();
        why = why.substr(std::min(why.size(), why.find("] ") + 2));  // without the library's code
        why = why.substr(0, std::min(why.find("; last read"), std::size_t{200}));
        throw Error::bad_input(
            path, fmt::format("not well-formed glTF (JSON), or the file is truncated: {}", why));
    }
    throw Error::bad_input(path, "not well-formed glTF (JSON): expected an object");
}

/// In glTF 1.0 the lists were objects, and the version could be left out.
bool looks_like_version_1(const json& root) {
    constexpr std::array<const char*, 3> kLists = {"nodes", "meshes", "scenes"};
    return std::any_of(kLists.begin(), kLists.end(), [&](const char* key) {
        return root.contains(key) && root[key].is_object();
    });
}

void check_version(const GltfObject& root, const json& plain) {
    const auto asset = root.object("asset");
    const bool is_1 = looks_like_version_1(plain);
    if (!is_1 && (!asset || !asset->has("version"))) {
        throw root.error("not glTF as specified: asset.version is missing");
    }
    const std::string version = is_1 ? "1.0" : asset->text("version", "");
    // A later 2.x may be read as 2.0, unless the file says otherwise.
    const std::string lowest = is_1 ? version : asset->text("minVersion", "2.0");
    if (version.rfind("2.", 0) == 0 && lowest == "2.0") return;
    throw root.error(fmt::format("glTF {} is not supported: export the scene as glTF 2.0",
                                 lowest == "2.0" ? version : lowest));
}

}  // namespace

GltfDocument::GltfDocument(const std::string& path, Notes& notes)
    : path_(path), folder_(std::filesystem::path(path).parent_path().string()) {
    GltfContainer container = open_gltf(path);
    has_binary_ = container.has_binary;
    binary_ = std::move(container.binary);
    json_ = parse(path, container.json);
    check_version(root(), json_);
    check_gltf_extensions(root(), json_, notes);
}

bool GltfDocument::uses(const std::string& extension) const {
    const auto used = root().texts("extensionsUsed");
    const auto required = root().texts("extensionsRequired");
    return std::find(used.begin(), used.end(), extension) != used.end() ||
           std::find(required.begin(), required.end(), extension) != required.end();
}

GltfBytes GltfDocument::open_buffer(std::uint64_t index, const GltfObject& object) const {
    const std::uint64_t length = object.required_whole("byteLength");
    GltfBytes bytes;
    if (object.has("uri")) {
        bytes = open_gltf_uri(object.text("uri", ""), folder_, object.place());
    } else if (index == 0 && has_binary_) {
        bytes = binary_;
    } else {
        throw object.error(
            "expected a uri, or to be the first buffer of a .glb with a binary chunk");
    }
    if (bytes.size() < length) {
        throw object.error(
            fmt::format("expected {} bytes, found {} (truncated?)", length, bytes.size()));
    }
    return bytes.part(0, length);
}

GltfBytes GltfDocument::buffer(std::uint64_t index, const GltfObject& user) {
    const auto known = buffers_.find(index);
    if (known != buffers_.end()) return known->second;
    const GltfObject object = root().at("buffers", index, user);
    return buffers_.emplace(index, open_buffer(index, object)).first->second;
}

GltfBytes GltfDocument::buffer_part(std::uint64_t index, std::uint64_t offset, std::uint64_t length,
                                    const GltfObject& user) {
    const GltfBytes whole = buffer(index, user);
    if (offset + length > whole.size()) {
        throw user.error(
            fmt::format("ends at byte {}, its buffer has {}", offset + length, whole.size()));
    }
    return whole.part(offset, length);
}

GltfView GltfDocument::view(std::uint64_t index, const GltfObject& user) {
    const auto known = views_.find(index);
    if (known != views_.end()) return known->second;
    const GltfObject object = root().at("bufferViews", index, user);
    const auto compression = object.extension("EXT_meshopt_compression");
    GltfView view;
    if (compression) {
        view = decode_meshopt(
            *compression,
            buffer_part(compression->required_whole("buffer"), compression->whole("byteOffset", 0),
                        compression->required_whole("byteLength"), *compression));
    } else {
        view.bytes = buffer_part(object.required_whole("buffer"), object.whole("byteOffset", 0),
                                 object.required_whole("byteLength"), object);
        view.stride = object.whole("byteStride", 0);
    }
    constexpr std::uint64_t kLongestStride = 65535;  // the format allows 252
    if (view.stride > kLongestStride) {
        throw object.error(fmt::format("byteStride: expected at most 252, found {}", view.stride));
    }
    return views_.emplace(index, std::move(view)).first->second;
}

}  // namespace scotty::scenes
