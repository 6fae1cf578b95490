/// glTF as files: containers, uris, versions, extensions, and what is wrong with them.

#include "reference/base/error.h"
#include "scenes/noise.h"
#include "tests/catch.h"
#include "tests/scenes/gltf_text.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using nlohmann::json;
using reference::Scene;
using tests::GltfText;
using tests::square_gltf;
using tests::TemporaryFiles;
using tests::warns;

namespace {

void set_word(std::string& bytes, std::size_t at, std::uint32_t value) {
    std::memcpy(&bytes[at], &value, sizeof value);
}

/// The square with a buffer that `uri` names.
std::string with_uri(const std::string& uri) {
    GltfText text = square_gltf();
    text.root["buffers"] = {{{"byteLength", text.bytes.size()}, {"uri", uri}}};
    return text.root.dump();
}

}  // namespace

TEST_CASE("gltf: buffers in files beside it, with blanks in their names", "[scenes][gltf]") {
    const TemporaryFiles files;
    const std::string data = square_gltf().bytes;
    for (const char* name : {"my data.bin", "%20.bin", "\xc3\xa4.bin", "100%.bin"}) {
        files.write(name, data);
    }
    for (const char* uri : {"my%20data.bin", "my data.bin", "./my%20data.bin", "%2520.bin",
                            "%20.bin", "%C3%A4.bin", "\xc3\xa4.bin", "100%25.bin", "100%.bin"}) {
        INFO(uri);
        CHECK(files.load("a.gltf", with_uri(uri)).triangles.size() == 2);
    }
    for (const char* uri : {"gone.bin", "http://host/data.bin", "", "a%00.bin", "."}) {
        INFO(uri);
        CHECK_THROWS_WITH(files.load("a.gltf", with_uri(uri)),
                          ContainsSubstring("buffers[0]: uri"));
    }
    files.write("short.bin", data.substr(0, data.size() - 1));
    CHECK_THROWS_WITH(
        files.load("a.gltf", with_uri("short.bin")),
        ContainsSubstring("buffers[0]") && ContainsSubstring("found 59 (truncated?)"));
    files.write("long.bin", data + "more");
    CHECK(files.load("a.gltf", with_uri("long.bin")).triangles.size() == 2);
}

TEST_CASE("gltf: data: uris", "[scenes][gltf]") {
    const TemporaryFiles files;
    const std::string digits = tests::base64(square_gltf().bytes);
    for (const char* kind : {"data:application/octet-stream;base64,",
                             "data:application/gltf-buffer;base64,", "data:;base64,"}) {
        CHECK(files.load("a.gltf", with_uri(kind + digits)).triangles.size() == 2);
    }
    for (const std::string& uri :
         {std::string("data:"), "data:;base64,!" + digits, "data:;base64," + digits.substr(4)}) {
        CHECK_THROWS_WITH(files.load("a.gltf", with_uri(uri)), ContainsSubstring("buffers[0]"));
    }
}

TEST_CASE("gltf: containers as exporters write them", "[scenes][gltf]") {
    const TemporaryFiles files;
    const std::string text = square_gltf().gltf();
    const std::string glb = square_gltf().glb();
    CHECK(files.load("a.gltf", "\xef\xbb\xbf" + text).triangles.size() == 2);
    CHECK(files.load("text.glb", text).triangles.size() == 2);
    CHECK(files.load("binary.gltf", glb).triangles.size() == 2);
    CHECK(files.load("a.glb", glb + "trailing bytes").triangles.size() == 2);
    // The JSON chunk filled up with zeros instead of blanks.
    for (std::size_t pad = 0; pad < 4; ++pad) {
        GltfText padded = square_gltf();
        padded.root["asset"]["generator"] = std::string(pad, 'x');
        std::string bytes = padded.glb();
        std::uint32_t length = 0;
        std::memcpy(&length, &bytes[12], sizeof length);
        std::uint32_t filled = 0;
        for (std::size_t i = 20 + length; bytes[--i] == ' '; ++filled) bytes[i] = '\0';
        CHECK(files.load("a.glb", bytes).triangles.size() == 2);
        // The padding is there, but the chunk's length leaves it out.
        set_word(bytes, 12, length - filled);
        CHECK(files.load("a.glb", bytes).triangles.size() == 2);
    }
}

