/// The data of a PLY file, value by value, in its three encodings.
#pragma once

#include <optional>

#include "scenes/ply_header.h"

namespace scotty::scenes {

class PlyValues {
 public:
    PlyValues(FileReader& reader, PlyFormat format) : reader_(reader), format_(format) {}

    /// Moves on to an element, for errors: "scan.ply: face 17".
    void begin(const PlyElement& element, std::uint64_t number) {
        element_ = &element;
        number_ = number;
    }

    // All of these throw reference::Error (bad_input) naming the element where the data ends or is
    // no number.

    double number(const PlyProperty& property, PlyType type);
    /// Not finite: nothing. Text is rounded once.
    std::optional<float> finite_float(const PlyProperty& property);
    /// The length of a list.
    std::uint64_t length(const PlyProperty& list);
    /// A value or a whole list, unread.
    void skip(const PlyProperty& property);

    [[noreturn]] void fail(const std::string& what) const;

 private:
    std::string_view word();
    [[noreturn]] void fail_truncated() const;
    [[noreturn]] void fail_number(const PlyProperty& property, std::string_view found) const;
    double decoded(PlyType type);

    FileReader& reader_;
    PlyFormat format_;
    const PlyElement* element_ = nullptr;
    std::uint64_t number_ = 0;
};

}  // namespace scotty::scenes
