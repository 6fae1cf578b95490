#include "verify/kernel_check/compile.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "reference/base/error.h"
#include "verify/kernel_check/programs.h"
#include "verify/kernel_check/translate.h"

namespace scotty::verify {

namespace {

using Words = std::vector<std::string>;
namespace fs = std::filesystem;

/// What the program's calls of the C library are turned to (emulation/cuda/hooks.cpp).
constexpr const char* kWrapped[] = {"memcpy", "memmove", "memset",  "malloc",
                                    "free",   "_Znwm",   "_Znam",   "_ZdlPv",
                                    "_ZdaPv", "_ZdlPvm", "_ZdaPvm", "__assert_fail"};

void replace_all(std::string& text, const std::string& from, const std::string& to) {
    for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos;) {
        text.replace(at, from.size(), to);
        at += to.size();
    }
}

void run_compiler(const Words& words, const std::string& what) {
    ProgramOptions options;
    options.keep_output = true;
    const ProgramRun ran = run_program(words, options);
    if (ran.exit_code == 127 && ran.output.empty()) {
        throw reference::Error::missing_environment(words.front() + " cannot be started");
    }
    if (ran.exit_code != 0) throw reference::Error::bad_input(what, "\n" + ran.output);
}

/// The line of a compiler's output that says "error".
std::string first_error(const std::string& output) {
    const std::size_t at = output.find("error: ");
    if (at == std::string::npos) return output;
    const std::size_t begin = output.rfind('\n', at) + 1;
    return output.substr(begin, output.find('\n', at) - begin);
}

}  // namespace

std::string text_of_file(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
}

void write_text(const fs::path& path, const std::string& text) {
    std::ofstream file(path, std::ios::binary);
    file << text;
    if (!file) throw reference::Error::bad_input(path.string(), "cannot be written");
}

namespace {

void compile_cuda_with(const CudaCompile& compile, CopiesOfRecords copies) {
    const std::string name = compile.shown_as.empty() ? compile.source : compile.shown_as;
    const std::string standard =
        "-std=gnu++" + compile.standard.substr(compile.standard.find_last_of('+') + 1);
    const std::string text_file = compile.object.string() + ".ii";
    const std::string cpp_file = compile.object.string() + ".cpp.ii";
    Words preprocess = {compile.compiler, "-E", "-x", "c++", standard, "-isystem",
                        (compile.executor / "include").string(), "-isystem",
                        (compile.executor / "include" / "scotty_cuda" / "forward").string(),
                        // capture_writer.h, if nothing else is of that name
                        "-idirafter",
                        (compile.executor.parent_path().parent_path() / "include").string(),
                        "-include", "scotty_cuda/cuda.h"};
    if (copies == CopiesOfRecords::unseen) preprocess.push_back("-DSCOTTY_PLAIN_RECORDS");
    preprocess.insert(preprocess.end(), compile.options.begin(), compile.options.end());
    if (!compile.dependencies.empty()) {
        preprocess.insert(preprocess.end(), {"-MD", "-MF", compile.dependencies.string(), "-MT",
                                             compile.object.string()});
    }
    preprocess.insert(preprocess.end(), {"-o", text_file, compile.source});
    run_compiler(preprocess, name + " is not preprocessed");
    std::string text = text_of_file(text_file);
    if (name != compile.source) {
        // Lines shall name the file as the user did.
        replace_all(text, "\"" + fs::absolute(name).string() + "\"", "\"" + name + "\"");
    }
    write_text(cpp_file, translate_cuda(text, copies));
    run_compiler(
        {compile.compiler, "-x", "c++-cpp-output", standard, "-w", "-fpermissive", "-O0", "-g",
         "-fno-omit-frame-pointer", "-fsanitize=thread", "--param", "tsan-distinguish-volatile=1",
         "-fdebug-prefix-map=" + fs::current_path().string() + "=.", "-c", "-o",
         compile.object.string(), cpp_file},
        name + " does not compile");
}

}  // namespace

void compile_cuda(const CudaCompile& compile) {
    std::string why;
    try {
        compile_cuda_with(compile, CopiesOfRecords::seen);
        return;
    } catch (const reference::Error& error) {
        if (error.kind() != reference::ErrorKind::bad_input) throw;
        why = error.what();
    }
    compile_cuda_with(compile, CopiesOfRecords::unseen);  // its error is the program's own
    std::fprintf(stderr,
                 "%s: warning: records that are arguments or results of functions are copied "
                 "unseen, because the program needs them to be plain (docs/cuda-support.md):\n%s\n",
                 compile.source.c_str(), first_error(why).c_str());
}

Words link_options_of_kernels(const fs::path& executor) {
    Words options;
    for (const char* const name : kWrapped) options.push_back(std::string("-Wl,--wrap=") + name);
    options.push_back((executor / "libscotty-kernels.so").string());
    options.push_back("-Wl,-rpath," + executor.string());
    return options;
}

std::string find_compiler(const std::string& asked) {
    if (!asked.empty()) {
        if (find_program(asked).empty()) {
            throw reference::Error::missing_environment("there is no compiler '" + asked + "'");
        }
        return asked;
    }
    const char* const wanted = std::getenv("CXX");
    for (const char* const name : {wanted == nullptr ? "" : wanted, "g++", "c++"}) {
        if (*name != '\0' && !find_program(name).empty()) return name;
    }
    throw reference::Error::missing_environment(
        "scotty check compiles with the host's C++ compiler, and there is none: neither $CXX nor "
        "g++ or c++ (on Debian: apt install g++)");
}

}  // namespace scotty::verify
