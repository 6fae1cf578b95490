/// libFuzzer's entry points. SCOTTY_READER chooses the reader, by its name in readers.h.
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>

#include "tests/fuzz/readers.h"

namespace {

namespace fs = std::filesystem;

const scotty::tests::Reader* chosen = nullptr;
fs::path folder;

void remove_folder() {
    std::error_code ignored;
    fs::remove_all(folder, ignored);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
#ifdef SCOTTY_FUZZ_COMMAND_LINE
    static const std::vector<scotty::tests::Reader> readers{
        {"command_line", scotty::tests::read_command_line}};
#elif defined(SCOTTY_FUZZ_VIEW)
    const auto& readers = scotty::tests::view_readers();
#else
    const auto& readers = scotty::tests::file_readers();
#endif
    const char* name = std::getenv("SCOTTY_READER");
    for (const auto& reader : readers) {
        if (name != nullptr && std::strcmp(name, reader.name) == 0) chosen = &reader;
    }
    if (chosen == nullptr) {
        std::fprintf(stderr, "SCOTTY_READER has to be one of:");
        for (const auto& reader : readers) std::fprintf(stderr, " %s", reader.name);
        std::fprintf(stderr, "\n");
        std::exit(2);
    }
    // Uses memory if there is such a place, because every input is a file.
    const fs::path place = fs::exists("/dev/shm") ? "/dev/shm" : fs::temp_directory_path();
    folder = place / ("scotty_fuzz_" + std::to_string(getpid()));
    fs::create_directories(folder);
    std::atexit(remove_folder);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    try {
        scotty::tests::try_reader(*chosen, folder, {reinterpret_cast<const char*>(data), size});
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        std::abort();
    }
    return 0;
}
