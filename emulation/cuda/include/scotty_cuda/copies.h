/// Copies of records as the compiler's functions. Where a record is passed by value, or is what a
/// function gives, a plain copy of its bytes is part of the call, and -fsanitize=thread announces
/// neither its loads nor its stores. With a last member of this type the copy is a function of its
/// own, whose accesses are announced one by one.
#pragma once

#include "interface.h"

namespace scotty_cuda {

/// Takes no room, and says after each copy that the loads before it were one.
template <class Record>
struct Copied {
    Copied() = default;
    __attribute__((no_sanitize_thread)) constexpr Copied(const Copied& from) noexcept {
        if (!__builtin_is_constant_evaluated()) {
            record_copied(this, &from, sizeof(Record), alignof(Record));
        }
    }
    __attribute__((no_sanitize_thread)) constexpr Copied& operator=(const Copied& from) noexcept {
        if (!__builtin_is_constant_evaluated()) {
            record_copied(this, &from, sizeof(Record), alignof(Record));
        }
        return *this;
    }
};

}  // namespace scotty_cuda

// A program that the member breaks (it unites records, say) is compiled without.
#ifdef SCOTTY_PLAIN_RECORDS
#define SCOTTY_COPIED(record)
#else
#define SCOTTY_COPIED(record) [[no_unique_address]] ::scotty_cuda::Copied<record> scotty_copied;
#endif