TEST_CASE("gltf: a .glb whose lengths are wrong is refused", "[scenes][gltf]") {
    const TemporaryFiles files;
    const std::string glb = square_gltf().glb();
    const auto fails = [&](std::size_t at, std::uint32_t value, const char* what) {
        std::string bytes = glb;
        set_word(bytes, at, value);
        CHECK_THROWS_WITH(files.load("a.glb", bytes),
                          ContainsSubstring("a.glb") && ContainsSubstring(what));
    };
    fails(4, 1, "glTF 1.0 is not supported");
    fails(4, 3, "glTF 3.0 is not supported");
    fails(8, 100000, "truncated?");
    fails(8, 12, "without a chunk");
    fails(12, 100000, "chunk 0 is longer");
    fails(12, 0xffffffff, "chunk 0 is longer");
    fails(12, 10, "");
    fails(16, 0x1234, "one JSON chunk");
    for (std::size_t length = 0; length < glb.size(); ++length) {
        CHECK_THROWS_AS(files.load("a.glb", glb.substr(0, length)), reference::Error);
    }
    GltfText text = square_gltf();
    text.root["buffers"] = {{{"byteLength", text.bytes.size()}}};
    CHECK_THROWS_WITH(files.load("a.gltf", text.root.dump()), ContainsSubstring("expected a uri"));
}

TEST_CASE("gltf: other versions are refused by name", "[scenes][gltf]") {
    const TemporaryFiles files;
    const auto refused = [&](const std::string& text, const char* what) {
        CHECK_THROWS_WITH(files.load("a.gltf", text), ContainsSubstring(what));
    };
    refused(R"({"asset":{"version":"1.0"},"scenes":{},"nodes":{},"meshes":{}})", "glTF 1.0");
    refused(R"({"asset":{"version":"1.1"}})", "glTF 1.1 is not supported");
    refused(R"({"scenes":{},"nodes":{},"meshes":{}})", "glTF 1.0 is not supported");
    refused(
        "\xef\xbb\xbf"
        R"({"asset":{"version":"3.0"}})",
        "glTF 3.0 is not supported");
    refused(R"({"asset":{"version":"2.1","minVersion":"2.1"}})", "glTF 2.1 is not supported");
    refused(R"({"asset":{}})", "asset.version is missing");
    GltfText later = square_gltf();
    later.root["asset"]["version"] = "2.1";
    CHECK(tests::load_gltf(later).triangles.size() == 2);
}

TEST_CASE("gltf: extensions that the file requires are obeyed", "[scenes][gltf]") {
    GltfText text = square_gltf();
    text.root["extensionsUsed"] = {"KHR_materials_volume", "KHR_materials_ior"};
    CHECK(warns(tests::load_gltf(text), "KHR_materials_volume is not supported"));
    CHECK_FALSE(warns(tests::load_gltf(text), "KHR_materials_ior"));
    text.root["extensionsRequired"] = {"KHR_texture_basisu", "EXT_not_known",
                                       "EXT_mesh_gpu_instancing"};
    CHECK_THROWS_WITH(tests::load_gltf(text), ContainsSubstring("extensionsRequired") &&
                                                  ContainsSubstring("EXT_not_known") &&
                                                  ContainsSubstring("EXT_mesh_gpu_instancing") &&
                                                  !ContainsSubstring("basisu"));
}

