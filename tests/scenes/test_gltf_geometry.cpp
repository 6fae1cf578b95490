
#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/scenes/gltf_text.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using nlohmann::json;
using reference::Scene;
using reference::Vec3;
using tests::GltfText;
using tests::square_gltf;
using tests::TemporaryFiles;
using tests::warns;

namespace {

/// The corners of all triangles, each rotated so that its smallest corner comes first.
std::vector<std::array<std::uint32_t, 3>> canonical(const Scene& scene) {
    auto out = scene.triangles;
    for (auto& triangle : out) {
        std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                    triangle.end());
    }
    return out;
}

/// Six points in two rows, as a strip runs through them.
const std::vector<float> kRows = {0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0, 2, 1, 0};

Scene load_mode(int mode, const std::vector<std::uint8_t>& corners,
                const json& node = json::object()) {
    GltfText text;
    const std::size_t positions = text.accessor("VEC3", kRows);
    json primitive = {{"attributes", {{"POSITION", positions}}}, {"mode", mode}};
    if (!corners.empty()) primitive["indices"] = text.accessor("SCALAR", corners);
    json entry = node;
    entry["mesh"] = text.mesh(primitive);
    text.node(entry);
    return tests::load_gltf(text);
}

}  // namespace

TEST_CASE("gltf: lists, strips and fans make the triangles that the format says",
          "[scenes][gltf]") {
    using Triangles = std::vector<std::array<std::uint32_t, 3>>;
    CHECK(canonical(load_mode(4, {0, 2, 1, 1, 2, 3})) == Triangles{{0, 2, 1}, {1, 2, 3}});
    CHECK(canonical(load_mode(5, {0, 1, 2, 3, 4, 5})) ==
          Triangles{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}, {3, 5, 4}});
    CHECK(canonical(load_mode(6, {0, 2, 3, 1})) == Triangles{{0, 2, 3}, {0, 3, 1}});
    CHECK(canonical(load_mode(4, {})) == Triangles{{0, 1, 2}, {3, 4, 5}});
    CHECK(canonical(load_mode(5, {})).size() == 4);
    CHECK(canonical(load_mode(6, {})).size() == 4);
}

TEST_CASE("gltf: all triangles of a strip face the same way, also where the node mirrors",
          "[scenes][gltf]") {
    for (const int mode : {5, 6}) {
        for (const double x : {1.0, -1.0}) {
            const std::vector<std::uint8_t> corners =
                mode == 5 ? std::vector<std::uint8_t>{} : std::vector<std::uint8_t>{0, 1, 3, 5};
            const Scene scene = load_mode(mode, corners, {{"scale", {x, 1, 1}}});
            for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
                CHECK(tests::front_of(scene, i) == Vec3(0, 0, -1));
            }
        }
    }
}

TEST_CASE("gltf: strips that repeat corners to be joined leave no needless triangles",
          "[scenes][gltf]") {
    CHECK(load_mode(5, {0, 1, 2, 2, 3, 3, 4, 5}).triangles.size() == 2);
}

TEST_CASE("gltf: corners that make no triangle, points and lines are noted", "[scenes][gltf]") {
    CHECK(warns(load_mode(4, {0, 1, 2, 3}), "no whole number of triangles"));
    for (const int mode : {0, 1, 2, 3}) {
        CHECK_THROWS_WITH(load_mode(mode, {0, 1, 2}), ContainsSubstring("no triangles") &&
                                                          ContainsSubstring("lines and points"));
    }
    CHECK_THROWS_WITH(load_mode(7, {0, 1, 2}),
                      ContainsSubstring("primitives[0]") && ContainsSubstring("found 7"));
}

