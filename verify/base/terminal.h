/// What a person sees: how wide their terminal is, and whether they want colours and progress.
#pragma once

#include <cstddef>
#include <string>

namespace scotty::verify {

enum class ColorChoice { automatic, always, never };

/// --color. `automatic` is a terminal, and neither NO_COLOR (no-color.org) nor TERM=dumb.
void set_color_choice(ColorChoice choice);
/// "auto", "always" or "never". Throws bad_input.
ColorChoice parse_color_choice(const std::string& word);
/// Whether what is written to a file descriptor is coloured.
bool has_color(int descriptor);

/// -q: no progress and no remarks, only results, warnings and errors.
void set_quiet(bool quiet);
bool is_quiet();

/// Columns of the terminal behind a descriptor, as it is now; COLUMNS or 80 where it does not say.
std::size_t terminal_columns(int descriptor);

/// The text up to so many columns, each character of UTF-8 counted as one. What is cut ends in "~".
std::string cut_to(const std::string& text, std::size_t columns);

/// The words passed, FAILED, STOPPED, caught, ESCAPED and GONE in colours, where they stand alone.
std::string colored_verdicts(const std::string& text);

}  // namespace scotty::verify
