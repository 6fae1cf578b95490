// Launches that a device refuses.
#include "corpus.h"

__global__ void nothing() {}

// [launch failed] more threads than a block has
void many_threads() { nothing<<<1, 1025>>>(); }

// [clean] as many as a block has
void most_threads() { nothing<<<1, 1024>>>(); }

// [launch failed] no block
void no_block() { nothing<<<0, 32>>>(); }

// [clean] one block
void one_block() { nothing<<<1, 32>>>(); }

// [launch failed] too large in z
void deep() { nothing<<<1, dim3(1, 1, 65)>>>(); }

// [clean] as large as possible in z
void deepest() { nothing<<<1, dim3(1, 1, 64)>>>(); }

// [launch failed] too much shared memory
void much_shared() { nothing<<<1, 1, 1 << 20>>>(); }

// [clean] some
void some_shared() { nothing<<<1, 1, 1 << 10>>>(); }

// [main]
int main() {
    RUN(many_threads());
    RUN(most_threads());
    RUN(no_block());
    RUN(one_block());
    RUN(deep());
    RUN(deepest());
    RUN(much_shared());
    RUN(some_shared());
}
