/// A file read from front to back through a buffer of fixed size, as lines, words or bytes.
///
/// Scene files are larger than the scenes they hold; the buffer keeps them out of memory. Lines end
/// with \n, \r\n or a lone \r. What is returned as a view is valid until the next call.
#pragma once

#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace scotty::scenes {

/// `text` for a message: about 60 bytes of it, control characters and what is no
/// UTF-8 as question marks.
std::string shown(std::string_view text);

class FileReader {
 public:
    /// Longest line or word, in bytes; longer ones belong to a file of another kind.
    static constexpr std::size_t kLongest = std::size_t{1} << 26;

    /// Throws reference::Error (bad_input) where the file cannot be read. A UTF-8 byte order mark
    /// at the beginning is left out.
    explicit FileReader(std::string path);

    /// The next line without its end; nothing behind the last one.
    std::optional<std::string_view> line();
    /// The next word between blanks, tabs and line ends; empty behind the last one.
    std::string_view word();
    /// The next `count` bytes, or null where the file has fewer left.
    const char* bytes(std::size_t count);
    /// Whether `count` bytes could be skipped.
    bool skip(std::uint64_t count);

    /// What ended the last line: "\n", "\r\n", "\r", or nothing at the end of the file.
    std::string_view line_end() const { return line_end_; }
    /// Makes the last byte of what was read last the next one again.
    void give_back_byte() { --begin_; }
    /// Bytes before the next one to be read.
    std::uint64_t position() const { return before_buffer_ + begin_; }
    std::uint64_t left() const { return size_ - position(); }
    const std::string& path() const { return path_; }

 private:
    /// Reads more behind what is there, which moves to the front. False at the end of the file.
    bool fill();

    std::string path_;
    std::ifstream file_;
    std::vector<char> buffer_;
    std::size_t begin_ = 0;  ///< of what is not yet read, in the buffer
    std::size_t end_ = 0;
    std::string_view line_end_;
    std::uint64_t before_buffer_ = 0;
    std::uint64_t size_ = 0;
};

}  // namespace scotty::scenes
