#include "verify/base/ask.h"

#include <cstdio>
#include <memory>
#include <sstream>

namespace scotty::verify {

std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string text;
    if (!pipe) return text;
    char piece[4096];
    while (const std::size_t got = std::fread(piece, 1, sizeof piece, pipe.get())) {
        text.append(piece, got);
    }
    return text;
}

std::string ask(const std::string& command) {
    std::istringstream lines(output_of(command + " 2>/dev/null"));
    std::string last;
    for (std::string line; std::getline(lines, line);) {
        while (!line.empty() && line.back() == ' ') line.pop_back();
        if (!line.empty()) last = line;
    }
    return last;
}

std::string shell_word(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

}  // namespace scotty::verify
