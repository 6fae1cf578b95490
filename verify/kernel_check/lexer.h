/// Tokens of preprocessed C++ text, each with its place in the user's file.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace scotty::verify {

enum class TokenKind : unsigned char { identifier, number, text, punctuation };

struct Token {
    TokenKind kind = TokenKind::punctuation;
    std::string_view spelling;
    std::size_t begin = 0;  ///< offset in the whole text
    std::size_t end = 0;
    int file = 0;  ///< index in Tokens::files
    int line = 0;
    bool system = false;  ///< in a header of the system, which is not translated

    bool is(std::string_view word) const { return spelling == word; }
};

struct Tokens {
    std::vector<Token> all;
    std::vector<std::string> files;
};

/// Reads what `g++ -E` writes: line markers say where the text comes from. The tokens refer to
/// `text`. Punctuation is one character each, but for "::", "->", "<<<" and ">>>".
Tokens read_tokens(const std::string& text);

}  // namespace scotty::verify