TEST_CASE(
    "gltf: an extension that stands in the file is named, also where the file does not list it",
    "[scenes][gltf]") {
    GltfText text = square_gltf({{"extensions", {{"EXT_mesh_gpu_instancing", json::object()}}}});
    const auto named = [&] {
        const Scene scene = tests::load_gltf(text);
        std::vector<std::string> out;
        for (const std::string& warning : scene.warnings) {
            if (warning.find("extension") != std::string::npos) out.push_back(warning);
        }
        return out;
    };
    const std::vector<std::string> once = {
        "the extension EXT_mesh_gpu_instancing is not supported: left out"};
    CHECK(named() == once);
    text.root["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    CHECK(named() == once);
    text.append(
        "materials",
        {{"extensions",
          {{"KHR_materials_unlit", json::object()}, {"KHR_materials_sheen", json::object()}}}});
    CHECK(named().size() == 2);
    // What stands in extras belongs to nobody.
    text.root["extras"] = {{"extensions", {{"ABC_private", json::object()}}}};
    CHECK(named().size() == 2);
}

TEST_CASE("gltf: what is wrong is named with its element", "[scenes][gltf]") {
    const TemporaryFiles files;
    const auto fails = [&](const char* pointer, const json& value, const char* where,
                           const char* what) {
        GltfText text = square_gltf();
        text.root[json::json_pointer(pointer)] = value;
        INFO(pointer);
        CHECK_THROWS_WITH(tests::load_gltf(text), ContainsSubstring("a.gltf: ") &&
                                                      ContainsSubstring(where) &&
                                                      ContainsSubstring(what));
    };
    fails("/bufferViews/1/byteOffset", 51, "bufferViews[1]", "ends at byte 63, its buffer has 60");
    fails("/bufferViews/0/buffer", -1, "bufferViews[0]", "found -1");
    fails("/bufferViews/0/buffer", 7, "bufferViews[0]", "buffers[7]");
    fails("/bufferViews/0/byteLength", 1e300, "bufferViews[0]", "a whole number");
    fails("/bufferViews/0/byteOffset", -8, "bufferViews[0]", "found -8");
    fails("/bufferViews/0/byteOffset", 1ull << 47, "bufferViews[0]", "ends at byte");
    fails("/bufferViews/0/byteStride", -4, "bufferViews[0]", "found -4");
    fails("/bufferViews/0/byteStride", 1u << 20, "bufferViews[0]", "at most 252");
    fails("/bufferViews/0/byteStride", 252, "accessors[0]", "4 elements end at byte 768");
    fails("/bufferViews/1/byteStride", 4, "accessors[1]", "6 elements end at byte 22");
    fails("/accessors/1/count", 99, "accessors[1]", "99 elements");
    fails("/accessors/1/count", 0, "accessors[1]", "expected 1 to");
    fails("/accessors/1/count", 1ull << 40, "accessors[1]", "expected 1 to");
    fails("/accessors/1/bufferView", 7, "accessors[1]", "bufferViews[7] is out of range");
    fails("/accessors/1/componentType", 5126, "accessors[1]", "");
    fails("/accessors/1/componentType", 5124, "accessors[1]", "found 5124");
    fails("/accessors/1/type", "VEC5", "accessors[1]", "'VEC5'");
    fails("/accessors/0/type", "VEC2", "accessors[0]", "expected 3 components");
    fails("/accessors/0/byteOffset", 1, "accessors[0]", "end at byte 49");
    fails("/meshes/0/primitives/0/attributes/POSITION", 9, "primitives[0]", "accessors[9]");
    fails("/meshes/0/primitives/0/attributes/NORMAL", 1, "accessors[1]", "3 components");
    fails("/meshes/0/primitives/0/indices", 9, "primitives[0]", "accessors[9]");
    fails("/meshes/0/primitives/0/material", 3, "primitives[0]", "material 3");
    fails("/meshes/0/primitives", json::object(), "meshes[0]", "primitives: expected an array");
    fails("/meshes/0", 5, "meshes[0]", "expected an object");
    fails("/nodes/0/mesh", 2, "nodes[0]", "meshes[2]");
    fails("/nodes/0/scale", {1, 2}, "nodes[0]", "3 numbers, found 2");
    fails("/nodes/0/scale", {1, 2, "3"}, "nodes[0]", "a number");
    fails("/nodes/0/rotation", {0, 0, 0, 0}, "nodes[0]", "unit quaternion");
    fails("/nodes/0/matrix", json(std::vector<int>(16, 1)), "nodes[0]", "last row");
    fails("/nodes/0/children", {99}, "nodes[0]", "child 99 out of range");
    fails("/nodes/0/children", {0}, "nodes[0]", "in a circle");
    fails("/scenes/0/nodes", {4}, "scenes[0]", "node 4 out of range");
    fails("/scenes/0/nodes", {0, 0}, "scenes[0]", "listed twice");
    fails("/asset", 5, "asset", "expected an object");
    GltfText apart = square_gltf();
    apart.root["bufferViews"][1]["byteStride"] = 4;
    apart.root["accessors"][1]["count"] = 3;
    CHECK_THROWS_WITH(tests::load_gltf(apart),
                      ContainsSubstring("accessors[1]: no vertex indices"));
}

TEST_CASE("gltf: nodes that are no trees are refused, deep ones are not", "[scenes][gltf]") {
    GltfText text = square_gltf();
    text.append("nodes", {{"children", {2}}});
    text.append("nodes", {{"children", {1}}});
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring("nodes[1]") && ContainsSubstring("in a circle"));
    text.root["nodes"][2]["children"] = json::array();
    text.root["nodes"].push_back({{"children", {2}}});
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring("nodes[2]") && ContainsSubstring("child of two nodes"));
    text.root["nodes"].erase(3);
    text.root["scenes"][0]["nodes"] = {0, 2};
    CHECK_THROWS_WITH(tests::load_gltf(text), ContainsSubstring("node 2 is no root"));

    GltfText deep = square_gltf();
    for (std::size_t i = 1; i < 20000; ++i) deep.append("nodes", {{"children", {i - 1}}});
    deep.root["scenes"][0]["nodes"] = {19999};
    CHECK(tests::load_gltf(deep).triangles.size() == 2);
}

