/// What a translated launch calls: kernel<<<grid, block, bytes, stream>>>(arguments).
#pragma once

#include <tuple>
#include <type_traits>
#include <utility>

#include "interface.h"
#include "vector_types.h"

#define SCOTTY_UNSEEN __attribute__((no_sanitize_thread))

namespace scotty_cuda {

struct RegisterBuiltins {
    RegisterBuiltins() { register_builtins(&threadIdx, &blockIdx, &blockDim, &gridDim); }
};
inline RegisterBuiltins register_builtins_now;

struct Config {
    __attribute__((noinline))
    Config(dim3 grid_size, dim3 block_size, size_t bytes = 0, void* in_stream = nullptr)
        : grid(grid_size),
          block(block_size),
          dynamic_shared(bytes),
          stream(in_stream),
          place(__builtin_return_address(0)) {}
    dim3 grid;
    dim3 block;
    size_t dynamic_shared;
    void* stream;
    const void* place;
};

SCOTTY_UNSEEN inline LaunchInfo info_of(const char* kernel, const Config& config) {
    LaunchInfo info;
    info.kernel = kernel;
    info.grid = {config.grid.x, config.grid.y, config.grid.z};
    info.block = {config.block.x, config.block.y, config.block.z};
    info.dynamic_shared = config.dynamic_shared;
    info.stream = config.stream;
    info.place = config.place;
    return info;
}

/// Calls the kernel with a copy of the arguments in each thread, as CUDA does.
template <class Kernel, class Arguments>
struct Call {
    Kernel kernel;
    Arguments arguments;

    template <size_t... I>
    SCOTTY_UNSEEN void run(std::index_sequence<I...>) const {
        hear_accesses(false);  // they are the host's, and CUDA's to copy
        Arguments copy = arguments;
        hear_accesses(true);
        kernel(static_cast<std::tuple_element_t<I, Arguments>&&>(std::get<I>(copy))...);
    }
    SCOTTY_UNSEEN static void thread(void* memory) {
        static_cast<const Call*>(memory)->run(
            std::make_index_sequence<std::tuple_size<Arguments>::value>());
    }
};

/// A launch of a kernel whose parameters are known: arguments convert as in a call.
template <class... Parameters>
struct Launcher {
    const char* name;
    Config config;
    void (*kernel)(Parameters...);

    void operator()(std::remove_cv_t<Parameters>... arguments) const {
        using Arguments = std::tuple<std::remove_cv_t<Parameters>...>;
        Call<void (*)(Parameters...), Arguments> call{kernel, Arguments(arguments...)};
        launch(info_of(name, config), &decltype(call)::thread, &call);
    }
};
template <class... Parameters>
Launcher<Parameters...> launcher(const char* name, void (*kernel)(Parameters...),
                                 const Config& config) {
    return {name, config, kernel};
}

/// A launch of a template, which the call itself resolves; `kernel` is a generic lambda.
template <class Kernel>
struct GenericLauncher {
    const char* name;
    Config config;
    Kernel kernel;

    template <class... Arguments>
    void operator()(Arguments... arguments) const {
        Call<Kernel, std::tuple<Arguments...>> call{kernel, std::tuple<Arguments...>(arguments...)};
        launch(info_of(name, config), &decltype(call)::thread, &call);
    }
};
template <class Kernel>
GenericLauncher<Kernel> generic_launcher(const char* name, Kernel kernel, const Config& config) {
    return {name, config, kernel};
}

/// `extern __shared__ T name[]` outside of functions.
template <class T>
struct DynamicShared {
    SCOTTY_UNSEEN operator T*() const { return static_cast<T*>(dynamic_shared()); }
    template <class U>
    SCOTTY_UNSEEN explicit operator U*() const {
        return static_cast<U*>(dynamic_shared());
    }
    template <class Index>
    SCOTTY_UNSEEN T& operator[](Index index) const {
        return static_cast<T*>(dynamic_shared())[index];
    }
    template <class Index>
    SCOTTY_UNSEEN T* operator+(Index index) const {
        return static_cast<T*>(dynamic_shared()) + index;
    }
};

/// A shared object: `T& name = shared<T>(site, "name")`.
template <class T>
SCOTTY_UNSEEN T& shared(const void* site, const char* name) {
    return *static_cast<T*>(shared_object(site, name, sizeof(T), alignof(T)));
}

}  // namespace scotty_cuda
