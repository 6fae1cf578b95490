#include <sys/resource.h>

#include <csignal>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "tests/catch.h"
#include "tests/temporary_folder.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using tests::slurp;
using tests::TemporaryFolder;

namespace {

/// No file may grow beyond so many bytes: what a full disk is like.
class NoRoom {
 public:
    explicit NoRoom(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limit{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limit);
    }
    ~NoRoom() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_);
    }
    NoRoom(const NoRoom&) = delete;
    NoRoom& operator=(const NoRoom&) = delete;

 private:
    void (*handler_)(int);
    rlimit before_{};
};

}  // namespace

TEST_CASE("write file: whole, in a folder that it makes", "[reference][write_file]") {
    const TemporaryFolder folder;
    reference::write_file(folder / "a/b/c.txt", "first");
    reference::write_file(folder / "a/b/c.txt", "second");
    CHECK(slurp(folder / "a/b/c.txt") == "second");
    CHECK_FALSE(std::filesystem::exists(folder / "a/b/c.txt.unfinished"));
}

TEST_CASE("write file: where there is no room the old file stays, and the reason is named",
          "[reference][write_file]") {
    const TemporaryFolder folder;
    const auto file = folder / "report.json";
    reference::write_file(file, "old");
    {
        const NoRoom limit(4096);
        CHECK_THROWS_WITH(reference::write_file(file, std::string(1 << 20, 'x')),
                          ContainsSubstring("report.json") &&
                              ContainsSubstring("cannot be written") &&
                              ContainsSubstring("File too large"));
    }
    CHECK(slurp(file) == "old");
    CHECK_FALSE(std::filesystem::exists(folder / "report.json.unfinished"));
}

TEST_CASE("write file: what a killed run left half-way is in nobody's way",
          "[reference][write_file]") {
    const TemporaryFolder folder;
    const auto file = folder / "report.json";
    reference::write_file(file, "old");
    tests::spill(folder / "report.json.unfinished", "hal");
    CHECK(slurp(file) == "old");
    reference::write_file(file, "new");
    CHECK(slurp(file) == "new");
}

TEST_CASE("write file: a place that takes no files is an error with the system's reason",
          "[reference][write_file]") {
    CHECK_THROWS_WITH(reference::write_file("/proc/scotty.json", "x"),
                      ContainsSubstring("/proc/scotty.json: cannot be written: "));
}
