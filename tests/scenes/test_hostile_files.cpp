
#include "reference/base/error.h"
#include "scenes/noise.h"
#include "tests/catch.h"
#include "tests/scenes/collada_text.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using tests::ColladaText;
using tests::TemporaryFiles;

namespace {

/// Loads, and accepts a scene or an error of the suite, nothing else.
void load_without_crash(const TemporaryFiles& files, const std::string& name,
                        const std::string& content) {
    try {
        files.load(name, content);
    } catch (const reference::Error& error) {
        CHECK(error.kind() == reference::ErrorKind::bad_input);
    }
}

std::string noise_bytes(std::size_t count, std::uint32_t seed) {
    std::string bytes;
    for (std::uint32_t i = 0; i < count; ++i) {
        bytes += static_cast<char>(scenes::hash32(i * 977u + seed));
    }
    return bytes;
}

}  // namespace

TEST_CASE("files: a COLLADA file cut off anywhere is an error", "[scenes][hostile]") {
    const TemporaryFiles files;
    const std::string text = ColladaText().text();
    for (std::size_t length = 0; length + 1 < text.size(); length += 41) {
        INFO("length " << length);
        CHECK_THROWS_WITH(files.load("a.dae", text.substr(0, length)), ContainsSubstring("a.dae"));
    }
}

TEST_CASE("files: noise, in every format, is an error and no crash", "[scenes][hostile]") {
    const TemporaryFiles files;
    for (const char* name : {"a.dae", "a.obj", "a.ply", "a.gltf", "a.glb"}) {
        for (std::uint32_t seed = 0; seed < 8; ++seed) {
            CHECK_THROWS_AS(files.load(name, noise_bytes(2000, seed)), reference::Error);
        }
    }
}

TEST_CASE("files: a COLLADA file with single bytes changed never crashes", "[scenes][hostile]") {
    const TemporaryFiles files;
    const std::string text = ColladaText().text();
    for (std::uint32_t i = 0; i < 400; ++i) {
        std::string changed = text;
        changed[scenes::hash32(i) % text.size()] = "0917<\"/ -"[i % 9];
        load_without_crash(files, "a.dae", changed);
    }
}

TEST_CASE("files: another format under a COLLADA name", "[scenes][hostile]") {
    CHECK_THROWS_WITH(TemporaryFiles().load("a.dae", "<svg/>"),
                      ContainsSubstring("expected a <COLLADA> document, found <svg>"));
}

TEST_CASE("files: what is wrong in a COLLADA file is named with its element", "[scenes][hostile]") {
    const TemporaryFiles files;
    const auto fails = [&](const std::string& from, const std::string& to, const std::string& where,
                           const std::string& what) {
        CHECK_THROWS_WITH(
            files.load("a.dae", tests::replaced(ColladaText().text(), from, to)),
            ContainsSubstring("a.dae") && ContainsSubstring(where) && ContainsSubstring(what));
    };
    fails("0 0 0 1 0 0 1 1 0", "0 0 0 1 nan 0 1 1 0", "spa", "found 'nan'");
    fails("0 0 0 1 0 0 1 1 0", "0 0 0 1 abc 0 1 1 0", "spa", "found 'abc'");
    fails("0 0 0 1 0 0 1 1 0", "0 0 0 1 1e999 0 1 1 0", "spa", "found '1e999'");
    fails("1 1 0 0 1 0<", "1 1 0<", "accessor", "the array holds 9 numbers");
    fails("stride=\"3\"", "stride=\"2\"", "accessor", "stride");
    fails("<p>0 0 1 0 2 0 3 0", "<p>0 0 1 0 2 0 4 0", "polylist", "position index 4 out of range");
    fails("<p>0 0 1 0 2 0 3 0", "<p>0 0 1 0 2 0 3 1", "polylist", "normal index 1 out of range");
    fails("<p>0 0 1 0 2 0 3 0", "<p>0 0 1 0 2 0", "polylist", "expected 8 indices in <p>, found 6");
    fails("<p>0 0 1 0 2 0 3 0", "<p>0 0 -1 0 2 0 3 0", "<p>", "found '-1'");
    fails("count=\"1\"><input", "count=\"2\"><input", "polylist", "expected 2 polygons");
    fails("url=\"#square\"", "url=\"#circle\"", "instance_geometry", "\"circle\"");
    fails("url=\"#square\"", "url=\"#mat\"", "instance_geometry", "is a <material>");
    fails("url=\"#square\"", "url=\"other.dae#x\"", "instance_geometry", "in this file");
    fails("target=\"#mat\"", "target=\"#gone\"", "symbol=\"paint\"", "\"gone\"");
    fails("url=\"#fx\"", "url=\"#gone\"", "instance_effect", "\"gone\"");
    fails("0.1 0.2 0.3 1", "0.1 0.2", "<color>", "3 or 4 numbers");
    fails("<instance_visual_scene url=\"#s\"/>", "<instance_visual_scene url=\"#t\"/>", "t",
          "visual_scene");
}
