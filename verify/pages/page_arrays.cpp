#include "verify/pages/page_arrays.h"

#include <fmt/format.h>
#include <xxhash.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "verify/pages/base64.h"

namespace scotty::verify {
namespace {

/// Appends in little endian on every machine.
void append(std::string& bytes, std::uint32_t value, std::size_t width) {
    for (std::size_t i = 0; i < width; ++i) {
        bytes += static_cast<char>((value >> (8 * i)) & 0xffu);
    }
}

std::string compressed(const std::string& bytes) {
    uLongf size = compressBound(bytes.size());
    std::string out(size, '\0');
    const int status = compress2(
        reinterpret_cast<Bytef*>(out.data()), &size,
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): zlib's bytes
        reinterpret_cast<const Bytef*>(bytes.data()), bytes.size(), Z_DEFAULT_COMPRESSION);
    if (status != Z_OK) throw reference::Error::internal(fmt::format("zlib says {}", status));
    out.resize(size);
    return out;
}

}  // namespace

std::uint32_t PageArrays::add(std::span<const std::uint32_t> values) {
    std::uint32_t most = 0;
    for (const std::uint32_t value : values) most = std::max(most, value);
    const std::size_t width = most < 0x100u ? 1 : most < 0x10000u ? 2 : 4;
    std::string bytes;
    bytes.reserve(values.size() * width);
    for (const std::uint32_t value : values) append(bytes, value, width);
    return add(width == 1 ? "u8" : width == 2 ? "u16" : "u32", std::move(bytes), values.size());
}

std::uint32_t PageArrays::add(std::span<const float> values) {
    std::string bytes;
    bytes.reserve(values.size() * 4);
    for (const float value : values) append(bytes, std::bit_cast<std::uint32_t>(value), 4);
    return add("f32", std::move(bytes), values.size());
}

std::uint32_t PageArrays::add(const char* type, std::string bytes, std::size_t count) {
    const std::string key =
        fmt::format("{} {} {:016x}", type, count, XXH3_64bits(bytes.data(), bytes.size()));
    const auto [found, is_new] = known_.emplace(key, static_cast<std::uint32_t>(arrays_.size()));
    if (!is_new) return found->second;
    std::uint32_t checksum = 0;
    for (const char byte : bytes) checksum += static_cast<unsigned char>(byte);
    arrays_.push_back(
        {static_cast<std::uint32_t>(blobs_.size()), type, open_.size(), count, checksum});
    fresh_.push_back(key);
    open_ += bytes;
    open_.resize((open_.size() + 3) / 4 * 4, '\0');
    return found->second;
}

bool PageArrays::close(std::size_t room) {
    std::string text;
    if (!fresh_.empty()) text = base64(compressed(open_));
    const bool fits = text.size() <= room;
    if (!fits) {
        arrays_.resize(arrays_.size() - fresh_.size());
        for (const std::string& key : fresh_) known_.erase(key);
    } else if (!fresh_.empty()) {
        size_ += text.size();
        blobs_.push_back(std::move(text));
    }
    open_.clear();
    fresh_.clear();
    return fits;
}

nlohmann::json PageArrays::document() const {
    nlohmann::json arrays = nlohmann::json::array();
    for (const Array& array : arrays_) {
        arrays.push_back({array.blob, array.type, array.begin, array.count, array.checksum});
    }
    return {{"arrays", std::move(arrays)}, {"blobs", blobs_}};
}

}  // namespace scotty::verify
