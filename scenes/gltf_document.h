/// A glTF 2.0 file: its JSON, and the bytes that its buffers and buffer views stand for.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "scenes/gltf_bytes.h"
#include "scenes/gltf_object.h"
#include "scenes/notes.h"

namespace scotty::scenes {

struct GltfView {
    GltfBytes bytes;
    std::uint64_t stride = 0;  ///< in bytes; 0: elements lie one behind the other
};

class GltfDocument {
 public:
    /// Reads the JSON. Throws reference::Error (bad_input) where it is not well-formed, is of
    /// another version of glTF, or requires an extension that is not supported (all are named).
    /// Notes extensions that the file uses and that are not supported.
    GltfDocument(const std::string& path, Notes& notes);
    GltfDocument(const GltfDocument&) = delete;
    GltfDocument& operator=(const GltfDocument&) = delete;

    const std::string& path() const { return path_; }
    GltfObject root() const { return {json_, path_}; }
    bool uses(const std::string& extension) const;

    /// The bytes of bufferViews[index], decompressed where it is compressed. Buffers are opened,
    /// and views checked, when somebody asks for them: what nobody uses may be missing.
    GltfView view(std::uint64_t index, const GltfObject& user);
    /// The bytes from `offset` on of buffers[index].
    GltfBytes buffer_part(std::uint64_t index, std::uint64_t offset, std::uint64_t length,
                          const GltfObject& user);

 private:
    GltfBytes buffer(std::uint64_t index, const GltfObject& user);
    GltfBytes open_buffer(std::uint64_t index, const GltfObject& object) const;

    std::string path_;
    std::string folder_;
    bool has_binary_ = false;
    GltfBytes binary_;
    nlohmann::json json_;
    std::map<std::uint64_t, GltfBytes> buffers_;
    std::map<std::uint64_t, GltfView> views_;
};

/// Decompresses a view that has the extension EXT_meshopt_compression (gltf_meshopt.cpp).
/// `compressed` is what the extension's object refers to. Throws reference::Error (bad_input).
GltfView decode_meshopt(const GltfObject& extension, const GltfBytes& compressed);

/// Obeys extensionsRequired, and notes the extensions that the file lists or that objects have and
/// that are not supported (gltf_extensions.cpp). `document` is the whole JSON.
void check_gltf_extensions(const GltfObject& root, const nlohmann::json& document, Notes& notes);

}  // namespace scotty::scenes
