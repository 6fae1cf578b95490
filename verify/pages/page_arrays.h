/// Arrays for a page: each stored once, compressed, as text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace scotty::verify {

/// Arrays are added to a *blob* until it is closed; equal arrays are stored once, in the blob that
/// got them first. A page with a size limit closes blobs as long as they fit.
class PageArrays {
 public:
    /// Returns the array's number. Integers are stored in as few bytes as the largest needs.
    std::uint32_t add(std::span<const std::uint32_t> values);
    std::uint32_t add(std::span<const float> values);

    /// Compresses the arrays added since the last call. Returns false if the text would exceed
    /// `room`: those arrays are then forgotten, and their numbers given out again.
    bool close(std::size_t room);

    /// The characters of all blobs.
    std::size_t size() const { return size_; }

    /// {"arrays": [[blob, type, first byte, count, checksum]], "blobs": [..]}: a blob is base64 of
    /// a zlib stream, a type one of u8, u16, u32, f32; little endian, each array at a multiple
    /// of 4. A checksum is the sum of an array's bytes.
    nlohmann::json document() const;

 private:
    struct Array {
        std::uint32_t blob = 0;
        const char* type = "";
        std::size_t begin = 0, count = 0;
        std::uint32_t checksum = 0;
    };
    std::uint32_t add(const char* type, std::string bytes, std::size_t count);

    std::vector<Array> arrays_;
    std::vector<std::string> blobs_;
    std::string open_;
    std::unordered_map<std::string, std::uint32_t> known_;  ///< by type and hash of the bytes
    std::vector<std::string> fresh_;                        ///< keys of the open blob's
    std::size_t size_ = 0;
};

}  // namespace scotty::verify