TEST_CASE("gltf: indices of all widths, in both kinds of file", "[scenes][gltf]") {
    const TemporaryFiles files;
    const auto with = [&](const auto& corners) {
        GltfText text;
        const std::size_t positions = text.accessor("VEC3", tests::kGltfSquare);
        const std::size_t indices = text.accessor("SCALAR", corners);
        text.node({{"mesh",
                    text.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}})}});
        const Scene one = files.load("a.gltf", text.gltf());
        CHECK(one.triangles == std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}});
        CHECK(reference::fingerprint(one) ==
              reference::fingerprint(files.load("b.glb", text.glb())));
    };
    with(std::vector<std::uint8_t>{0, 1, 2, 0, 2, 3});
    with(std::vector<std::uint16_t>{0, 1, 2, 0, 2, 3});
    with(std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3});
}

TEST_CASE("gltf: only vertices that a triangle uses come along, in the file's order",
          "[scenes][gltf]") {
    const Scene scene = load_mode(4, {5, 1, 4});
    REQUIRE(scene.vertices.size() == 3);
    CHECK(scene.vertices[0] == Vec3(0, 1, 0));
    CHECK(scene.vertices[1] == Vec3(2, 0, 0));
    CHECK(scene.triangles[0] == std::array<std::uint32_t, 3>{2, 0, 1});
}

TEST_CASE("gltf: interleaved attributes", "[scenes][gltf]") {
    GltfText text;
    std::vector<float> mixed;
    for (std::size_t i = 0; i < 4; ++i) {
        mixed.insert(mixed.end(), &tests::kGltfSquare[i * 3], &tests::kGltfSquare[i * 3] + 3);
        mixed.insert(mixed.end(), {0.0f, 0.6f, 0.8f, -7.0f, -7.0f});
    }
    const std::size_t view = text.view(tests::bytes_of(mixed), 32);
    json accessor = {{"bufferView", view}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}};
    const std::size_t positions = text.append("accessors", accessor);
    accessor["byteOffset"] = 12;
    const std::size_t normals = text.append("accessors", accessor);
    text.node({{"mesh", text.mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}},
                                   {"mode", 6}})}});
    const Scene scene = tests::load_gltf(text);
    CHECK(scene.vertices[2] == Vec3(1, 1, 0));
    CHECK(scene.normals[3].z == Approx(0.8));
    text.root["bufferViews"][view]["byteStride"] = 8;
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring("accessors[0]") && ContainsSubstring("overlap"));
}

TEST_CASE("gltf: sparse values replace those of the view, or zeros", "[scenes][gltf]") {
    GltfText text = square_gltf();
    const std::size_t places = text.view(tests::bytes_of(std::vector<std::uint16_t>{1, 3}));
    const std::size_t values = text.view(tests::bytes_of(std::vector<float>{5, 6, 7, -5, -6, -7}));
    text.root["accessors"][0]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", places}, {"componentType", 5123}}},
        {"values", {{"bufferView", values}}}};
    Scene scene = tests::load_gltf(text);
    CHECK(scene.vertices[0] == Vec3(-1, -1, 0));
    CHECK(scene.vertices[1] == Vec3(5, 6, 7));
    CHECK(scene.vertices[3] == Vec3(-5, -6, -7));
    text.root["accessors"][0].erase("bufferView");
    scene = tests::load_gltf(text);
    CHECK(scene.vertices[2] == Vec3(0, 0, 0));
    CHECK(scene.vertices[3] == Vec3(-5, -6, -7));

    text.root["accessors"][0]["sparse"]["count"] = 9;
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring("accessors[0]: sparse") && ContainsSubstring("found 9"));
    text.root["accessors"][0]["count"] = 3;
    text.root["accessors"][0]["sparse"]["count"] = 2;
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring("sparse") && ContainsSubstring("below 3, found 3"));
    text.root["accessors"][0].erase("sparse");
    CHECK_THROWS_WITH(tests::load_gltf(text), ContainsSubstring("positions have no data"));
}

