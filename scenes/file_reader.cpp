#include "scenes/file_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "reference/base/error.h"

namespace scotty::scenes {

using reference::Error;

namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 18;

/// Bytes of the UTF-8 character at the front of `text`; 0 where there is none. Messages end up in
/// JSON, which has to be UTF-8.
std::size_t character_length(std::string_view text) {
    const auto byte = [&](std::size_t i) {
        return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
    };
    const auto follows = [&](std::size_t i) { return (byte(i) & 0xc0u) == 0x80u; };
    if (byte(0) < 0x80) return 1;
    if (byte(0) >= 0xc2 && byte(0) < 0xe0) return follows(1) ? 2 : 0;
    if ((byte(0) & 0xf0u) == 0xe0) {
        // Neither longer than needed nor half of a pair (RFC 3629, section 4).
        const bool is_minimal = byte(0) != 0xe0 || byte(1) >= 0xa0;
        const bool is_half = byte(0) == 0xed && byte(1) >= 0xa0;
        return follows(1) && follows(2) && is_minimal && !is_half ? 3 : 0;
    }
    if (byte(0) >= 0xf0 && byte(0) < 0xf5) {
        const bool is_in_range =
            (byte(0) != 0xf0 || byte(1) >= 0x90) && (byte(0) != 0xf4 || byte(1) < 0x90);
        return follows(1) && follows(2) && follows(3) && is_in_range ? 4 : 0;
    }
    return 0;
}

bool is_separator(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

}  // namespace

std::string shown(std::string_view text) {
    constexpr std::size_t kMost = 60;
    std::string out;
    while (!text.empty() && out.size() < kMost) {
        const std::size_t length = character_length(text);
        const bool is_control = length == 1 && (text[0] < ' ' || text[0] == 0x7f);
        out += length == 0 || is_control ? "?" : text.substr(0, length);
        text.remove_prefix(std::max<std::size_t>(length, 1));
    }
    return text.empty() ? out : out + "...";
}

FileReader::FileReader(std::string path)
    : path_(std::move(path)), file_(path_, std::ios::binary | std::ios::ate) {
    const std::streamoff size = file_ ? static_cast<std::streamoff>(file_.tellg()) : -1;
    if (size < 0) throw Error::bad_input(path_, "cannot be read (is it yours to read?)");
    size_ = static_cast<std::uint64_t>(size);
    file_.seekg(0);
    buffer_.resize(kBufferSize);
    fill();
    if (end_ >= 3 && std::memcmp(buffer_.data(), "\xef\xbb\xbf", 3) == 0) begin_ = 3;
}

bool FileReader::fill() {
    if (begin_ > 0) {
        std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
        before_buffer_ += begin_;
        end_ -= begin_;
        begin_ = 0;
    }
    if (end_ == buffer_.size()) {
        if (end_ >= kLongest) {
            throw Error::bad_input(
                path_, fmt::format("a line of more than {} MiB at byte {}: is it a text file?",
                                   kLongest >> 20, before_buffer_));
        }
        buffer_.resize(2 * end_);
    }
    file_.read(buffer_.data() + end_, static_cast<std::streamsize>(buffer_.size() - end_));
    const auto count = static_cast<std::size_t>(file_.gcount());
    if (file_.bad()) throw Error::bad_input(path_, "an error of the disk while reading");
    end_ += count;
    // A file that shrank or grew meanwhile is as long as it turns out to be.
    if (count == 0) size_ = before_buffer_ + end_;
    return count > 0;
}

std::optional<std::string_view> FileReader::line() {
    std::size_t length = 0;
    while (true) {
        const char* text = buffer_.data() + begin_;
        const std::size_t there = end_ - begin_;
        while (length < there && text[length] != '\n' && text[length] != '\r') ++length;
        if (length == there) {
            if (fill()) continue;
            if (length == 0) return std::nullopt;
            begin_ = end_;
            line_end_ = "";
            return std::string_view(buffer_.data() + end_ - length, length);
        }
        // A \r that is last in the buffer may have its \n behind it.
        if (text[length] == '\r' && length + 1 == there && fill()) continue;
        text = buffer_.data() + begin_;
        const bool is_pair =
            text[length] == '\r' && begin_ + length + 1 < end_ && text[length + 1] == '\n';
        line_end_ = is_pair ? "\r\n" : text[length] == '\r' ? "\r" : "\n";
        begin_ += length + line_end_.size();
        return std::string_view(text, length);
    }
}

std::string_view FileReader::word() {
    while (true) {
        while (begin_ < end_ && is_separator(buffer_[begin_])) ++begin_;
        if (begin_ < end_) break;
        if (!fill()) return {};
    }
    std::size_t length = 1;
    while (true) {
        const char* text = buffer_.data() + begin_;
        const std::size_t there = end_ - begin_;
        while (length < there && !is_separator(text[length])) ++length;
        if (length < there || !fill()) break;
    }
    const std::string_view found(buffer_.data() + begin_, length);
    begin_ += length;
    return found;
}

const char* FileReader::bytes(std::size_t count) {
    while (end_ - begin_ < count) {
        if (!fill()) return nullptr;
    }
    const char* found = buffer_.data() + begin_;
    begin_ += count;
    return found;
}

bool FileReader::skip(std::uint64_t count) {
    while (count > end_ - begin_) {
        count -= end_ - begin_;
        begin_ = end_;
        if (!fill()) return false;
    }
    begin_ += static_cast<std::size_t>(count);
    return true;
}

}  // namespace scotty::scenes
