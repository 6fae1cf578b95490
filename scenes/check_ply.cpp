#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <utility>

#include "reference/base/error.h"
#include "scenes/file_checks.h"

namespace scotty::scenes {

using reference::Error;

namespace {

struct Property {
    std::string name;
    std::string type;
    std::string count_type;  ///< of a list; empty: a single value
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

/// Size in bytes of a PLY type, 0 for a word that is none.
std::size_t size_of(const std::string& type) {
    for (const char* name : {"char", "uchar", "int8", "uint8"}) {
        if (type == name) return 1;
    }
    for (const char* name : {"short", "ushort", "int16", "uint16"}) {
        if (type == name) return 2;
    }
    for (const char* name : {"int", "uint", "int32", "uint32", "float", "float32"}) {
        if (type == name) return 4;
    }
    return type == "double" || type == "float64" ? 8 : 0;
}

bool is_signed(const std::string& type) { return type[0] != 'u'; }
bool is_float(const std::string& type) { return type[0] == 'f' || type[0] == 'd'; }

class PlyChecker {
 public:
    explicit PlyChecker(std::string path) : path_(std::move(path)), bytes_(read_file(path_)) {}

    void check() {
        read_header();
        const auto vertex = std::find_if(elements_.begin(), elements_.end(),
                                         [](const Element& e) { return e.name == "vertex"; });
        if (vertex == elements_.end() || vertex->count == 0) fail("header", "no vertices");
        vertices_ = vertex->count;
        for (const char* name : {"x", "y", "z"}) {
            const auto times = std::count_if(
                vertex->properties.begin(), vertex->properties.end(),
                [&](const Property& p) { return p.name == name && p.count_type.empty(); });
            if (times != 1)
                fail("header", fmt::format("vertex: expected one '{}', found {}", name, times));
        }
        for (const Element& element : elements_) {
            if (element.properties.empty()) continue;
            for (std::uint64_t i = 0; i < element.count; ++i) check_element(element, i);
        }
    }

 private:
    [[noreturn]] void fail(const std::string& where, const std::string& what) const {
        throw Error::bad_input(path_ + ": " + where, what);
    }

    /// Strict: of a header that it half understands assimp makes what it likes, or no end.
    void read_header() {
        if (next_line() != "ply") fail("header", "expected a PLY file ('ply' first)");
        while (true) {
            if (at_ >= bytes_.size()) fail("header", "no end_header (truncated?)");
            const std::string line = next_line();
            if (line == "end_header") break;
            read_header_line(line);
        }
        if (format_ != "ascii" && format_ != "binary_little_endian" &&
            format_ != "binary_big_endian") {
            fail("header", fmt::format("format: expected ascii, binary_little_endian or "
                                       "binary_big_endian, found '{}'",
                                       format_));
        }
    }

    /// Without its end; the file's end is a line's, too. Control characters are refused: assimp
    /// reads a name up to a zero byte, and then takes the data for something else.
    std::string next_line() {
        const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
        std::string line = bytes_.substr(at_, end - at_);
        at_ = std::min(end + 1, bytes_.size());
        if (!line.empty() && line.back() == '\r') line.pop_back();
        const auto control = [](char c) { return (c >= 0 && c < ' ' && c != '\t') || c == 0x7f; };
        const auto found = std::find_if(line.begin(), line.end(), control);
        if (found != line.end()) {
            fail("header",
                 fmt::format("a byte that is no text: {:#04x}", static_cast<int>(*found)));
        }
        return line;
    }

    void read_header_line(const std::string& line) {
        std::istringstream words(line);
        std::string key;
        words >> key;
        if (key == "comment" || key == "obj_info") return;
        bool understood = false;
        if (key == "format") {
            std::string version;
            understood = static_cast<bool>(words >> format_ >> version);
        } else if (key == "element") {
            Element& element = elements_.emplace_back();
            understood = static_cast<bool>(words >> element.name >> element.count);
        } else if (key == "property") {
            understood = read_property(words);
        }
        std::string more;
        if (!understood || words >> more) {
            fail("header", fmt::format("not understood: '{}'", line));
        }
    }

