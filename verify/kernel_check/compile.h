/// From CUDA text to an instrumented object, with the host's C++ compiler. It is the whole of
/// scotty-cuda-cxx too, so that it needs nothing but that compiler.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace scotty::verify {

struct CudaCompile {
    std::string compiler;
    std::filesystem::path executor;    ///< has include/ and libscotty-kernels.so
    std::string standard = "c++17";    ///< or gnu++17, c++20, ...
    std::vector<std::string> options;  ///< for the preprocessor: -I..., -D..., ...
    std::string source;
    std::string shown_as;  ///< what its lines are called; empty: `source`
    std::filesystem::path object;
    std::filesystem::path dependencies;  ///< a file of rules for make or ninja; empty: none
};
/// Preprocesses, translates, compiles; leaves two files of text beside the object. Throws bad_input
/// with the compiler's words, missing_environment where it cannot be started.
void compile_cuda(const CudaCompile& compile);

/// The linker's options for a program of such objects: calls that the executor has to see, and the
/// executor itself.
std::vector<std::string> link_options_of_kernels(const std::filesystem::path& executor);

/// Empty where the file cannot be read.
std::string text_of_file(const std::filesystem::path& path);
/// Throws bad_input where the file cannot be written.
void write_text(const std::filesystem::path& path, const std::string& text);

/// `asked`, or $CXX, or g++ or c++. Throws missing_environment where there is none.
std::string find_compiler(const std::string& asked);

}  // namespace scotty::verify