TEST_CASE("gltf: text that is no JSON is refused with its place", "[scenes][gltf]") {
    const TemporaryFiles files;
    const std::string text = square_gltf().gltf();
    for (std::size_t length = 0; length < text.size(); length += 7) {
        CHECK_THROWS_WITH(files.load("a.gltf", text.substr(0, length)),
                          ContainsSubstring("a.gltf") && ContainsSubstring("truncated"));
    }
    CHECK_THROWS_WITH(files.load("a.gltf", "{\n\n[}"), ContainsSubstring("line 3"));
    CHECK_THROWS_WITH(files.load("a.gltf", "[]"), ContainsSubstring("not well-formed"));
    CHECK_THROWS_WITH(files.load("a.gltf", R"({"meshes":[5]})"),
                      ContainsSubstring("not glTF as specified"));
    // Nesting must not use up the stack.
    CHECK_THROWS_AS(files.load("a.gltf", std::string(1000000, '[')), reference::Error);
}

TEST_CASE("gltf: a file with single bytes changed never crashes", "[scenes][gltf][hostile]") {
    const TemporaryFiles files;
    for (const std::string& whole : {square_gltf().gltf(), square_gltf().glb()}) {
        for (std::uint32_t i = 0; i < 600; ++i) {
            std::string changed = whole;
            changed[scenes::hash32(i) % whole.size()] = "0917\"-[],{"[i % 10];
            try {
                files.load("a.gltf", changed);
            } catch (const reference::Error& error) {
                CHECK(error.kind() == reference::ErrorKind::bad_input);
            }
        }
    }
}

TEST_CASE("gltf: more triangles than there may be are refused before they are made",
          "[scenes][gltf]") {
    GltfText text;
    const std::size_t positions = text.accessor("VEC3", std::vector<float>(9, 1.0f));
    const std::size_t corners =
        text.accessor("SCALAR", std::vector<std::uint8_t>(3'000'000, std::uint8_t{0}));
    text.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", corners}});
    for (int i = 0; i < 201; ++i) text.node({{"mesh", 0}});
    CHECK_THROWS_WITH(tests::load_gltf(text), ContainsSubstring("more than 200000000 triangles"));
}
