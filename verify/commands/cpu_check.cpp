/// Compiled into every program, without -march=native: where the programs were built for another
/// CPU (SCOTTY_NATIVE), they say so instead of dying of an instruction that is not there.
#include <unistd.h>

#include <cstdio>

#if defined(SCOTTY_CPU_NEEDS) && defined(__x86_64__)

namespace {

void expect(int supported, const char* name) {
    if (supported != 0) return;
    std::fprintf(stderr,
                 "scotty: error: this program was built for another CPU (-march=native): this one "
                 "has no %s; ./run builds it for this machine, cmake --preset package for all\n",
                 name);
    _exit(3);
}

/// Before any constructor of ours runs.
__attribute__((constructor(101))) void check_cpu() {
    __builtin_cpu_init();
#define SCOTTY_CPU_NEED(name) expect(__builtin_cpu_supports(#name), #name);
    SCOTTY_CPU_NEEDS
#undef SCOTTY_CPU_NEED
}

}  // namespace

#endif
