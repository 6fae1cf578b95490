/// The fuzzed code: every reader of outside data, as a function of bytes.
///
/// A reader takes the bytes as a file of its kind. It may accept them, or refuse them with
/// reference::Error of kind bad_input; anything else is a fault. One list serves the fuzzer
/// (fuzz.cpp), which looks for new bytes, and the tests (test_corpus.cpp), which run the corpus and
/// changes of it.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace scotty::tests {

struct Reader {
    const char* name;  ///< the name of its folder in corpus/
    /// `folder` exists and takes the file. Throws what the reader throws.
    void (*read)(const std::filesystem::path& folder, std::string_view bytes);
};

/// The readers of files; the command line's needs all of scotty: command_line_reader.cpp.
const std::vector<Reader>& file_readers();

/// Of what a client sends to `scotty view`: view_readers.cpp.
const std::vector<Reader>& view_readers();

/// Reads bytes as arguments, one per line. They are parsed, and not carried out.
void read_command_line(const std::filesystem::path& folder, std::string_view bytes);

/// Returns false if the bytes were refused. Throws std::logic_error saying what was thrown instead
/// of a refusal.
bool try_reader(const Reader& reader, const std::filesystem::path& folder, std::string_view bytes);

}  // namespace scotty::tests
