// --launch 'kernel<<<grid, block>>>(float[1024], 7)': a main() for a file that has none.
#include <fmt/format.h>

#include <cctype>
#include <vector>

#include "reference/base/error.h"
#include "verify/kernel_check/kernel_check.h"

namespace scotty::verify {

namespace {

/// The arguments of a call, separated by the commas that are in no bracket.
std::vector<std::string> split_arguments(const std::string& text) {
    std::vector<std::string> out;
    int depth = 0;
    std::string one;
    for (const char c : text) {
        if (c == '(' || c == '[' || c == '{' || c == '<') ++depth;
        if (c == ')' || c == ']' || c == '}' || c == '>') --depth;
        if (c == ',' && depth == 0) {
            out.push_back(one);
            one.clear();
        } else {
            one += c;
        }
    }
    if (one.find_first_not_of(' ') != std::string::npos) out.push_back(one);
    return out;
}

std::string trimmed(const std::string& text) {
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == std::string::npos) return "";
    return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

}  // namespace

std::string main_of_launch(const std::string& launch) {
    const std::size_t config = launch.find(">>>");
    const std::size_t open = config == std::string::npos ? config : launch.find('(', config);
    const std::size_t close = launch.rfind(')');
    if (launch.find("<<<") == std::string::npos || open == std::string::npos ||
        close == std::string::npos || close < open) {
        throw reference::Error::bad_input(
            "--launch", "expected 'kernel<<<grid, block>>>(arguments)', found '" + launch + "'");
    }
    std::string text = "int main() {\n";
    std::string call;
    std::string frees;
    int number = 0;
    for (const std::string& raw : split_arguments(launch.substr(open + 1, close - open - 1))) {
        const std::string argument = trimmed(raw);
        const std::size_t bracket = argument.find('[');
        const bool is_array = bracket != std::string::npos && bracket > 0 &&
                              argument.back() == ']' &&
                              (std::isalpha(static_cast<unsigned char>(argument[0])) != 0);
        call += call.empty() ? "" : ", ";
        if (!is_array) {
            call += argument;
            continue;
        }
        const std::string type = trimmed(argument.substr(0, bracket));
        const std::string count = argument.substr(bracket + 1, argument.size() - bracket - 2);
        const std::string name = fmt::format("scotty_array_{}", number++);
        text += fmt::format("  {0}* {1} = ::scotty_cuda::filled<{0}>({2});\n", type, name, count);
        frees += fmt::format("  cudaFree({});\n", name);
        call += name;
    }
    return text + "  " + launch.substr(0, open) + "(" + call + ");\n  cudaDeviceSynchronize();\n" +
           frees + "  return 0;\n}\n";
}

}  // namespace scotty::verify