TEST_CASE("gltf: quantised positions and normals", "[scenes][gltf]") {
    const auto quantised = [](const auto& positions, bool is_normalised, double scale) {
        GltfText text;
        const std::size_t accessor = text.accessor("VEC3", positions);
        const std::size_t normals =
            text.accessor("VEC3", std::vector<std::int8_t>{0, 0, 127, 0, 0, 127, 0, 0, 127});
        text.root["accessors"][accessor]["normalized"] = is_normalised;
        text.root["accessors"][normals]["normalized"] = true;
        text.root["extensionsRequired"] = {"KHR_mesh_quantization"};
        text.node(
            {{"scale", {scale, scale, scale}},
             {"mesh", text.mesh({{"attributes", {{"POSITION", accessor}, {"NORMAL", normals}}}})}});
        return tests::load_gltf(text);
    };
    const std::vector<Vec3> corner = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
    const auto check = [&](const Scene& scene) {
        REQUIRE(scene.vertices.size() == 3);
        for (std::size_t i = 0; i < 3; ++i) {
            CHECK(reference::length(scene.vertices[i] - corner[i]) < 1e-6f);
            CHECK(scene.normals[i] == Vec3(0, 0, 1));
        }
        CHECK_FALSE(warns(scene, "KHR_mesh_quantization"));
    };
    check(quantised(std::vector<std::uint16_t>{0, 0, 0, 16383, 0, 0, 0, 16383, 0}, false,
                    1.0 / 16383));
    check(quantised(std::vector<std::int16_t>{0, 0, 0, 32767, 0, 0, 0, 32767, 0}, true, 1.0));
    check(quantised(std::vector<std::uint8_t>{0, 0, 0, 255, 0, 0, 0, 255, 0}, true, 1.0));
    check(quantised(std::vector<std::int8_t>{0, 0, 0, 50, 0, 0, 0, 50, 0}, false, 0.02));
    // -128 is -1, as -127 is.
    const Scene low =
        quantised(std::vector<std::int8_t>{-128, 0, 0, 127, 0, 0, 0, 127, 0}, true, 1.0);
    CHECK(low.vertices[0] == Vec3(-1, 0, 0));
}

TEST_CASE("gltf: one mesh at several nodes", "[scenes][gltf]") {
    GltfText text = square_gltf();
    const std::size_t below = text.append("nodes", {{"mesh", 0}, {"translation", {0, 0, 2}}});
    text.node({{"children", {below}}, {"translation", {10, 0, 0}}, {"scale", {1, 1, 3}}});
    const Scene scene = tests::load_gltf(text);
    CHECK(scene.triangles.size() == 4);
    CHECK(scene.vertices[4] == Vec3(9, -1, 6));
    CHECK(scene.materials.size() == 1);
}

TEST_CASE("gltf: morph targets, by the weights of the mesh or the node", "[scenes][gltf]") {
    GltfText text = square_gltf();
    const std::size_t moves =
        text.accessor("VEC3", std::vector<float>{4, 0, 0, 0, 4, 0, 0, 0, 4, 0, 0, 0});
    const std::size_t others = text.accessor("VEC3", std::vector<float>(12, 1.0f));
    json& mesh = text.root["meshes"][0];
    mesh["primitives"][0]["targets"] = {{{"POSITION", moves}}, {{"POSITION", others}}};
    CHECK(tests::load_gltf(text).vertices[0] == Vec3(-1, -1, 0));
    mesh["weights"] = {0.5, 0};
    CHECK(tests::load_gltf(text).vertices[0] == Vec3(1, -1, 0));
    CHECK(tests::load_gltf(text).vertices[2] == Vec3(1, 1, 2));
    text.root["nodes"][0]["weights"] = {0.25, 2};
    CHECK(tests::load_gltf(text).vertices[1] == Vec3(3, 2, 2));
    mesh["primitives"][0]["targets"][0]["POSITION"] = 1;
    CHECK_THROWS_WITH(tests::load_gltf(text), ContainsSubstring("accessors[1]"));
}

