/// A machine without OpenImageIO: only what reads or writes an image file needs it.
#include <algorithm>
#include <filesystem>
#include <string>

#include "tests/catch.h"
#include "tests/verify/command_tools.h"
#include "tests/verify/image_tools.h"
#include "verify/images/image_file.h"

namespace {

using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

/// `scotty` with a variable of the environment.
Result scotty_with(const std::string& variable, const std::string& arguments) {
    const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "scotty";
    return run("/usr/bin/env", variable + " '" + program.string() + "' " + arguments);
}
Result without_images(const std::string& arguments) {
    return scotty_with("SCOTTY_IMAGE_MODULE=", arguments);
}

constexpr const char* kTiny = " --size 16x12 --spp 2 --bounces 1 --light-samples 1";

TEST_CASE("without images: the program itself links no library for images", "[verify][cli]") {
    const Result libraries = scotty_with("LD_TRACE_LOADED_OBJECTS=1", "");
    REQUIRE_THAT(libraries.out, ContainsSubstring("libstdc++"));
    CHECK_THAT(libraries.out, !ContainsSubstring("OpenImageIO"));
    CHECK(std::count(libraries.out.begin(), libraries.out.end(), '\n') < 25);
}

TEST_CASE("without images: renders, arrays and verification work", "[verify][cli]") {
    const TemporaryFolder folder;
    const std::string a = "'" + folder.file("a.npy") + "'", b = "'" + folder.file("b.npy") + "'";
    REQUIRE(without_images("render cornell -o " + a + kTiny).exit_code == 0);
    REQUIRE(without_images("render cornell -o " + b + kTiny + " --backend embree").exit_code == 0);
    for (const char* name : {"a.npy", "a.variance.npy", "a.json"}) {
        CHECK(fs::exists(folder.file(name)));
    }
    CHECK(without_images("diff " + a + " " + b).exit_code == 0);
    CHECK(without_images("verify furnace --no-golden --width 8" + std::string(kTiny)).exit_code ==
          0);
    const Result doctor = without_images("doctor");
    CHECK(doctor.exit_code == 0);
    CHECK_THAT(doctor.out, ContainsSubstring("SCOTTY_IMAGE_MODULE"));
}

TEST_CASE("without images: what needs them says what is missing, before any work",
          "[verify][cli][errors]") {
    const TemporaryFolder folder;
    const std::string png = "'" + folder.file("a.png") + "'";
    const std::string exr = "'" + folder.file("a.exr") + "'";
    scotty::verify::write_measured_image(smooth_image(8, 8), folder.file("a.exr"));
    for (const std::string& command :
         {"render cornell --size 4096x4096 --spp 4096 -o " + png, "diff " + exr + " " + exr,
          std::string("verify furnace --only-golden")}) {
        const Result result = without_images(command);
        INFO(command << "\n" << result.err);
        CHECK(result.exit_code == 3);
        CHECK_THAT(result.err,
                   ContainsSubstring("need OpenImageIO") && ContainsSubstring("cannot be loaded"));
    }
    const Result not_a_module =
        scotty_with("SCOTTY_IMAGE_MODULE=/usr/bin/env", "diff " + exr + " " + exr);
    CHECK(not_a_module.exit_code == 3);
    CHECK_THAT(not_a_module.err, ContainsSubstring("/usr/bin/env"));
}

}  // namespace
