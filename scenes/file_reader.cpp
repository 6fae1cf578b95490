#include "scenes/file_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "reference/base/error.h"

namespace scotty::scenes {

using reference::Error;

namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 18;

bool is_separator(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }

}  // namespace

std::string shown(std::string_view text) {
    constexpr std::size_t kMost = 60;
    std::string out(text.substr(0, kMost));
    for (char& c : out) c = (c >= 0 && c < ' ') || c == 0x7f ? '?' : c;
    return text.size() > kMost ? out + "..." : out;
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
