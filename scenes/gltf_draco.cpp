#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <fmt/format.h>

#include <array>
#include <cstring>

#include "scenes/gltf_primitive.h"

namespace scotty::scenes {

using reference::Error;

namespace {

/// The most triangles or vertices that are believed for a compressed byte: real meshes have less
/// than a hundred, and the library allocates what a stream announces before it looks further.
constexpr std::uint64_t kDensest = 4096;

/// The sizes at the beginning of a stream; nothing where it is no mesh of version 2.2, which is the
/// one that glTF allows.
std::optional<std::array<std::uint32_t, 2>> announced(const std::string& bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(bytes.data(), bytes.size());
    draco::DracoHeader header{};
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return std::nullopt;
    const bool is_mesh = header.encoder_type == draco::TRIANGULAR_MESH;
    if (!is_mesh || header.version_major != 2 || header.version_minor != 2) return std::nullopt;
    if ((header.flags & METADATA_FLAG_MASK) != 0) {
        draco::GeometryMetadata ignored;
        if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &ignored)) {
            return std::nullopt;
        }
    }
    std::uint8_t traversal = 0;
    if (header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING && !buffer.Decode(&traversal)) {
        return std::nullopt;
    }
    std::array<std::uint32_t, 2> sizes{};
    for (std::uint32_t& size : sizes) {
        if (!draco::DecodeVarint(&size, &buffer)) return std::nullopt;
    }
    return sizes;
}

std::string bytes_of_indices(const draco::Mesh& mesh) {
    std::string out(std::size_t{mesh.num_faces()} * 12, '\0');
    for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
        const auto& face = mesh.face(draco::FaceIndex(f));
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t corner = face[static_cast<int>(k)].value();
            std::memcpy(&out[(std::size_t{f} * 3 + k) * 4], &corner, sizeof corner);
        }
    }
    return out;
}

std::string bytes_of_attribute(const GltfObject& extension, const draco::Mesh& mesh,
                               const char* name, std::uint64_t id) {
    const draco::PointAttribute* attribute =
        mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
    if (attribute == nullptr || attribute->num_components() != 3) {
        throw extension.error(
            fmt::format("{}: no attribute {} of 3 components in the compressed "
                        "data",
                        name, id));
    }
    std::string out(std::size_t{mesh.num_points()} * 12, '\0');
    for (std::uint32_t p = 0; p < mesh.num_points(); ++p) {
        const draco::AttributeValueIndex index = attribute->mapped_index(draco::PointIndex(p));
        std::array<float, 3> value{};
        if (index.value() >= attribute->size() ||
            !attribute->ConvertValue<float>(index, 3, value.data())) {
            throw extension.error(fmt::format("{}: no value for vertex {}", name, p));
        }
        std::memcpy(&out[std::size_t{p} * 12], value.data(), sizeof value);
    }
    return out;
}

std::unique_ptr<draco::Mesh> decode(const GltfObject& extension, const std::string& bytes) {
    const auto sizes = announced(bytes);
    const std::uint64_t most = (bytes.size() + 16) * kDensest;
    if (sizes && ((*sizes)[0] > most || (*sizes)[1] > most)) {
        throw extension.error(
            fmt::format("{} compressed bytes cannot hold {} and {} triangles "
                        "and vertices",
                        bytes.size(), (*sizes)[0], (*sizes)[1]));
    }
    if (!sizes) throw extension.error("the compressed data is no Draco mesh of version 2.2");
    draco::DecoderBuffer buffer;
    buffer.Init(bytes.data(), bytes.size());
    auto result = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!result.ok()) {
        throw extension.error(
            fmt::format("the compressed data is damaged: {}", result.status().error_msg_string()));
    }
    return std::move(result).value();
}

}  // namespace

GltfDracoMesh decode_draco(GltfDocument& document, const GltfObject& extension) {
    const GltfView view = document.view(extension.required_whole("bufferView"), extension);
    const auto attributes = extension.object("attributes");
    const auto position = attributes ? attributes->whole("POSITION") : std::nullopt;
    if (!position) throw extension.error("attributes: POSITION is missing");
    const auto mesh = decode(extension, view.bytes.all());
    if (mesh->num_faces() == 0 || mesh->num_points() == 0) {
        throw extension.error("the compressed mesh is empty");
    }
    const std::string& place = extension.place();
    GltfDracoMesh out{{place, bytes_of_indices(*mesh), 0},
                      {place, bytes_of_attribute(extension, *mesh, "POSITION", *position), 3},
                      std::nullopt};
    if (const auto normal = attributes->whole("NORMAL")) {
        out.normal.emplace(place, bytes_of_attribute(extension, *mesh, "NORMAL", *normal), 3u);
    }
    return out;
}

}  // namespace scotty::scenes
