#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>
#include <utility>

#include "reference/base/error.h"
#include "scenes/file_checks.h"
#include "scenes/parse_number.h"

namespace scotty::scenes {

using reference::Error;

std::string read_file(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file) throw Error::bad_input(path, "cannot be read");
    return bytes;
}

namespace {

std::string_view next_word(std::string_view& line) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) {
        line = {};
        return {};
    }
    const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
    const std::string_view word = line.substr(begin, end - begin);
    line.remove_prefix(end);
    return word;
}

/// Goes through the file once; face indices may refer to vertices that come later.
class ObjChecker {
 public:
    ObjChecker(std::string path, Notes& notes) : path_(std::move(path)), notes_(notes) {}

    void check() {
        const std::string text = read_file(path_);
        std::string joined;
        std::size_t begin = 0;
        while (begin < text.size()) {
            const std::size_t end = std::min(text.find('\n', begin), text.size());
            std::string_view part(text.data() + begin, end - begin);
            begin = end + 1;
            ++line_number_;
            if (!part.empty() && part.back() == '\r') part.remove_suffix(1);
            if (!part.empty() && part.back() == '\\') {
                joined += part.substr(0, part.size() - 1);
                continue;
            }
            if (joined.empty()) {
                check_line(part);
            } else {
                joined += part;
                check_line(joined);
                joined.clear();
            }
        }
        if (vertices_ == 0) fail("no vertices ('v' lines): not an OBJ file, or an empty one");
        if (largest_index_ > vertices_) {
            line_number_ = largest_line_;
            fail(fmt::format("vertex index {} out of range, the file has {} vertices",
                             largest_index_, vertices_));
        }
    }

 private:
    [[noreturn]] void fail(const std::string& what) const {
        throw Error::bad_input(fmt::format("{}: line {}", path_, line_number_), what);
    }

    void check_line(std::string_view line) {
        const std::string_view key = next_word(line);
        if (key == "v") {
            check_vertex(line);
        } else if (key == "f") {
            check_face(line);
        } else if (key == "mtllib") {
            const std::string name(
                line.substr(std::min(line.find_first_not_of(" \t"), line.size())));
            const auto file = std::filesystem::path(path_).parent_path() / name;
            if (!std::filesystem::exists(file)) {
                notes_.add(
                    fmt::format("the material library '{}' is missing: default material", name));
            }
        } else if (key == "l" || key == "p" || key == "curv" || key == "surf") {
            notes_.add(
                fmt::format("'{}' elements (lines, points, curves) are not supported: left "
                            "out",
                            key));
        }
    }

    void check_vertex(std::string_view line) {
        ++vertices_;
        for (int k = 0; k < 3; ++k) {
            const std::string_view word = next_word(line);
            const std::optional<double> value = parse_finite(word);
            if (!value || std::abs(*value) > std::numeric_limits<float>::max()) {
                fail(fmt::format("vertex {}: expected three finite numbers, found '{}'", vertices_,
                                 word));
            }
        }
    }

    void check_face(std::string_view line) {
        int corners = 0;
        for (std::string_view word = next_word(line); !word.empty(); word = next_word(line)) {
            if (word.front() == '#') break;
            std::int64_t index = 0;
            const char* end = word.data() + std::min(word.find('/'), word.size());
            const auto [stop, status] = std::from_chars(word.data(), end, index);
            if (status != std::errc() || stop != end || index == 0) {
                fail(
                    fmt::format("expected a vertex index, from 1 or from -1 on, found '{}'", word));
            }
            if (index < 0 && -index > vertices_) {
                fail(fmt::format("vertex index {} out of range, {} vertices come before it", index,
                                 vertices_));
            }
            if (index > largest_index_) {
                largest_index_ = index;
                largest_line_ = line_number_;
            }
            ++corners;
        }
        if (corners < 3) fail(fmt::format("a face needs at least 3 corners, found {}", corners));
    }

    std::string path_;
    Notes& notes_;
    std::size_t line_number_ = 0;
    std::int64_t vertices_ = 0;
    std::int64_t largest_index_ = 0;
    std::size_t largest_line_ = 0;
};

}  // namespace

void check_obj(const std::string& path, Notes& notes) { ObjChecker(path, notes).check(); }

}  // namespace scotty::scenes
