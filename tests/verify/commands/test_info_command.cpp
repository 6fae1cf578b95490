/// scotty info: a built-in scene and a file, as text and as JSON.
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/catch.h"
#include "tests/verify/command_tools.h"

namespace {

using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;

TEST_CASE("info: a built-in scene as text", "[verify][cli][info]") {
    const Result info = scotty_here("info cornell");
    CHECK(info.exit_code == 0);
    CHECK(info.err.empty());
    for (const char* words :
         {"triangles      12\n", "1 parallelogram", "degrees high", "extents"}) {
        CHECK_THAT(info.out, ContainsSubstring(words));
    }
    CHECK_THAT(info.out, !ContainsSubstring("meshes"));
}

TEST_CASE("info: a file's JSON says what is in it and what was made of it", "[verify][cli][info]") {
    const TemporaryFolder folder;
    const std::string path = folder.file("a.obj");
    std::ofstream(path) << "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 2 0 0\nl 1 2\nf 1 2 3\nf 1 2 4\n";
    const Result info = scotty_here("info --json '" + path + "'");
    REQUIRE(info.exit_code == 0);
    const nlohmann::json json = nlohmann::json::parse(info.out);
    CHECK(json["triangles"] == 2);
    CHECK(json["empty_triangles"] == 1);
    CHECK(json["materials"]["diffuse"] == 1);
    CHECK(json["lights"]["directional"] == 1);
    CHECK(json["extents"]["high"] == nlohmann::json({2.0, 2.0, 0.0}));
    CHECK_THAT(json["not_supported"].dump(), ContainsSubstring("'l' elements"));
    CHECK_THAT(json["repaired"].dump(), ContainsSubstring("no light in the file"));
    CHECK_THAT(json["repaired"].dump(), ContainsSubstring("zero area"));
    const Result dark = scotty_here("info --json '" + path + "#lights=none'");
    CHECK(nlohmann::json::parse(dark.out)["lights"]["directional"] == 0);
}

TEST_CASE("info: --tree says what reinsertion gained, and how long it took",
          "[verify][cli][info]") {
    const Result info = scotty_here("info coil --tree");
    CHECK(info.exit_code == 0);
    CHECK_THAT(info.out, ContainsSubstring("tree           expected inner nodes of a ray"));
    const Result json = scotty_here("info coil --tree --json");
    const nlohmann::json tree = nlohmann::json::parse(json.out)["tree"];
    CHECK(tree["cost_optimised"].get<double>() < tree["cost_built"].get<double>());
    CHECK(tree["seconds_built"].get<double>() > 0.0);
    CHECK(tree["seconds_optimised"].get<double>() > 0.0);
    CHECK_FALSE(nlohmann::json::parse(scotty_here("info coil --json").out).contains("tree"));
}

TEST_CASE("info: what cannot be read is bad input", "[verify][cli][info]") {
    const Result info = scotty_here("info nosuchscene");
    CHECK(info.exit_code == 2);
    CHECK_THAT(info.err, ContainsSubstring("no such scene"));
    CHECK(info.out.empty());
}

}  // namespace
