/// Everything that reads what somebody else wrote, as functions of bytes: what is fuzzed.
///
/// A reader takes the bytes as a file of its kind. It may accept them, or refuse them with
/// reference::Error of kind bad_input; whatever else happens is a fault. So one list serves the
/// fuzzer (fuzz.cpp), which looks for new bytes, and the tests (test_corpus.cpp), which hold those
/// of corpus/ and changes of them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace scotty::tests {

struct Reader {
    const char* name;  ///< of its folder in corpus/
    /// `folder`: an existing one for the file. Throws what the reader throws.
    void (*read)(const std::filesystem::path& folder, std::string_view bytes);
};

/// Those of files; the command line's is in command_line_reader.cpp, as it needs all of scotty.
const std::vector<Reader>& file_readers();

/// Bytes as arguments, one a line. Parsed, and not carried out.
void read_command_line(const std::filesystem::path& folder, std::string_view bytes);

/// False where the bytes were refused. Throws std::logic_error saying what was thrown instead of a
/// refusal.
bool try_reader(const Reader& reader, const std::filesystem::path& folder, std::string_view bytes);

}  // namespace scotty::tests
