#include "verify/capture/npy.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <charconv>
#include <fstream>
#include <optional>
#include <string_view>

#include "reference/base/assert.h"
#include "reference/base/error.h"
#include "verify/capture/include/scotty/capture_layout.h"
#include "verify/capture/layout.h"

namespace scotty::verify {

using reference::ElementType;
using reference::Error;

static_assert(std::endian::native == std::endian::little, "files hold memory as it is");

namespace {

constexpr std::string_view kMagic("\x93NUMPY\x01\x00", 8);

struct TypeName {
    ElementType type;
    const char* descr;
    const char* name;
    std::size_t size;
};
constexpr std::array kTypes{TypeName{ElementType::uint8, "|u1", "uint8", 1},
                            TypeName{ElementType::uint32, "<u4", "uint32", 4},
                            TypeName{ElementType::uint64, "<u8", "uint64", 8},
                            TypeName{ElementType::float32, "<f4", "float32", 4}};

const TypeName& entry_of(ElementType type) {
    for (const TypeName& entry : kTypes) {
        if (entry.type == type) return entry;
    }
    throw Error::internal("an element type without a name");
}

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& what) {
    throw Error::bad_input(file.string(), what);
}

/// What stands behind 'key': in the header's dictionary.
std::string_view value_of(const std::filesystem::path& file, std::string_view header,
                          std::string_view key) {
    const std::size_t at = header.find(key);
    if (at == std::string_view::npos) {
        fail(file, fmt::format("expected {} in the .npy header, found '{}'", key, header));
    }
    std::string_view rest = header.substr(at + key.size());
    const std::size_t first = rest.find_first_not_of(": ");
    return first == std::string_view::npos ? std::string_view{} : rest.substr(first);
}

/// "(3, 4)" into sizes; nothing where it is no such tuple.
std::optional<std::vector<std::size_t>> parse_shape(std::string_view text) {
    if (text.empty() || text.front() != '(') return std::nullopt;
    std::vector<std::size_t> shape;
    const char* at = text.data() + 1;
    const char* end = text.data() + text.size();
    while (at < end && *at != ')') {
        if (*at == ' ' || *at == ',') {
            ++at;
            continue;
        }
        std::size_t size = 0;
        const auto [next, error] = std::from_chars(at, end, size);
        if (error != std::errc()) return std::nullopt;
        shape.push_back(size);
        at = next;
    }
    if (at >= end) return std::nullopt;
    return shape;
}

ElementType parse_type(const std::filesystem::path& file, std::string_view header) {
    const std::string_view value = value_of(file, header, "'descr'");
    for (const TypeName& entry : kTypes) {
        if (value.starts_with(fmt::format("'{}'", entry.descr))) return entry.type;
    }
    fail(file, fmt::format("expected elements of type |u1, <u4, <u8 or <f4, found {}",
                           value.substr(0, value.find(','))));
}

/// Bytes that type and shape need; nothing where that is more than any file has.
std::optional<std::size_t> bytes_needed(ElementType type, std::span<const std::size_t> shape) {
    std::size_t bytes = size_of(type);
    for (const std::size_t size : shape) {
        if (__builtin_mul_overflow(bytes, size, &bytes)) return std::nullopt;
    }
    return bytes;
}

}  // namespace

std::size_t size_of(ElementType type) { return entry_of(type).size; }
const char* to_string(ElementType type) { return entry_of(type).name; }

std::size_t element_count(std::span<const std::size_t> shape) {
    std::size_t count = 1;
    for (const std::size_t size : shape) count *= size;
    return count;
}

std::string shape_text(std::span<const std::size_t> shape) {
    return fmt::format("[{}]", fmt::join(shape, ", "));
}

std::string npy_header(ElementType type, std::span<const std::size_t> shape) {
    return capture::npy_header(layout_type(type), {shape.begin(), shape.end()});
}

void write_npy(const std::filesystem::path& file, ElementType type,
               std::span<const std::size_t> shape, const void* data, std::size_t bytes) {
    SCOTTY_ASSERT(bytes, ==, element_count(shape) * size_of(type));
    as_bad_input([&] { capture::write_file(file, npy_header(type, shape), data, bytes); });
}

NpyArray read_npy(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary | std::ios::ate);
    if (!in) fail(file, "cannot be read");
    const auto file_bytes = static_cast<std::size_t>(in.tellg());
    in.seekg(0);
    std::array<char, 10> start{};
    in.read(start.data(), start.size());
    if (!in || std::string_view(start.data(), kMagic.size()) != kMagic) {
        fail(file, "expected a .npy file of version 1.0, found other bytes at its start");
    }
    const std::size_t header_bytes = static_cast<unsigned char>(start[8]) +
                                     256u * std::size_t{static_cast<unsigned char>(start[9])};
    std::string header(header_bytes, ' ');
    in.read(header.data(), static_cast<std::streamsize>(header.size()));
    if (!in) fail(file, "ends within its .npy header; it has been cut short");

    NpyArray array;
    array.type = parse_type(file, header);
    if (!value_of(file, header, "'fortran_order'").starts_with("False")) {
        fail(file, "expected C order, found an array in Fortran order");
    }
    const std::string_view shape_value = value_of(file, header, "'shape'");
    auto shape = parse_shape(shape_value);
    if (!shape) fail(file, fmt::format("expected a shape like (3, 4), found '{}'", shape_value));
    array.shape = std::move(*shape);

    const std::size_t found = file_bytes - start.size() - header_bytes;
    const std::optional<std::size_t> needed = bytes_needed(array.type, array.shape);
    if (!needed || *needed != found) {
        fail(file, fmt::format("expected {} bytes of data for {} {}, found {}; it has been cut "
                               "short or changed",
                               needed ? std::to_string(*needed) : "2^64 or more",
                               to_string(array.type), shape_text(array.shape), found));
    }
    array.bytes.resize(found);
    in.read(reinterpret_cast<char*>(array.bytes.data()), static_cast<std::streamsize>(found));
    if (!in && found != 0) fail(file, "cannot be read to its end");
    return array;
}

std::string hash_text(const void* data, std::size_t bytes) {
    return capture::hash_text(data, bytes);
}
std::string hex_text(std::uint64_t value) { return capture::hex(value); }

}  // namespace scotty::verify
