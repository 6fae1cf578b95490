/// Everything that is said about options comes from one table, CLI11's: help, completions, the
/// manual page, and what somebody may have meant who mistyped.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

namespace scotty::verify {

/// What the table knows of one option or positional, in our words.
struct OptionWords {
    std::vector<std::string> names;  ///< "-o", "--output"; of a positional its one name
    std::string value;               ///< "FILE", "off|level|immediate", "N"; empty: a flag
    std::string help;                ///< with its range, its default and what it needs or excludes
    bool required = false;
    bool many = false;

    /// Where `value` lists words to choose from: "off", "level", "immediate".
    std::vector<std::string> choices() const;
};
OptionWords words_of(const CLI::Option& option);
/// Visible options, or positionals, in the order of the table.
std::vector<const CLI::Option*> options_of(const CLI::App& command, bool positional);

/// Help no wider than 80 columns, in those words.
std::shared_ptr<CLI::FormatterBase> help_formatter();

/// Of `known` the word that was most likely meant; empty: none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

/// "; did you mean --stage?" of a word that is no subcommand or no option of `command`; or empty.
std::string did_you_mean(const CLI::App& command, const std::string& word);

/// Text in lines of at most `columns`, each but the first indented by `indent`. Line breaks in the
/// text are kept, and lines that begin with a blank (examples) are left as they are.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t columns);

}  // namespace scotty::verify
