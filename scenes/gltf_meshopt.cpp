#include <fmt/format.h>
#include <meshoptimizer.h>

#include "scenes/gltf_document.h"

namespace scotty::scenes {

namespace {

/// The most that a byte of compressed data can stand for: 64 vertices' bytes that are all equal.
constexpr std::uint64_t kMostPerByte = 128;

/// Undoes a filter in place. The library checks none of what it is given.
void undo_filter(const GltfObject& extension, std::string& bytes, std::uint64_t count,
                 std::uint64_t stride) {
    const std::string filter = extension.text("filter", "NONE");
    if (filter == "NONE") return;
    if (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) {
        meshopt_decodeFilterOct(bytes.data(), count, stride);
    } else if (filter == "QUATERNION" && stride == 8) {
        meshopt_decodeFilterQuat(bytes.data(), count, stride);
    } else if (filter == "EXPONENTIAL" && stride % 4 == 0) {
        meshopt_decodeFilterExp(bytes.data(), count, stride);
    } else {
        throw extension.error(
            fmt::format("the filter '{}' does not go with a byteStride of {}", filter, stride));
    }
}

}  // namespace

GltfView decode_meshopt(const GltfObject& extension, const GltfBytes& compressed) {
    const std::uint64_t count = extension.required_whole("count");
    const std::uint64_t stride = extension.required_whole("byteStride");
    const std::string mode = extension.text("mode", "");
    const bool is_attributes = mode == "ATTRIBUTES";
    const bool is_triangles = mode == "TRIANGLES";
    if (!is_attributes && !is_triangles && mode != "INDICES") {
        throw extension.error(
            fmt::format("mode: expected ATTRIBUTES, TRIANGLES or INDICES, found '{}'", mode));
    }
    const bool fits =
        is_attributes ? stride > 0 && stride <= 256 && stride % 4 == 0 : stride == 2 || stride == 4;
    if (!fits || (is_triangles && count % 3 != 0)) {
        throw extension.error(
            fmt::format("{} elements of {} bytes do not go with the mode {}", count, stride, mode));
    }
    if (count * stride > (compressed.size() + 64) * kMostPerByte) {
        throw extension.error(fmt::format("{} elements of {} bytes do not fit {} compressed bytes",
                                          count, stride, compressed.size()));
    }
    const std::string packed = compressed.all();
    const auto* from = reinterpret_cast<const unsigned char*>(packed.data());
    std::string bytes(count * stride, '\0');
    const int status =
        is_attributes ? meshopt_decodeVertexBuffer(bytes.data(), count, stride, from, packed.size())
        : is_triangles
            ? meshopt_decodeIndexBuffer(bytes.data(), count, stride, from, packed.size())
            : meshopt_decodeIndexSequence(bytes.data(), count, stride, from, packed.size());
    if (status != 0) {
        throw extension.error("the compressed data is damaged");
    }
    if (is_attributes) undo_filter(extension, bytes, count, stride);
    return {GltfBytes::of_memory(std::move(bytes)), stride};
}

}  // namespace scotty::scenes
