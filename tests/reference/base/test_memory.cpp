#include <sys/resource.h>

#include <fstream>

#include "reference/base/error.h"
#include "reference/base/memory.h"
#include "tests/catch.h"

using namespace scotty::reference;
using Catch::Matchers::ContainsSubstring;

namespace {

/// What `ulimit -v` does, to so many bytes more than there are now.
class Ulimit {
 public:
    explicit Ulimit(std::uint64_t more) {
        std::uint64_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        getrlimit(RLIMIT_AS, &before_);
        const rlimit limit{pages * 4096 + more, before_.rlim_max};
        setrlimit(RLIMIT_AS, &limit);
    }
    ~Ulimit() { setrlimit(RLIMIT_AS, &before_); }
    Ulimit(const Ulimit&) = delete;
    Ulimit& operator=(const Ulimit&) = delete;

 private:
    rlimit before_{};
};

constexpr std::uint64_t kMiB = 1 << 20;

}  // namespace

TEST_CASE("memory: there is some, and less under a ulimit", "[reference][memory]") {
    CHECK(available_memory() > kMiB);
    const Ulimit limit(64 * kMiB);
    CHECK(available_memory() <= 64 * kMiB);
}

TEST_CASE("memory: what would not fit is refused with what it needs, what there is, and a way out",
          "[reference][memory]") {
    CHECK_NOTHROW(require_memory(kMiB, "a picture", "a smaller one"));
    CHECK_THROWS_WITH(require_memory(std::uint64_t{1} << 60, "a picture", "a smaller one"),
                      ContainsSubstring("a picture needs about 1073741824.0 GiB of memory") &&
                          ContainsSubstring("are free; a smaller one"));
    const Ulimit limit(64 * kMiB);
    try {
        require_memory(128 * kMiB, "a picture", "a smaller one");
        FAIL("nothing was thrown");
    } catch (const Error& error) {
        CHECK(error.kind() == ErrorKind::missing_environment);
        CHECK_THAT(error.what(), ContainsSubstring("needs about 128 MiB of memory"));
    }
}
