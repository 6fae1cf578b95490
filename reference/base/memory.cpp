#include "reference/base/memory.h"

#include <fmt/format.h>
#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "reference/base/error.h"

namespace scotty::reference {

namespace {

constexpr std::uint64_t kUnlimited = std::numeric_limits<std::uint64_t>::max();

/// The number in a file that holds one; `otherwise` where there is no such file or another word.
std::uint64_t number_in(const char* file, std::uint64_t otherwise) {
    std::ifstream in(file);
    std::uint64_t number = 0;
    return in >> number ? number : otherwise;
}

std::uint64_t left(std::uint64_t limit, std::uint64_t used) {
    return limit == kUnlimited ? kUnlimited : limit - std::min(limit, used);
}

std::uint64_t free_of_system() {
    std::ifstream in("/proc/meminfo");
    for (std::string word; in >> word;) {
        std::uint64_t kib = 0;
        if (word == "MemAvailable:" && in >> kib) return kib * 1024;
    }
    return kUnlimited;
}

std::uint64_t free_of_group() {
    return left(number_in("/sys/fs/cgroup/memory.max", kUnlimited),
                number_in("/sys/fs/cgroup/memory.current", 0));
}

std::uint64_t free_of_ulimit() {
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnlimited;
    const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    return left(limit.rlim_cur, number_in("/proc/self/statm", 0) * page);
}

std::string in_words(std::uint64_t bytes) {
    constexpr double kMiB = 1024.0 * 1024.0;
    const double mib = static_cast<double>(bytes) / kMiB;
    return mib < 1024.0 ? fmt::format("{:.0f} MiB", mib) : fmt::format("{:.1f} GiB", mib / 1024.0);
}

}  // namespace

std::uint64_t available_memory() {
    return std::min({free_of_system(), free_of_group(), free_of_ulimit()});
}

void require_memory(std::uint64_t bytes, const std::string& what, const std::string& way_out) {
    const std::uint64_t available = available_memory();
    if (bytes <= available) return;
    throw Error::missing_environment(fmt::format("{} needs about {} of memory, {} are free; {}",
                                                 what, in_words(bytes), in_words(available),
                                                 way_out));
}

void keep_freed_memory() {
#if defined(__GLIBC__)
    constexpr int kLargest = 32 << 20;  // glibc's own limit
    mallopt(M_MMAP_THRESHOLD, kLargest);
    mallopt(M_TRIM_THRESHOLD, 512 << 20);
#endif
}

}  // namespace scotty::reference
