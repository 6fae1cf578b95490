/// Makes plain C++ of CUDA text: launches, shared and device variables, and the words before
/// functions. Everything else is what the headers of emulation/cuda/ make of it.
#pragma once

#include <string>

namespace scotty::verify {

/// Whether loads and stores are seen where a record is an argument or what a function gives. Some
/// programs cannot be compiled with what makes them seen (scotty_cuda/copies.h).
enum class CopiesOfRecords : bool { unseen, seen };

/// Takes preprocessed CUDA text and returns preprocessed C++ text with the same lines. Throws
/// bad_input, naming file, line and word, for what is not supported (docs/cuda-support.md).
std::string translate_cuda(const std::string& text, CopiesOfRecords copies = CopiesOfRecords::seen);

}  // namespace scotty::verify
