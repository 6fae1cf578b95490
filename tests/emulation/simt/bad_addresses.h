/// For tests in which a kernel reaches memory that is not there.
#pragma once

#include <csignal>
#include <cstdint>

namespace scotty::simt::test {

/// There is no such memory: nothing is mapped so low.
inline std::uint32_t* nowhere() { return reinterpret_cast<std::uint32_t*>(64); }

/// As outside tests: Catch (and a sanitizer) must not answer signals first.
class NobodyAnswersSignals {
 public:
    NobodyAnswersSignals() {
        struct sigaction nobody {};
        nobody.sa_handler = SIG_DFL;
        ::sigaction(SIGSEGV, &nobody, &before_);
    }
    ~NobodyAnswersSignals() { ::sigaction(SIGSEGV, &before_, nullptr); }
    NobodyAnswersSignals(const NobodyAnswersSignals&) = delete;
    NobodyAnswersSignals& operator=(const NobodyAnswersSignals&) = delete;

 private:
    struct sigaction before_ {};
};

}  // namespace scotty::simt::test
