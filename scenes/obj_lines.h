/// The statements of an OBJ file or a material library (MTL): a keyword and what follows it.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "scenes/file_reader.h"

namespace scotty::scenes {

/// Takes the next word between blanks off the front of `text`; empty where there is none.
std::string_view take_word(std::string_view& text);

/// Without blanks at both ends.
std::string_view trimmed(std::string_view text);

/// Without a comment: a # that is first or has a blank before it, and all that follows.
std::string_view without_comment(std::string_view text);

class ObjLines {
 public:
    /// Throws reference::Error (bad_input) where the file cannot be read.
    explicit ObjLines(const std::string& path) : reader_(path) {}

    /// Moves to the next statement; false behind the last one. Lines may begin with blanks; a
    /// backslash at a line's end joins it with the next, except in a comment. Empty lines and
    /// comments are left out.
    bool next();

    /// In lower case: files of some exporters differ there, and no two keywords do.
    std::string_view key() const { return key_; }
    /// Without blanks at both ends; comments are still in it, as names may contain a #.
    std::string_view rest() const { return rest_; }
    /// What follows the keyword up to a # , for statements of numbers.
    std::string_view numbers() const;

    /// "scene.obj: line 17", for errors.
    std::string place() const;
    /// Throws reference::Error (bad_input) naming the statement's first line.
    [[noreturn]] void fail(const std::string& what) const;

 private:
    void split(std::string_view line);

    FileReader reader_;
    std::string joined_;
    std::string lower_key_;
    std::string_view key_;
    std::string_view rest_;
    std::size_t line_number_ = 0;  ///< of the line that was read last
    std::size_t statement_line_ = 0;
};

}  // namespace scotty::scenes
