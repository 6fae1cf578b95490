#include "scenes/ply_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "reference/base/error.h"
#include "scenes/parse_number.h"

namespace scotty::scenes {

namespace {

template <class Value>
double value_of(const char* raw) {
    Value value;
    std::memcpy(&value, raw, sizeof value);
    return static_cast<double>(value);
}

double value_of(PlyType type, const char* raw) {
    switch (type) {
        case PlyType::int8:
            return value_of<std::int8_t>(raw);
        case PlyType::uint8:
            return value_of<std::uint8_t>(raw);
        case PlyType::int16:
            return value_of<std::int16_t>(raw);
        case PlyType::uint16:
            return value_of<std::uint16_t>(raw);
        case PlyType::int32:
            return value_of<std::int32_t>(raw);
        case PlyType::uint32:
            return value_of<std::uint32_t>(raw);
        case PlyType::float32:
            return value_of<float>(raw);
        default:
            return value_of<double>(raw);
    }
}

}  // namespace

double PlyValues::decoded(PlyType type) {
    const std::size_t size = size_of(type);
    const char* raw = reader_.bytes(size);
    if (raw == nullptr) fail_truncated();
    if (format_ == PlyFormat::binary_little_endian) return value_of(type, raw);
    char reversed[8] = {};
    std::reverse_copy(raw, raw + size, reversed);
    return value_of(type, reversed);
}

std::string_view PlyValues::word() {
    const std::string_view found = reader_.word();
    if (found.empty()) fail_truncated();
    return found;
}

double PlyValues::number(const PlyProperty& property, PlyType type) {
    if (format_ != PlyFormat::ascii) return decoded(type);
    const std::string_view text = word();
    const std::optional<double> value = parse_finite(text);
    if (!value) fail_number(property, text);
    return *value;
}

std::optional<float> PlyValues::finite_float(const PlyProperty& property) {
    if (format_ == PlyFormat::ascii) {
        const std::string_view text = word();
        const std::optional<float> value = parse_finite_float(text);
        if (!value && !is_not_finite(text)) fail_number(property, text);
        return value;
    }
    const double value = decoded(property.type);
    if (!(std::abs(value) <= std::numeric_limits<float>::max())) return std::nullopt;
    return static_cast<float>(value);
}

std::uint64_t PlyValues::length(const PlyProperty& list) {
    const double value = number(list, *list.count_type);
    // No file is so long that the largest exact integer would be too small.
    if (value >= 0.0 && value <= 9007199254740992.0 && value == std::floor(value)) {
        return static_cast<std::uint64_t>(value);
    }
    fail(fmt::format("{}: expected a list length, found {}", shown(list.name), value));
}

void PlyValues::skip(const PlyProperty& property) {
    const std::uint64_t count = property.count_type ? length(property) : 1;
    if (format_ == PlyFormat::ascii) {
        for (std::uint64_t i = 0; i < count; ++i) word();
    } else if (!reader_.skip(count * size_of(property.type))) {
        fail_truncated();
    }
}

void PlyValues::fail(const std::string& what) const {
    throw reference::Error::bad_input(
        fmt::format("{}: {} {}", reader_.path(), shown(element_->name), number_), what);
}

void PlyValues::fail_truncated() const {
    fail(fmt::format("the file ends here, the header announces {} (truncated?)", element_->count));
}

void PlyValues::fail_number(const PlyProperty& property, std::string_view found) const {
    fail(fmt::format("{}: expected a finite number, found '{}'", shown(property.name),
                     shown(found)));
}

}  // namespace scotty::scenes
