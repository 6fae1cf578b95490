#include "scenes/gltf_bytes.h"

#include <fmt/format.h>

#include <array>
#include <cstring>
#include <filesystem>

#include "reference/base/error.h"

namespace scotty::scenes {

using reference::Error;

GltfBytes GltfBytes::of_file(const std::string& path) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) {
        throw Error::bad_input(path, "no such file");
    }
    GltfBytes out;
    out.file_ = std::make_shared<File>();
    out.file_->path = path;
    // Whole pieces are read: a buffer of the stream would only copy them once more.
    out.file_->stream.rdbuf()->pubsetbuf(nullptr, 0);
    out.file_->stream.open(path, std::ios::binary);
    out.size_ = std::filesystem::file_size(path, ignored);
    if (!out.file_->stream || ignored) throw Error::bad_input(path, "the file cannot be read");
    return out;
}

GltfBytes GltfBytes::of_memory(std::string bytes) {
    GltfBytes out;
    out.size_ = bytes.size();
    out.memory_ = std::make_shared<const std::string>(std::move(bytes));
    return out;
}

GltfBytes GltfBytes::part(std::uint64_t offset, std::uint64_t length) const {
    if (offset > size_ || length > size_ - offset) {
        throw Error::internal("GltfBytes::part: beyond the end");
    }
    GltfBytes out = *this;
    out.begin_ += offset;
    out.size_ = length;
    return out;
}

void GltfBytes::read(std::uint64_t offset, std::uint64_t length, char* to) const {
    if (offset > size_ || length > size_ - offset) {
        throw Error::internal("GltfBytes::read: beyond the end");
    }
    if (length == 0) return;
    if (memory_) {
        std::memcpy(to, memory_->data() + begin_ + offset, length);
        return;
    }
    std::ifstream& stream = file_->stream;
    stream.clear();
    stream.seekg(static_cast<std::streamoff>(begin_ + offset));
    stream.read(to, static_cast<std::streamsize>(length));
    if (!stream) throw Error::bad_input(file_->path, "the file became shorter while it was read");
}

std::string GltfBytes::all() const {
    std::string out(size_, '\0');
    read(0, size_, out.data());
    return out;
}

namespace {

constexpr std::uint32_t kJsonChunk = 0x4e4f534a;    // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004e4942;  // "BIN\0"

template <std::size_t N>
std::array<std::uint32_t, N> words_at(const GltfBytes& bytes, std::uint64_t offset) {
    std::array<std::uint32_t, N> out{};
    bytes.read(offset, sizeof out, reinterpret_cast<char*>(out.data()));
    return out;
}

bool begins_binary(const GltfBytes& file, std::uint64_t at, std::uint64_t length) {
    return at + 8 <= length && words_at<2>(file, at)[1] == kBinaryChunk;
}

GltfContainer open_glb(const std::string& path, const GltfBytes& file) {
    if (file.size() < 12) throw Error::bad_input(path, "a .glb without a chunk (truncated?)");
    const auto [magic, version, length] = words_at<3>(file, 0);
    if (version != 2) {
        throw Error::bad_input(path, fmt::format("glTF {}.0 is not supported: export the scene as "
                                                 "glTF 2.0",
                                                 version));
    }
    if (length > file.size()) {
        throw Error::bad_input(
            path, fmt::format("expected {} bytes, found {} (truncated?)", length, file.size()));
    }
    GltfContainer out;
    for (std::uint64_t at = 12, chunk = 0; at + 8 <= length; ++chunk) {
        const auto [size, kind] = words_at<2>(file, at);
        at += 8;
        if (size > length - at) {
            throw Error::bad_input(path, fmt::format("chunk {} is longer than the file: {} bytes, "
                                                     "{} are left (truncated?)",
                                                     chunk, size, length - at));
        }
        if ((chunk == 0) != (kind == kJsonChunk)) {
            throw Error::bad_input(path, "expected one JSON chunk, the first of the .glb");
        }
        if (chunk == 0) out.json = file.part(at, size).all();
        if (kind == kBinaryChunk && !out.has_binary) {
            out.binary = file.part(at, size);
            out.has_binary = true;
        }
        at += size;
        // Some exporters pad a chunk and do not count the padding.
        const std::uint64_t aligned = (at + 3) / 4 * 4;
        if (!begins_binary(file, at, length) && begins_binary(file, aligned, length)) at = aligned;
    }
    if (out.json.empty()) throw Error::bad_input(path, "a .glb without a chunk (truncated?)");
    return out;
}

}  // namespace

GltfContainer open_gltf(const std::string& path) {
    const GltfBytes file = GltfBytes::of_file(path);
    std::array<char, 4> magic{};
    if (file.size() >= magic.size()) file.read(0, magic.size(), magic.data());
    GltfContainer out;
    if (std::memcmp(magic.data(), "glTF", magic.size()) == 0) {
        out = open_glb(path, file);
    } else {
        out.json = file.all();
    }
    // Some exporters fill a chunk up with zeros instead of blanks.
    while (!out.json.empty() && out.json.back() == '\0') out.json.pop_back();
    return out;
}

}  // namespace scotty::scenes
