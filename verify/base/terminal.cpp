#include "verify/base/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cctype>
#include <cstdlib>
#include <string_view>
#include <utility>

#include "reference/base/error.h"

namespace scotty::verify {

namespace {

ColorChoice color_choice = ColorChoice::automatic;
bool quiet_asked = false;

bool is_set(const char* variable) {
    const char* value = std::getenv(variable);
    return value != nullptr && *value != '\0';
}

bool is_word(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
}

constexpr std::string_view kRed = "\x1b[1;31m";
constexpr std::string_view kGreen = "\x1b[32m";
constexpr std::string_view kPlain = "\x1b[0m";
constexpr std::pair<std::string_view, std::string_view> kVerdicts[] = {
    {"passed", kGreen}, {"caught", kGreen}, {"FAILED", kRed},
    {"STOPPED", kRed},  {"ESCAPED", kRed},  {"GONE", kRed}};

}  // namespace

void set_color_choice(ColorChoice choice) { color_choice = choice; }

ColorChoice parse_color_choice(const std::string& word) {
    if (word == "auto") return ColorChoice::automatic;
    if (word == "always") return ColorChoice::always;
    if (word == "never") return ColorChoice::never;
    throw reference::Error::bad_input(
        "--color", fmt::format("expected auto, always or never, found '{}'", word));
}

bool has_color(int descriptor) {
    if (color_choice != ColorChoice::automatic) return color_choice == ColorChoice::always;
    const char* kind = std::getenv("TERM");
    const bool dumb = kind != nullptr && std::string_view(kind) == "dumb";
    return isatty(descriptor) == 1 && !is_set("NO_COLOR") && !dumb;
}

void set_quiet(bool quiet) { quiet_asked = quiet; }
bool is_quiet() { return quiet_asked; }

std::size_t terminal_columns(int descriptor) {
    winsize size{};
    if (ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
    if (const char* columns = std::getenv("COLUMNS")) {
        const long value = std::strtol(columns, nullptr, 10);
        if (value > 0) return static_cast<std::size_t>(value);
    }
    return 80;
}

std::string cut_to(const std::string& text, std::size_t columns) {
    std::size_t seen = 0;
    std::size_t before_last = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if ((static_cast<unsigned char>(text[i]) & 0xc0u) == 0x80u) continue;  // of the one before
        if (seen == columns) return columns == 0 ? "" : text.substr(0, before_last) + "~";
        before_last = i;
        ++seen;
    }
    return text;
}

std::string colored_verdicts(const std::string& text) {
    std::string out;
    for (std::size_t i = 0; i < text.size();) {
        std::size_t taken = 0;
        if (i == 0 || !is_word(text[i - 1])) {
            for (const auto& [word, color] : kVerdicts) {
                if (text.compare(i, word.size(), word) != 0) continue;
                const std::size_t end = i + word.size();
                if (end < text.size() && is_word(text[end])) continue;
                out.append(color).append(word).append(kPlain);
                taken = word.size();
            }
        }
        if (taken == 0) out += text[i];
        i += taken == 0 ? 1 : taken;
    }
    return out;
}

}  // namespace scotty::verify
