/// CUDA's atomic functions, of all types and scopes. One host thread runs all CUDA threads, so that
/// a plain read and write in between two announcements are atomic.
// NOLINTBEGIN
#pragma once

#include "interface.h"
#include "warp.h"

namespace scotty_cuda {

template <class T, class Change>
SCOTTY_UNSEEN T change(T* address, Scope scope, const void* place, const Change& next) {
    atomic_begins(const_cast<void*>(static_cast<const volatile void*>(address)), sizeof(T), true,
                  true, scope, Order::relaxed, place);
    T before;
    __builtin_memcpy(&before, address, sizeof before);
    T after = next(before);
    const bool changed = __builtin_memcmp(&before, &after, sizeof before) != 0;
    __builtin_memcpy(address, &after, sizeof after);
    atomic_ends(changed);
    return before;
}

}  // namespace scotty_cuda

#define SCOTTY_ATOMIC_IN(name, T, expression, scope)                                             \
    SCOTTY_CALL T name(T* address, T value) {                                                    \
        return scotty_cuda::change<T>(address, scotty_cuda::Scope::scope, SCOTTY_HERE,           \
                                      [value](T old) SCOTTY_UNSEEN -> T { return expression; }); \
    }
#define SCOTTY_ATOMIC(name, T, expression)               \
    SCOTTY_ATOMIC_IN(name, T, expression, device)        \
    SCOTTY_ATOMIC_IN(name##_block, T, expression, block) \
    SCOTTY_ATOMIC_IN(name##_system, T, expression, system)

#define SCOTTY_ATOMIC_INTEGERS(name, expression)  \
    SCOTTY_ATOMIC(name, int, expression)          \
    SCOTTY_ATOMIC(name, unsigned int, expression) \
    SCOTTY_ATOMIC(name, unsigned long long, expression)

SCOTTY_ATOMIC_INTEGERS(atomicAdd, old + value)
SCOTTY_ATOMIC(atomicAdd, float, old + value)
SCOTTY_ATOMIC(atomicAdd, double, old + value)
SCOTTY_ATOMIC(atomicSub, int, old - value)
SCOTTY_ATOMIC(atomicSub, unsigned int, old - value)
SCOTTY_ATOMIC_INTEGERS(atomicExch, value)
SCOTTY_ATOMIC(atomicExch, float, value)
SCOTTY_ATOMIC_INTEGERS(atomicMin, value < old ? value : old)
SCOTTY_ATOMIC(atomicMin, long long, value < old ? value : old)
SCOTTY_ATOMIC_INTEGERS(atomicMax, value > old ? value : old)
SCOTTY_ATOMIC(atomicMax, long long, value > old ? value : old)
SCOTTY_ATOMIC_INTEGERS(atomicAnd, old& value)
SCOTTY_ATOMIC_INTEGERS(atomicOr, old | value)
SCOTTY_ATOMIC_INTEGERS(atomicXor, old ^ value)
SCOTTY_ATOMIC(atomicInc, unsigned int, old >= value ? 0u : old + 1u)
SCOTTY_ATOMIC(atomicDec, unsigned int, old == 0u || old > value ? value : old - 1u)
#undef SCOTTY_ATOMIC_INTEGERS
#undef SCOTTY_ATOMIC
#undef SCOTTY_ATOMIC_IN

#define SCOTTY_CAS_IN(name, T, scope)                                                             \
    SCOTTY_CALL T name(T* address, T compare, T value) {                                          \
        return scotty_cuda::change<T>(                                                            \
            address, scotty_cuda::Scope::scope, SCOTTY_HERE,                                      \
            [compare, value](T old) SCOTTY_UNSEEN -> T { return old == compare ? value : old; }); \
    }
#define SCOTTY_CAS(T)                        \
    SCOTTY_CAS_IN(atomicCAS, T, device)      \
    SCOTTY_CAS_IN(atomicCAS_block, T, block) \
    SCOTTY_CAS_IN(atomicCAS_system, T, system)
SCOTTY_CAS(int)
SCOTTY_CAS(unsigned int)
SCOTTY_CAS(unsigned long long)
SCOTTY_CAS(unsigned short)
#undef SCOTTY_CAS
#undef SCOTTY_CAS_IN
// NOLINTEND
