#include <catch2/catch.hpp>

#include "reference/base/error.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::Contains;
using reference::LightKind;
using reference::MaterialKind;
using reference::Scene;
using reference::Vec3;
using tests::TemporaryFiles;
using tests::warns;

namespace {

/// A triangle with a camera and a light, its buffer inside the file (three corners, indices 0 1 2).
std::string gltf(const std::string& material, const std::string& more_nodes = "") {
    return R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_lights_punctual",
"KHR_materials_transmission"],
"extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","color":[1,0.5,0.25],"intensity":4},
{"type":"directional","intensity":2}]}},
"scene":0,"scenes":[{"nodes":[0,1,2,3]}],
"nodes":[{"mesh":0,"translation":[0,0,1],"scale":[2,2,2]},{"camera":0,"translation":[0,0,5]},
{"translation":[0,3,0],"extensions":{"KHR_lights_punctual":{"light":0}}},
{"rotation":[-0.70710678,0,0,0.70710678],"extensions":{"KHR_lights_punctual":{"light":1}}})" +
           more_nodes + R"(],
"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"aspectRatio":1.5,"znear":0.1}}],
"materials":[)" +
           material + R"(],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"material":0}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],
"buffers":[{"byteLength":42,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA"}]})";
}

const std::string kPaint = R"({"pbrMetallicRoughness":{"baseColorFactor":[0.8,0.7,0.6,1],
"metallicFactor":0,"roughnessFactor":1}})";

}  // namespace

TEST_CASE("gltf: transforms, camera and lights", "[scenes][gltf]") {
    const Scene scene = TemporaryFiles().load("a.gltf", gltf(kPaint));
    INFO(tests::all_warnings(scene));
    CHECK(scene.warnings.empty());
    CHECK(scene.vertices[1] == Vec3(2, 0, 1));
    CHECK(scene.materials.size() == 1);
    CHECK(scene.materials[0].reflectance == Vec3(0.8f, 0.7f, 0.6f));
    CHECK(scene.camera.position == Vec3(0, 0, 5));
    CHECK(scene.camera.tan_half_fov == Approx(std::tan(0.4)));
    REQUIRE(scene.lights.size() == 2);
    CHECK(scene.lights[0].kind == LightKind::point);
    CHECK(scene.lights[0].position == Vec3(0, 3, 0));
    CHECK(scene.lights[0].radiance == Vec3(4, 2, 1));
    CHECK(scene.lights[1].kind == LightKind::directional);
    CHECK(scene.lights[1].normal.y == Approx(-1));
}

TEST_CASE("gltf: materials", "[scenes][gltf]") {
    const TemporaryFiles files;
    const auto material = [&](const std::string& text) {
        const Scene scene = files.load("a.gltf", gltf(text));
        return scene.materials[scene.material_of[0]];
    };
    const auto mirror = material(R"({"pbrMetallicRoughness":{"baseColorFactor":[0.9,0.8,0.7,1],
        "metallicFactor":1,"roughnessFactor":0}})");
    CHECK(mirror.kind == MaterialKind::mirror);
    CHECK(mirror.reflectance == Vec3(0.9f, 0.8f, 0.7f));
    const auto glass = material(R"({"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0},
        "extensions":{"KHR_materials_transmission":{"transmissionFactor":1}}})");
    CHECK(glass.kind == MaterialKind::glass);
    CHECK(glass.ior == 1.5f);
    CHECK(material(R"({"emissiveFactor":[0.5,0.25,1]})").emission == Vec3(0.5f, 0.25f, 1));
    CHECK(warns(files.load("a.gltf", gltf(R"({"pbrMetallicRoughness":{"metallicFactor":0.5}})")),
                "metal and gloss"));
}

TEST_CASE("gltf: what is wrong is named with its element", "[scenes][gltf]") {
    const TemporaryFiles files;
    const auto fails = [&](const std::string& from, const std::string& to, const std::string& where,
                           const std::string& what) {
        CHECK_THROWS_WITH(files.load("a.gltf", tests::replaced(gltf(kPaint), from, to)),
                          Contains("a.gltf") && Contains(where) && Contains(what));
    };
    fails(R"("byteOffset":36)", R"("byteOffset":39)", "bufferViews[1]", "ends at byte 45");
    fails(R"("componentType":5123,"count":3)", R"("componentType":5123,"count":99)", "accessors[1]",
          "99 elements");
    fails(R"("bufferView":1,)", R"("bufferView":7,)", "accessors[1]", "bufferView 7 out of range");
    fails(R"("buffer":0)", R"("buffer":-1)", "bufferViews[0]", "found -1");
    fails("AAAAAAAAAAAAAAAAAACAPw", "", "a.gltf", "");
    // The last index, 2, becomes 9: assimp leaves the triangle out.
    fails("AAABAAIA", "AAABAAkA", "meshes", "");
    std::string two = tests::replaced(gltf(kPaint), "AAABAAIA", "AAABAAIAAAABAAkA");
    two = tests::replaced(two, R"("componentType":5123,"count":3)",
                          R"("componentType":5123,"count":6)");
    two = tests::replaced(two, R"("byteLength":6)", R"("byteLength":12)");
    two = tests::replaced(two, R"("byteLength":42)", R"("byteLength":48)");
    CHECK_THROWS_WITH(files.load("a.gltf", two), Contains("1 of 2 triangles"));
    CHECK_THROWS_WITH(files.load("a.gltf", gltf(kPaint).substr(0, 700)), Contains("truncated"));
    CHECK_THROWS_WITH(files.load("a.glb", "glTF"), Contains("a.glb"));
    CHECK_THROWS_WITH(files.load("a.glb", std::string("glTF\2\0\0\0\377\377\0\0\1\1\1\1JSON", 20)),
                      Contains("truncated"));
    CHECK_THROWS_WITH(files.load("a.gltf", "[]"), Contains("not well-formed"));
    CHECK_THROWS_WITH(files.load("a.gltf", R"({"meshes":[5]})"), Contains("not glTF as specified"));
}

TEST_CASE("gltf: nodes in a circle are an error, not an endless loop", "[scenes][gltf]") {
    const TemporaryFiles files;
    CHECK_THROWS_WITH(files.load("a.gltf", gltf(kPaint, R"(,{"children":[5]},{"children":[4]})")),
                      Contains("in a circle"));
    CHECK_THROWS_WITH(files.load("a.gltf", gltf(kPaint, R"(,{"children":[0]},{"children":[0]})")),
                      Contains("child of two nodes"));
    CHECK_THROWS_WITH(files.load("a.gltf", gltf(kPaint, R"(,{"children":[99]})")),
                      Contains("child 99 out of range"));
}

TEST_CASE("gltf: an extension that is not supported is named", "[scenes][gltf]") {
    const std::string text = tests::replaced(gltf(kPaint), R"(["KHR_lights_punctual",)",
                                             R"(["KHR_lights_punctual","KHR_materials_volume",)");
    CHECK(warns(TemporaryFiles().load("a.gltf", text), "KHR_materials_volume"));
}