TEST_CASE("gltf: a skin moves vertices with its joints, not with the node", "[scenes][gltf]") {
    GltfText text = square_gltf({{"translation", {100, 0, 0}}, {"skin", 0}});
    const std::size_t joints = text.accessor(
        "VEC4", std::vector<std::uint8_t>{0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0});
    const std::size_t weights = text.accessor(
        "VEC4", std::vector<float>{1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 1, 0, 0, 0, 0.25f, 0.25f, 0, 0});
    json& primitive = text.root["meshes"][0]["primitives"][0];
    primitive["attributes"]["JOINTS_0"] = joints;
    primitive["attributes"]["WEIGHTS_0"] = weights;
    text.root["skins"] = {{{"joints", {1, 2}}}};
    text.node({{"translation", {0, 0, 2}}});
    text.node({{"translation", {0, 4, 0}}, {"scale", {2, 2, 2}}});
    Scene scene = tests::load_gltf(text);
    CHECK_FALSE(warns(scene, "skin"));
    CHECK(scene.vertices[0] == Vec3(-1, -1, 2));  // joint 0
    CHECK(scene.vertices[2] == Vec3(2, 6, 0));    // joint 1
    // The mean of (1, -1, 2) and (2, 2, 0), and weights whose sum is one half.
    CHECK(scene.vertices[1] == Vec3(1.5f, 0.5f, 1));
    CHECK(scene.vertices[3] == Vec3(-1.5f, 3.5f, 1));
    // Inverse bind matrices come first: these move by -2 in z.
    std::vector<float> matrix(32, 0.0f);
    for (std::size_t i = 0; i < 32; i += 16) {
        for (std::size_t k = 0; k < 4; ++k) matrix[i + k * 5] = 1.0f;
        matrix[i + 14] = -2.0f;
    }
    std::string bytes = tests::bytes_of(matrix);
    text.append("accessors", {{"bufferView", text.view(bytes)},
                              {"componentType", 5126},
                              {"count", 2},
                              {"type", "MAT4"}});
    text.root["skins"][0]["inverseBindMatrices"] = text.root["accessors"].size() - 1;
    CHECK(tests::load_gltf(text).vertices[0] == Vec3(-1, -1, 0));
    CHECK(tests::load_gltf(text).vertices[2] == Vec3(2, 6, -4));

    text.root["skins"][0]["joints"] = {1};
    CHECK_THROWS_WITH(tests::load_gltf(text), ContainsSubstring("vertex 1: joint 1 out of range"));
    text.root["skins"][0]["joints"] = {1, 9};
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring("skins[0]") && ContainsSubstring("node 9"));
    text.root["nodes"][0].erase("skin");
    CHECK(tests::load_gltf(text).vertices[0] == Vec3(99, -1, 0));
}

TEST_CASE("gltf: what colours and animations there are is said", "[scenes][gltf]") {
    GltfText text = square_gltf();
    json& primitive = text.root["meshes"][0]["primitives"][0];
    primitive["attributes"]["COLOR_0"] = 0;
    text.root["animations"] = {json::object()};
    const Scene scene = tests::load_gltf(text);
    for (const char* what : {"vertex colours", "animation"}) {
        CHECK(warns(scene, what));
    }
}

TEST_CASE("gltf: a bad index names mesh and primitive, in all modes", "[scenes][gltf]") {
    for (const int mode : {4, 5, 6}) {
        CHECK_THROWS_WITH(
            load_mode(mode, {0, 1, 2, 1, 2, 99}),
            ContainsSubstring("meshes[0]: primitives[0]") && ContainsSubstring("index 5") &&
                ContainsSubstring("vertex index 99 out of range") && !ContainsSubstring("restart"));
        CHECK_THROWS_WITH(load_mode(mode, {0, 1, 2, 255, 1, 2}),
                          ContainsSubstring("index 3") && ContainsSubstring("primitive restart"));
    }
}

TEST_CASE("gltf: positions that are not finite name the vertex", "[scenes][gltf]") {
    GltfText text = square_gltf();
    const std::uint32_t nan = 0x7fc00000;
    std::memcpy(&text.bytes[12], &nan, sizeof nan);
    text.root["meshes"][0]["name"] = "Floor";
    CHECK_THROWS_WITH(tests::load_gltf(text), ContainsSubstring("meshes[0] ('Floor')") &&
                                                  ContainsSubstring("vertex 1") &&
                                                  ContainsSubstring("nan"));
}
