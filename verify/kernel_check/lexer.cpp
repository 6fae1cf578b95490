#include "verify/kernel_check/lexer.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>

namespace scotty::verify {

namespace {

bool begins_name(char c) { return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_'; }
bool in_name(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

class Reader {
 public:
    explicit Reader(const std::string& text) : text_(text) {}

    Tokens read() {
        tokens_.files = {"the text"};  // before the first marker
        bool line_begins = true;
        while (at_ < text_.size()) {
            const char c = text_[at_];
            if (c == '\n') {
                ++line_;
                ++at_;
                line_begins = true;
            } else if (std::isspace(static_cast<unsigned char>(c)) != 0) {
                ++at_;
            } else if (c == '#' && line_begins) {
                marker();
            } else {
                line_begins = false;
                token();
            }
        }
        return std::move(tokens_);
    }

 private:
    /// # 12 "file.cu" 1 3 4
    void marker() {
        const std::size_t end = std::min(text_.find('\n', at_), text_.size());
        const std::string words = text_.substr(at_, end - at_);
        const std::size_t quote = words.find('"');
        const std::size_t close = words.rfind('"');
        if (words.size() > 2 && words[1] == ' ' && std::isdigit(words[2]) != 0 &&
            quote != std::string::npos && close > quote) {
            line_ = std::atoi(words.c_str() + 2) - 1;  // the next line has that number
            const std::string file = words.substr(quote + 1, close - quote - 1);
            const auto known = std::find(tokens_.files.begin(), tokens_.files.end(), file);
            file_ = static_cast<int>(known - tokens_.files.begin());
            if (known == tokens_.files.end()) tokens_.files.push_back(file);
            system_ = words.find(" 3", close) != std::string::npos;
        }
        at_ = end;
    }

    void token() {
        const std::size_t begin = at_;
        const char c = text_[at_];
        TokenKind kind = TokenKind::punctuation;
        if (begins_name(c)) {
            while (at_ < text_.size() && in_name(text_[at_])) ++at_;
            const std::string_view word(text_.data() + begin, at_ - begin);
            const bool prefix =
                word == "R" || word == "LR" || word == "uR" || word == "UR" || word == "u8R";
            const bool quote = at_ < text_.size() && (text_[at_] == '"' || text_[at_] == '\'');
            const bool encoding = word == "L" || word == "u" || word == "U" || word == "u8";
            kind = TokenKind::identifier;
            if (prefix && quote) {
                raw_string();
                kind = TokenKind::text;
            } else if (encoding && quote) {
                quoted();
                kind = TokenKind::text;
            }
        } else if (std::isdigit(static_cast<unsigned char>(c)) != 0) {
            kind = TokenKind::number;
            while (at_ < text_.size() &&
                   (in_name(text_[at_]) || text_[at_] == '.' || text_[at_] == '\'' ||
                    ((text_[at_] == '+' || text_[at_] == '-') && is_exponent(text_[at_ - 1])))) {
                ++at_;
            }
        } else if (c == '"' || c == '\'') {
            quoted();
            kind = TokenKind::text;
        } else if (!triple('<') && !triple('>')) {
            const std::string_view two = std::string_view(text_).substr(at_, 2);
            at_ += two == "::" || two == "->" ? 2 : 1;
        }
        Token out;
        out.kind = kind;
        out.spelling = std::string_view(text_).substr(begin, at_ - begin);
        if (out.spelling.starts_with("<<")) out.spelling = "<<<";
        if (out.spelling.starts_with(">>")) out.spelling = ">>>";
        out.begin = begin;
        out.end = at_;
        out.file = file_;
        out.line = line_;
        out.system = system_;
        tokens_.all.push_back(out);
        line_ +=
            static_cast<int>(std::count(text_.begin() + static_cast<std::ptrdiff_t>(begin),
                                        text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n'));
    }

    static bool is_exponent(char c) { return c == 'e' || c == 'E' || c == 'p' || c == 'P'; }

    /// "<<<", which the preprocessor may have written with a blank in it.
    bool triple(char c) {
        if (text_[at_] != c || at_ + 1 >= text_.size() || text_[at_ + 1] != c) return false;
        std::size_t third = at_ + 2;
        while (third < text_.size() && text_[third] == ' ') ++third;
        if (third >= text_.size() || text_[third] != c) return false;
        at_ = third + 1;
        return true;
    }

    void quoted() {
        const char quote = text_[at_++];
        while (at_ < text_.size() && text_[at_] != quote) {
            at_ += text_[at_] == '\\' ? 2 : 1;
        }
        ++at_;
    }
    void raw_string() {
        const std::size_t open = text_.find('(', at_);
        if (open == std::string::npos) {
            at_ = text_.size();
            return;
        }
        const std::string close = ")" + text_.substr(at_ + 1, open - at_ - 1) + "\"";
        const std::size_t end = text_.find(close, open);
        at_ = end == std::string::npos ? text_.size() : end + close.size();
    }

    const std::string& text_;
    Tokens tokens_;
    std::size_t at_ = 0;
    int line_ = 1;
    int file_ = 0;
    bool system_ = false;
};

}  // namespace

Tokens read_tokens(const std::string& text) { return Reader(text).read(); }

}  // namespace scotty::verify
