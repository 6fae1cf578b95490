/// Where results go is looked at while the command line is read: minutes of work are not lost to a
/// folder that is not there.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace scotty::verify {

/// Why a file cannot be written there: its folder does not exist or may not be written, or it is a
/// folder itself. Empty: it can. "-" is standard output, and always can.
std::string why_not_writable(const std::string& file);

/// The same as a check of an option, for files and for folders that are made or filled.
CLI::Validator output_file();
CLI::Validator output_folder();

}  // namespace scotty::verify