    bool read_property(std::istringstream& words) {
        Property property;
        words >> property.type;
        const bool is_list = property.type == "list";
        if (is_list) words >> property.count_type >> property.type;
        words >> property.name;
        const bool known = words && !elements_.empty() && size_of(property.type) != 0 &&
                           (!is_list || size_of(property.count_type) != 0);
        if (known) elements_.back().properties.push_back(property);
        return known;
    }

    void check_element(const Element& element, std::uint64_t number) {
        const auto where = [&] { return fmt::format("{} {}", element.name, number); };
        for (const Property& property : element.properties) {
            if (property.count_type.empty()) {
                const double value = read(property.type, element, number);
                if (element.name == "vertex" && !std::isfinite(value)) {
                    fail(where(), fmt::format("{}: expected a finite number", property.name));
                }
                continue;
            }
            const double count = read(property.count_type, element, number);
            if (!(count >= 0.0)) fail(where(), "a negative list length");
            const bool is_face = property.name.rfind("vertex_ind", 0) == 0;
            if (is_face && count < 1.0) fail(where(), "a face without corners");
            for (double k = 0; k < count; ++k) {
                const double index = read(property.type, element, number);
                if (!is_face || (index >= 0.0 && index < static_cast<double>(vertices_))) continue;
                fail(where(), fmt::format("vertex index {} out of range, the file has {} vertices",
                                          index, vertices_));
            }
        }
    }

    double read(const std::string& type, const Element& element, std::uint64_t number) {
        const double value = format_ == "ascii" ? read_text() : read_binary(type);
        if (ended_) {
            fail(fmt::format("{} {}", element.name, number),
                 fmt::format("the file ends here, the header announces {} (truncated?)",
                             element.count));
        }
        return value;
    }

    double read_text() {
        const std::size_t begin = bytes_.find_first_not_of(" \t\r\n", at_);
        if (begin == std::string::npos) {
            ended_ = true;
            return 0.0;
        }
        const std::size_t end = std::min(bytes_.find_first_of(" \t\r\n", begin), bytes_.size());
        double value = 0.0;
        const auto [stop, status] =
            std::from_chars(bytes_.data() + begin, bytes_.data() + end, value);
        at_ = end;
        if (status == std::errc::invalid_argument || stop != bytes_.data() + end) {
            fail(fmt::format("byte {}", begin),
                 fmt::format("expected a number, found '{}'", bytes_.substr(begin, end - begin)));
        }
        return value;
    }

    double read_binary(const std::string& type) {
        const std::size_t size = size_of(type);
        if (bytes_.size() - at_ < size) {
            ended_ = true;
            return 0.0;
        }
        unsigned char raw[8] = {};
        const bool is_big = format_ == "binary_big_endian";
        for (std::size_t k = 0; k < size; ++k) {
            raw[is_big ? size - 1 - k : k] = static_cast<unsigned char>(bytes_[at_ + k]);
        }
        at_ += size;
        if (is_float(type)) {
            if (size == 8) return from_bytes<double>(raw);
            return from_bytes<float>(raw);
        }
        if (size == 1) {
            return is_signed(type) ? from_bytes<std::int8_t>(raw) : from_bytes<std::uint8_t>(raw);
        }
        if (size == 2) {
            return is_signed(type) ? from_bytes<std::int16_t>(raw) : from_bytes<std::uint16_t>(raw);
        }
        return is_signed(type) ? from_bytes<std::int32_t>(raw) : from_bytes<std::uint32_t>(raw);
    }

    template <class Value>
    static double from_bytes(const unsigned char* raw) {
        Value value;
        std::memcpy(&value, raw, sizeof value);
        return static_cast<double>(value);
    }

    std::string path_;
    std::string bytes_;
    std::string format_;
    std::vector<Element> elements_;
    std::uint64_t vertices_ = 0;
    std::size_t at_ = 0;
    bool ended_ = false;
};

}  // namespace

void check_ply(const std::string& path) { PlyChecker(path).check(); }

}  // namespace scotty::scenes
