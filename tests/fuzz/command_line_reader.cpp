#include <sstream>
#include <variant>

#include "reference/base/error.h"
#include "tests/fuzz/readers.h"
#include "verify/commands/command.h"

namespace scotty::tests {

void read_command_line(const std::filesystem::path&, std::string_view bytes) {
    std::vector<std::string> words{"scotty"};
    std::istringstream lines{std::string(bytes)};
    for (std::string word; std::getline(lines, word);)
        words.push_back(word.c_str());  // no zeros in it
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    const auto read =
        verify::read_command_line(static_cast<int>(arguments.size()), arguments.data());
    const int* code = std::get_if<int>(&read);
    if (code != nullptr && *code != verify::kExitPassed) {
        throw reference::Error::bad_input("command line", "refused");
    }
}

}  // namespace scotty::tests
