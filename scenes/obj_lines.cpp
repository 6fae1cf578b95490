#include "scenes/obj_lines.h"

#include <fmt/format.h>

#include <algorithm>

#include "reference/base/error.h"

namespace scotty::scenes {

namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\v' || c == '\f'; }

/// Whether a backslash joins the line with the next; blanks behind it cannot be seen in an editor.
bool continues(std::string_view line) {
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    return !line.empty() && line.back() == '\\' && without_comment(line) == line;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
    return text;
}

std::string_view take_word(std::string_view& text) {
    std::size_t begin = 0;
    while (begin < text.size() && is_blank(text[begin])) ++begin;
    std::size_t end = begin;
    while (end < text.size() && !is_blank(text[end])) ++end;
    const std::string_view word = text.substr(begin, end - begin);
    text.remove_prefix(end);
    return word;
}

std::string_view without_comment(std::string_view text) {
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] == '#' && (i == 0 || is_blank(text[i - 1]))) return trimmed(text.substr(0, i));
    }
    return text;
}

bool ObjLines::next() {
    while (std::optional<std::string_view> line = reader_.line()) {
        ++line_number_;
        statement_line_ = line_number_;
        if (continues(*line)) {
            joined_.clear();
            while (line && continues(*line)) {
                joined_.append(line->substr(0, line->rfind('\\'))).push_back(' ');
                line = reader_.line();
                ++line_number_;
            }
            if (line) joined_.append(*line);
            line = joined_;
        }
        split(*line);
        if (!key_.empty() && key_.front() != '#') return true;
    }
    return false;
}

void ObjLines::split(std::string_view line) {
    rest_ = line;
    key_ = take_word(rest_);
    rest_ = trimmed(rest_);
    const auto is_upper = [](char c) { return c >= 'A' && c <= 'Z'; };
    if (std::none_of(key_.begin(), key_.end(), is_upper)) return;
    lower_key_ = key_;
    for (char& c : lower_key_) c = is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c;
    key_ = lower_key_;
}

std::string_view ObjLines::numbers() const {
    // "-1.#IND" is how some exporters write a number that is none.
    std::size_t at = rest_.find('#');
    while (at != std::string_view::npos && at > 0 && rest_[at - 1] == '.') {
        at = rest_.find('#', at + 1);
    }
    return rest_.substr(0, at);
}

std::string ObjLines::place() const {
    return fmt::format("{}: line {}", reader_.path(), statement_line_);
}

void ObjLines::fail(const std::string& what) const {
    throw reference::Error::bad_input(place(), what);
}

}  // namespace scotty::scenes
