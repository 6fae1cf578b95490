/// glTF files for the tests: a JSON document whose binary data grows as accessors are added.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/scenes/temporary_files.h"

namespace scotty::tests {

using nlohmann::json;

/// Codes of accessor.componentType.
template <class T>
constexpr int kComponentType = 0;
template <>
inline constexpr int kComponentType<std::int8_t> = 5120;
template <>
inline constexpr int kComponentType<std::uint8_t> = 5121;
template <>
inline constexpr int kComponentType<std::int16_t> = 5122;
template <>
inline constexpr int kComponentType<std::uint16_t> = 5123;
template <>
inline constexpr int kComponentType<std::uint32_t> = 5125;
template <>
inline constexpr int kComponentType<float> = 5126;

inline std::string base64(const std::string& bytes) {
    constexpr const char* kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            bits = bits << 8u | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0u);
        }
        for (std::size_t k = 0; k < 4; ++k) {
            const bool is_padding = i + k > bytes.size();
            out += is_padding ? '=' : kDigits[bits >> (18 - 6 * k) & 63u];
        }
    }
    return out;
}

/// The bytes of plain values.
template <class T>
std::string bytes_of(const std::vector<T>& values) {
    std::string out(values.size() * sizeof(T), '\0');
    std::memcpy(out.data(), values.data(), out.size());
    return out;
}

struct GltfText {
    json root = {{"asset", {{"version", "2.0"}}},
                 {"scene", 0},
                 {"scenes", {{{"nodes", json::array()}}}},
                 {"nodes", json::array()}};
    std::string bytes;  ///< of buffer 0

    /// A view of `data`, which is appended to the buffer.
    std::size_t view(const std::string& data, std::size_t stride = 0) {
        bytes.resize((bytes.size() + 3) / 4 * 4);
        json entry = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", data.size()}};
        if (stride != 0) entry["byteStride"] = stride;
        bytes += data;
        return append("bufferViews", entry);
    }
    /// An accessor of tightly packed values: type "SCALAR", "VEC3" and so on.
    template <class T>
    std::size_t accessor(const char* type, const std::vector<T>& values) {
        const std::string name = type;
        const std::size_t components = name == "SCALAR" ? 1 : std::size_t(name.back() - '0');
        return append("accessors", {{"bufferView", view(bytes_of(values))},
                                    {"componentType", kComponentType<T>},
                                    {"count", values.size() / components},
                                    {"type", type}});
    }
    std::size_t append(const char* list, const json& entry) {
        root[list].push_back(entry);
        return root[list].size() - 1;
    }
    std::size_t mesh(const json& primitive) {
        return append("meshes", {{"primitives", json::array({primitive})}});
    }
    /// A node that the scene shows.
    std::size_t node(const json& entry) {
        const std::size_t index = append("nodes", entry);
        root["scenes"][0]["nodes"].push_back(index);
        return index;
    }
    std::size_t light(const json& entry) {
        root["extensionsUsed"] = {"KHR_lights_punctual"};
        json& lights = root["extensions"]["KHR_lights_punctual"]["lights"];
        lights.push_back(entry);
        return lights.size() - 1;
    }
    json light_node(std::size_t index) const {
        return {{"extensions", {{"KHR_lights_punctual", {{"light", index}}}}}};
    }

    /// The document as .gltf, with its buffer as a data: uri.
    std::string gltf() const {
        json out = root;
        out["buffers"] = {{{"byteLength", bytes.size()},
                           {"uri", "data:application/octet-stream;base64," + base64(bytes)}}};
        return out.dump();
    }
    /// The document as .glb.
    std::string glb() const {
        json out = root;
        out["buffers"] = {{{"byteLength", bytes.size()}}};
        std::string text = out.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        std::string data = bytes;
        data.resize((data.size() + 3) / 4 * 4);
        const auto word = [](std::size_t value) {
            return bytes_of(std::vector{static_cast<std::uint32_t>(value)});
        };
        const std::string chunks =
            word(text.size()) + "JSON" + text + word(data.size()) + std::string("BIN\0", 4) + data;
        return "glTF" + word(2) + word(chunks.size() + 12) + chunks;
    }
};

/// The corners of the square from -1 to 1 at z = 0, which faces +z.
inline const std::vector<float> kGltfSquare = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
inline const std::vector<std::uint16_t> kGltfSquareCorners = {0, 1, 2, 0, 2, 3};

/// A file that shows the square, at a node with the members `node`.
inline GltfText square_gltf(json node = json::object()) {
    GltfText out;
    const std::size_t positions = out.accessor("VEC3", kGltfSquare);
    const std::size_t corners = out.accessor("SCALAR", kGltfSquareCorners);
    node["mesh"] = out.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", corners}});
    out.node(node);
    return out;
}

inline reference::Scene load_gltf(const GltfText& text) {
    return TemporaryFiles().load("a.gltf", text.gltf());
}

}  // namespace scotty::tests
