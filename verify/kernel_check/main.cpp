/// scotty-cuda-cxx: compiles one file of CUDA text for the executor of emulation/cuda/. What
/// scotty_add_kernel_program() calls; it lies beside the executor.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "reference/base/error.h"
#include "verify/kernel_check/compile.h"

namespace {

int run(int count, char** words) {
    scotty::verify::CudaCompile compile;
    compile.executor = std::filesystem::read_symlink("/proc/self/exe").parent_path();
    for (int i = 1; i < count; ++i) {
        const std::string word = words[i];
        const bool has_value = i + 1 < count;
        if (word == "-c" && has_value) {
            compile.source = words[++i];
        } else if (word == "-o" && has_value) {
            compile.object = words[++i];
        } else if (word == "-MF" && has_value) {
            compile.dependencies = words[++i];
        } else if (word == "--compiler" && has_value) {
            compile.compiler = words[++i];
        } else if (word.starts_with("-std=")) {
            compile.standard = word.substr(5);
        } else {
            compile.options.push_back(word);
        }
    }
    if (compile.source.empty() || compile.object.empty()) {
        throw scotty::reference::Error::bad_input(
            "scotty-cuda-cxx", "expected -c SOURCE -o OBJECT, found " + std::to_string(count - 1) +
                                   " words without them");
    }
    compile.compiler = scotty::verify::find_compiler(compile.compiler);
    scotty::verify::compile_cuda(compile);
    return 0;
}

}  // namespace

int main(int count, char** words) {
    try {
        return run(count, words);
    } catch (const scotty::reference::Error& error) {
        std::fprintf(stderr, "scotty-cuda-cxx: %s\n", error.what());
        return error.kind() == scotty::reference::ErrorKind::missing_environment ? 3 : 2;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "scotty-cuda-cxx: %s\n", error.what());
        return 70;
    }
}
