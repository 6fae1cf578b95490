#include "scenes/ply_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "reference/base/error.h"

namespace scotty::scenes {

using reference::Error;

namespace {

/// Elements and properties together; more are the work of somebody hostile.
constexpr std::size_t kMaxEntries = 4096;

struct TypeName {
    std::string_view name;
    PlyType type;
};
constexpr TypeName kTypeNames[] = {
    {"char", PlyType::int8},      {"int8", PlyType::int8},       {"uchar", PlyType::uint8},
    {"uint8", PlyType::uint8},    {"short", PlyType::int16},     {"int16", PlyType::int16},
    {"ushort", PlyType::uint16},  {"uint16", PlyType::uint16},   {"int", PlyType::int32},
    {"int32", PlyType::int32},    {"uint", PlyType::uint32},     {"uint32", PlyType::uint32},
    {"float", PlyType::float32},  {"float32", PlyType::float32}, {"double", PlyType::float64},
    {"float64", PlyType::float64}};

std::optional<PlyType> type_named(std::string_view word) {
    for (const auto& [name, type] : kTypeNames) {
        if (name == word) return type;
    }
    return std::nullopt;
}

std::vector<std::string> words_of(std::string_view line) {
    std::vector<std::string> words;
    while (true) {
        const std::size_t begin = std::min(line.find_first_not_of(" \t"), line.size());
        line.remove_prefix(begin);
        if (line.empty()) return words;
        const std::size_t length = std::min(line.find_first_of(" \t"), line.size());
        words.emplace_back(line.substr(0, length));
        line.remove_prefix(length);
    }
}

class HeaderReader {
 public:
    explicit HeaderReader(FileReader& reader) : reader_(reader) {}

    PlyHeader read() {
        if (words_of(next_line()) != std::vector<std::string>{"ply"}) {
            fail("expected a PLY file ('ply' first)");
        }
        const bool has_lone_returns = reader_.line_end() == "\r";
        while (true) {
            const std::string line = next_line();
            const std::vector<std::string> words = words_of(line);
            if (words == std::vector<std::string>{"end_header"}) break;
            if (!is_understood(words)) fail(fmt::format("not understood: '{}'", shown(line)));
            if (entries_ > kMaxEntries) {
                fail(fmt::format("more than {} elements and properties", kMaxEntries));
            }
        }
        // What looks like the second half of a line end is the first byte of data there.
        if (has_lone_returns && reader_.line_end() == "\r\n") reader_.give_back_byte();
        if (!has_format_) {
            fail("no format: expected ascii, binary_little_endian or binary_big_endian");
        }
        return std::move(header_);
    }

 private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error::bad_input(reader_.path() + ": header", what);
    }

    /// Refuses control characters: data taken for a header is not worth showing.
    std::string next_line() {
        const std::optional<std::string_view> line = reader_.line();
        if (!line) {
            fail(line_number_ == 0 ? "expected a PLY file ('ply' first)"
                                   : "no end_header (truncated?)");
        }
        ++line_number_;
        const auto control = [](char c) { return (c >= 0 && c < ' ' && c != '\t') || c == 0x7f; };
        const auto* const found = std::find_if(line->begin(), line->end(), control);
        if (found != line->end()) {
            fail(fmt::format("a byte that is no text: {:#04x}", static_cast<int>(*found)));
        }
        return std::string(*line);
    }

    bool is_understood(const std::vector<std::string>& words) {
        if (words.empty()) return true;
        const std::string& key = words[0];
        if (key == "comment" || key == "obj_info") {
            header_.names_texture |= words.size() > 2 && words[1] == "TextureFile";
            return true;
        }
        ++entries_;
        if (key == "format") return words.size() == 3 && read_format(words[1], words[2]);
        if (key == "element") return words.size() == 3 && read_element(words[1], words[2]);
        return key == "property" && read_property(words);
    }

    bool read_format(const std::string& name, const std::string& version) {
        if (version != "1.0") {
            fail(fmt::format("version 1.0 is the one that is supported, found '{}'",
                             shown(version)));
        }
        has_format_ = true;
        if (name == "ascii") {
            header_.format = PlyFormat::ascii;
        } else if (name == "binary_little_endian") {
            header_.format = PlyFormat::binary_little_endian;
        } else if (name == "binary_big_endian") {
            header_.format = PlyFormat::binary_big_endian;
        } else {
            fail(
                fmt::format("format: expected ascii, binary_little_endian or binary_big_endian, "
                            "found '{}'",
                            shown(name)));
        }
        return true;
    }

    bool read_element(const std::string& name, const std::string& count) {
        if (header_.element(name) != nullptr) {
            fail(fmt::format("the element '{}' occurs twice", shown(name)));
        }
        PlyElement& element = header_.elements.emplace_back();
        element.name = name;
        const char* end = count.data() + count.size();
        const auto [stop, status] = std::from_chars(count.data(), end, element.count);
        return status == std::errc() && stop == end;
    }

    bool read_property(const std::vector<std::string>& words) {
        const bool is_list = words.size() == 5 && words[1] == "list";
        if (header_.elements.empty() || (!is_list && words.size() != 3)) return false;
        PlyProperty property;
        property.name = words.back();
        const std::optional<PlyType> type = type_named(words[words.size() - 2]);
        if (is_list) property.count_type = type_named(words[2]);
        if (!type || (is_list && !property.count_type)) return false;
        property.type = *type;
        header_.elements.back().properties.push_back(std::move(property));
        return true;
    }

    FileReader& reader_;
    PlyHeader header_;
    bool has_format_ = false;
    std::size_t line_number_ = 0;
    std::size_t entries_ = 0;
};

}  // namespace

std::size_t size_of(PlyType type) {
    constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
    return kSizes[static_cast<std::size_t>(type)];
}

std::size_t PlyElement::values_named(const std::string& wanted) const {
    return static_cast<std::size_t>(
        std::count_if(properties.begin(), properties.end(),
                      [&](const PlyProperty& property) { return property.name == wanted; }));
}

const PlyProperty* PlyElement::value(const std::string& wanted) const {
    for (const PlyProperty& property : properties) {
        if (property.name == wanted && !property.count_type) return &property;
    }
    return nullptr;
}

const PlyElement* PlyHeader::element(const std::string& name) const {
    for (const PlyElement& candidate : elements) {
        if (candidate.name == name) return &candidate;
    }
    return nullptr;
}

PlyHeader read_ply_header(FileReader& reader) { return HeaderReader(reader).read(); }

}  // namespace scotty::scenes
