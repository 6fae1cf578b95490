/// --backend cuda is another program: an edit of a kernel does not wait for it.
#include <filesystem>
#include <string>

#include "tests/catch.h"
#include "tests/verify/command_tools.h"
#include "verify/base/exit_code.h"

namespace {

using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
using scotty::verify::kExitMissingEnvironment;
namespace fs = std::filesystem;

constexpr const char* kOnDevice = "verify furnace --backend cuda --quick";

TEST_CASE("cuda: scotty goes on as scotty-cuda, or says that it is not there", "[verify][cli]") {
    const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
    if (fs::exists(here / "scotty-cuda") && !fs::exists("/dev/nvidia0")) {
        const Result none = run_scotty(kOnDevice);
        CHECK(none.exit_code == kExitMissingEnvironment);
        CHECK_THAT(none.err, ContainsSubstring("no CUDA device"));
    }
    const TemporaryFolder folder;
    fs::copy_file(here / "scotty", folder / "scotty");
    const Result alone = run(folder / "scotty", kOnDevice);
    CHECK(alone.exit_code == kExitMissingEnvironment);
    CHECK_THAT(alone.err, ContainsSubstring("scotty-cuda is not there"));
}

TEST_CASE("cuda: a program that was started for a planted fault has no such twin",
          "[verify][cli]") {
    const fs::path here = fs::read_symlink("/proc/self/exe").parent_path();
    if (!fs::exists(here / "scotty-mutants")) return;
    const Result result = run(here / "scotty-mutants", kOnDevice);
    CHECK(result.exit_code == kExitMissingEnvironment);
    CHECK_THAT(result.err, ContainsSubstring("scotty-mutants has no CUDA pipeline"));
}

}  // namespace
