/// NumPy's .npy, version 1.0: little endian, C order. What numpy.load() reads with no help from us.
///
/// Format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "reference/contract/stage_observer.h"

namespace scotty::verify {

struct NpyArray {
    reference::ElementType type = reference::ElementType::uint32;
    std::vector<std::size_t> shape;
    std::vector<std::byte> bytes;

    /// The elements as T; sizeof(T) must divide the bytes.
    template <class T>
    std::span<const T> get() const {
        return {reinterpret_cast<const T*>(bytes.data()), bytes.size() / sizeof(T)};
    }
};

std::size_t size_of(reference::ElementType type);
const char* to_string(reference::ElementType type);  ///< "float32"
/// Elements of an array of that shape.
std::size_t element_count(std::span<const std::size_t> shape);
/// "[3, 4]"
std::string shape_text(std::span<const std::size_t> shape);

/// All that comes before the data in such a file; a multiple of 64 bytes.
std::string npy_header(reference::ElementType type, std::span<const std::size_t> shape);

/// Throws bad_input naming the file where it cannot be written; internal where `bytes` is not what
/// type and shape need.
void write_npy(const std::filesystem::path& file, reference::ElementType type,
               std::span<const std::size_t> shape, const void* data, std::size_t bytes);

/// Throws bad_input naming the file: not there, not .npy 1.0, another type than ElementType's or
/// big endian, Fortran order, more or fewer bytes than the shape needs.
NpyArray read_npy(const std::filesystem::path& file);

/// XXH64 (seed 0) as 16 hexadecimal digits.
std::string hash_text(const void* data, std::size_t bytes);
std::string hex_text(std::uint64_t value);

}  // namespace scotty::verify
