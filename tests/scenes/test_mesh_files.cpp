#include <catch2/catch.hpp>
#include <cstring>

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

const std::string kSquareObj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

const std::string kPlyHeader =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
    "z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

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

TEST_CASE("obj: polygons, shared vertices, relative indices, continued lines", "[scenes][obj]") {
    const TemporaryFiles files;
    const Scene square = files.load("a.obj", kSquareObj + "f 1 2 3 4\n");
    CHECK(square.triangles.size() == 2);
    CHECK(square.vertices.size() == 4);
    CHECK(square.normals.empty());
    CHECK(warns(square, "no camera in the file"));
    CHECK(warns(square, "no light in the file"));
    CHECK(files.load("b.obj", kSquareObj + "f -4 -3 -2 -1\n").triangles.size() == 2);
    CHECK(files.load("c.OBJ", kSquareObj + "f 1 2 \\\n3 4\n").triangles.size() == 2);
}

TEST_CASE("obj: positions stay as they are, to the bit", "[scenes][obj]") {
    const Scene scene = TemporaryFiles().load(
        "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.0000001 0 0\nv 0 0 1\nf 1 2 3\nf 4 2 5\n");
    CHECK(scene.vertices.size() == 5);
    CHECK(scene.vertices[3] == Vec3(1e-7f, 0, 0));
}

TEST_CASE("obj: mirror, glass and emission of a material library", "[scenes][obj]") {
    const TemporaryFiles files;
    files.write("m.mtl",
                "newmtl mirror\nillum 3\nKs 0.9 0.8 0.7\nnewmtl glass\nillum 7\nNi 1.4\n"
                "Tf 0.9 1 0.8\nnewmtl lamp\nKd 0.2 0.3 0.4\nKe 3 2 1\nmap_Kd foo.png\n");
    const Scene scene = files.load("a.obj", "mtllib m.mtl\n" + kSquareObj +
                                                "usemtl mirror\nf 1 2 3\nusemtl glass\nf 1 3 4\n"
                                                "usemtl lamp\nf 2 3 4\nl 1 2\n");
    const auto& mirror = scene.materials[scene.material_of[0]];
    CHECK(mirror.kind == MaterialKind::mirror);
    CHECK(mirror.reflectance == Vec3(0.9f, 0.8f, 0.7f));
    const auto& glass = scene.materials[scene.material_of[1]];
    CHECK(glass.kind == MaterialKind::glass);
    CHECK(glass.ior == 1.4f);
    CHECK(glass.transmittance == Vec3(0.9f, 1, 0.8f));
    const auto& lamp = scene.materials[scene.material_of[2]];
    CHECK(lamp.emission == Vec3(3, 2, 1));
    CHECK(lamp.reflectance == Vec3(0.2f, 0.3f, 0.4f));
    CHECK(lamp.emission_is_sampled == 1);
    REQUIRE(scene.lights.size() == 1);
    CHECK(scene.lights[0].kind == LightKind::triangle);
    CHECK(warns(scene, "texture"));
    CHECK(warns(scene, "'l' elements"));
}

TEST_CASE("obj: what is wrong is named with its line", "[scenes][obj]") {
    const TemporaryFiles files;
    const auto fails = [&](const std::string& text, const std::string& line,
                           const std::string& what) {
        CHECK_THROWS_WITH(files.load("a.obj", text),
                          Contains("a.obj") && Contains(line) && Contains(what));
    };
    fails(kSquareObj + "f 1 2 9\n", "line 5", "vertex index 9 out of range");
    fails(kSquareObj + "f 1 2 -9\n", "line 5", "vertex index -9 out of range");
    fails(kSquareObj + "f 1 2 0\n", "line 5", "found '0'");
    fails(kSquareObj + "f 1 2 x\n", "line 5", "found 'x'");
    fails(kSquareObj + "f 1 2\n", "line 5", "at least 3 corners");
    fails("v 0 0 0\nv 1 nan 0\n", "line 2", "found 'nan'");
    fails("v 0 0 0\nv 1 1e99 0\n", "line 2", "found '1e99'");
    fails("v 0 0 0\nv 1 0\n", "line 2", "found ''");
    fails("", "a.obj", "no vertices");
    CHECK_THROWS_WITH(files.load("a.obj", kSquareObj + "l 1 2\n"), Contains("no triangles"));
    CHECK(warns(files.load("a.obj", "mtllib gone.mtl\n" + kSquareObj + "f 1 2 3\n"),
                "material library 'gone.mtl' is missing"));
}

TEST_CASE("ply: text and binary", "[scenes][ply]") {
    const TemporaryFiles files;
    const Scene text = files.load("a.ply", kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    CHECK(text.triangles.size() == 1);
    CHECK(text.materials[0].reflectance == Vec3(0.5f, 0.5f, 0.5f));
    CHECK(warns(text, "a mesh without material"));
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const std::int32_t face[3] = {0, 1, 2};
    std::string binary = tests::replaced(kPlyHeader, "ascii", "binary_little_endian");
    binary.append(reinterpret_cast<const char*>(corners), sizeof corners);
    binary += '\3';
    binary.append(reinterpret_cast<const char*>(face), sizeof face);
    CHECK(reference::fingerprint(files.load("b.ply", binary)) == reference::fingerprint(text));
    binary.pop_back();
    CHECK_THROWS_WITH(files.load("b.ply", binary), Contains("face 0") && Contains("truncated?"));
}

TEST_CASE("ply: what is wrong is named with its element", "[scenes][ply]") {
    const TemporaryFiles files;
    const auto fails = [&](const std::string& text, const std::string& where,
                           const std::string& what) {
        CHECK_THROWS_WITH(files.load("a.ply", text),
                          Contains("a.ply") && Contains(where) && Contains(what));
    };
    fails(kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "face 0", "vertex index 7 out of range");
    fails(kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "face 0", "out of range");
    fails(kPlyHeader + "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n", "vertex 2", "finite");
    fails(kPlyHeader + "0 0 0\n1 0 0\n", "vertex 2", "truncated?");
    fails(kPlyHeader + "0 0 0\n1 0 hello\n", "byte", "'hello'");
    fails("ply\nformat ascii 1.0\n", "header", "no end_header");
    fails("nonsense", "header", "'ply' first");
    fails("", "header", "'ply' first");
    fails(std::string("ply\nformat ascii 1.0\nproperty uchar \0red\n", 41), "header",
          "no text: 0x00");
    fails(tests::replaced(kPlyHeader, "ascii", "latin"), "header", "'latin'");
    fails(tests::replaced(kPlyHeader, "float x", "real x"), "header", "real x");
    fails(tests::replaced(kPlyHeader, "vertex 3", "vertex 0"), "header", "no vertices");
    fails(tests::replaced(kPlyHeader, "float y", "float x"), "header", "one 'x', found 2");
    fails(tests::replaced(kPlyHeader, "end_header", "end_header:"), "header", "'end_header:'");
    fails(tests::replaced(kPlyHeader, "vertex 3", "vertex 3property"), "header",
          "vertex 3property");
    fails(kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n0\n", "face 0", "without corners");
}

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
