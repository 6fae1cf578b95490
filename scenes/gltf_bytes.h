/// Where the bytes of a glTF file lie, and how they are read without holding all of them.
#pragma once

#include <cstdint>
#include <fstream>
#include <memory>
#include <string>

namespace scotty::scenes {

/// A range of bytes, in a file (read piece by piece when asked for) or in memory. Copies share
/// the file or the memory.
class GltfBytes {
 public:
    GltfBytes() = default;
    /// Throws reference::Error (bad_input) where the path is no file that can be read.
    static GltfBytes of_file(const std::string& path);
    static GltfBytes of_memory(std::string bytes);

    std::uint64_t size() const { return size_; }
    /// The `length` bytes from `offset` on, which have to lie inside.
    GltfBytes part(std::uint64_t offset, std::uint64_t length) const;
    /// Copies bytes that have to lie inside. Throws reference::Error where the file became shorter.
    void read(std::uint64_t offset, std::uint64_t length, char* to) const;
    std::string all() const;

 private:
    struct File {
        std::string path;
        std::ifstream stream;
    };
    std::shared_ptr<File> file_;
    std::shared_ptr<const std::string> memory_;
    std::uint64_t begin_ = 0;
    std::uint64_t size_ = 0;
};

/// The two parts of a .glb file, or the JSON of a .gltf file and no binary.
struct GltfContainer {
    std::string json;
    bool has_binary = false;
    GltfBytes binary;
};

/// Tells the two kinds of file apart by their first bytes. Throws reference::Error (bad_input)
/// where a chunk of a .glb does not fit the file, or where its version is not 2.
GltfContainer open_gltf(const std::string& path);

/// What a buffer's uri stands for: a data: uri, or a file beside `folder`'s others, %20 and the
/// like decoded. `place` names the buffer in errors.
GltfBytes open_gltf_uri(const std::string& uri, const std::string& folder,
                        const std::string& place);

}  // namespace scotty::scenes
