/// Completions for shells and the manual page, made from the table of options.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace scotty::verify {

/// A script for "bash", "zsh" or "fish" that completes subcommands, options, the words that an
/// option chooses from, and the names of built-in scenes where a scene is asked for. Throws
/// bad_input.
std::string completion(const CLI::App& app, const std::string& shell,
                       const std::vector<std::string>& scenes);

/// scotty(1), in the man macros.
std::string manual_page(const CLI::App& app, const std::string& version);

}  // namespace scotty::verify
