/// Compressed glTF: what the encoders of the two libraries write is read back.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <meshoptimizer.h>

#include "reference/base/error.h"
#include "scenes/noise.h"
#include "tests/catch.h"
#include "tests/scenes/gltf_text.h"
#include "tests/scenes/mesh_checks.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using nlohmann::json;
using reference::Scene;
using reference::Vec3;
using tests::bytes_of;
using tests::GltfText;

namespace {

/// A wavy grid of n by n squares.
struct Grid {
    std::vector<float> positions;
    std::vector<std::uint32_t> corners;
    explicit Grid(std::uint32_t n) {
        for (std::uint32_t y = 0; y <= n; ++y) {
            for (std::uint32_t x = 0; x <= n; ++x) {
                const auto fx = static_cast<float>(x);
                const auto fy = static_cast<float>(y);
                positions.insert(positions.end(), {fx, fy, std::sin(fx) * std::cos(fy)});
                if (x == n || y == n) continue;
                const std::uint32_t a = y * (n + 1) + x;
                corners.insert(corners.end(), {a, a + 1, a + n + 2, a, a + n + 2, a + n + 1});
            }
        }
    }
    Vec3 at(std::uint32_t corner) const {
        const float* p = &positions[corner * 3];
        return {p[0], p[1], p[2]};
    }
};

/// The corners' positions of each triangle in a row, sorted: encoders change the order.
std::vector<std::array<float, 9>> sorted_triangles(const std::vector<Vec3>& vertices,
                                                   const std::vector<std::uint32_t>& corners) {
    std::vector<std::array<float, 9>> out;
    for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
        std::array<std::array<float, 3>, 3> triangle{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& v = vertices[corners[i + k]];
            triangle[k] = {v.x, v.y, v.z};
        }
        std::rotate(triangle.begin(), std::min_element(triangle.begin(), triangle.end()),
                    triangle.end());
        std::array<float, 9> flat{};
        for (std::size_t k = 0; k < 9; ++k) flat[k] = triangle[k / 3][k % 3];
        out.push_back(flat);
    }
    std::sort(out.begin(), out.end());
    return out;
}

void check_same_triangles(const Scene& scene, const Grid& grid) {
    std::vector<std::uint32_t> corners;
    for (const auto& triangle : scene.triangles) {
        corners.insert(corners.end(), triangle.begin(), triangle.end());
    }
    std::vector<Vec3> expected;
    for (std::uint32_t i = 0; i < grid.positions.size() / 3; ++i) expected.push_back(grid.at(i));
    CHECK(sorted_triangles(scene.vertices, corners) == sorted_triangles(expected, grid.corners));
}

/// A file whose primitive has the extension only, as compressors write it.
GltfText draco_text(const Grid& grid, int speed, bool with_normals = false) {
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(static_cast<int>(grid.corners.size() / 3));
    const int position =
        builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const int normal =
        with_normals ? builder.AddAttribute(draco::GeometryAttribute::NORMAL, 3, draco::DT_FLOAT32)
                     : -1;
    const Vec3 up(0.0f, 0.0f, 1.0f);
    for (std::uint32_t i = 0; i < grid.corners.size(); i += 3) {
        const draco::FaceIndex face(i / 3);
        const Vec3 a = grid.at(grid.corners[i]);
        const Vec3 b = grid.at(grid.corners[i + 1]);
        const Vec3 c = grid.at(grid.corners[i + 2]);
        builder.SetAttributeValuesForFace(position, face, &a, &b, &c);
        if (with_normals) builder.SetAttributeValuesForFace(normal, face, &up, &up, &up);
    }
    const auto mesh = builder.Finalize();
    draco::Encoder encoder;
    encoder.SetSpeedOptions(speed, speed);
    draco::EncoderBuffer buffer;
    REQUIRE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    GltfText text;
    const std::size_t view = text.view(std::string(buffer.data(), buffer.size()));
    json attributes = {{"POSITION", mesh->attribute(position)->unique_id()}};
    if (with_normals) attributes["NORMAL"] = mesh->attribute(normal)->unique_id();
    // What the extension replaces has a count and no data.
    const std::size_t accessor = text.append(
        "accessors", {{"componentType", 5126}, {"count", mesh->num_points()}, {"type", "VEC3"}});
    const std::size_t indices = text.append(
        "accessors", {{"componentType", 5125}, {"count", grid.corners.size()}, {"type", "SCALAR"}});
    text.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    text.node({{"mesh", text.mesh({{"attributes", {{"POSITION", accessor}}},
                                   {"indices", indices},
                                   {"extensions",
                                    {{"KHR_draco_mesh_compression",
                                      {{"bufferView", view}, {"attributes", attributes}}}}}})}});
    return text;
}

json meshopt(std::size_t offset, std::size_t length, std::size_t stride, std::size_t count,
             const char* mode) {
    return {{"buffer", 0},          {"byteOffset", offset}, {"byteLength", length},
            {"byteStride", stride}, {"count", count},       {"mode", mode}};
}

/// A file whose views are compressed, over a fallback buffer that is not there.
GltfText meshopt_text(const Grid& grid, bool as_sequence) {
    const std::size_t vertices = grid.positions.size() / 3;
    std::string packed(meshopt_encodeVertexBufferBound(vertices, 12), '\0');
    packed.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(packed.data()),
                                             packed.size(), grid.positions.data(), vertices, 12));
    std::string indices(std::max(meshopt_encodeIndexBufferBound(grid.corners.size(), vertices),
                                 meshopt_encodeIndexSequenceBound(grid.corners.size(), vertices)),
                        '\0');
    auto* to = reinterpret_cast<unsigned char*>(indices.data());
    indices.resize(as_sequence ? meshopt_encodeIndexSequence(
                                     to, indices.size(), grid.corners.data(), grid.corners.size())
                               : meshopt_encodeIndexBuffer(to, indices.size(), grid.corners.data(),
                                                           grid.corners.size()));
    GltfText text;
    text.bytes = packed + indices;
    const auto view = [&](std::size_t size, const json& extension) {
        return text.append("bufferViews",
                           {{"buffer", 1},
                            {"byteLength", size},
                            {"extensions", {{"EXT_meshopt_compression", extension}}}});
    };
    const std::size_t v0 =
        view(vertices * 12, meshopt(0, packed.size(), 12, vertices, "ATTRIBUTES"));
    const std::size_t v1 =
        view(grid.corners.size() * 4, meshopt(packed.size(), indices.size(), 4, grid.corners.size(),
                                              as_sequence ? "INDICES" : "TRIANGLES"));
    const std::size_t positions = text.append(
        "accessors",
        {{"bufferView", v0}, {"componentType", 5126}, {"count", vertices}, {"type", "VEC3"}});
    const std::size_t corners = text.append("accessors", {{"bufferView", v1},
                                                          {"componentType", 5125},
                                                          {"count", grid.corners.size()},
                                                          {"type", "SCALAR"}});
    text.root["extensionsRequired"] = {"EXT_meshopt_compression"};
    text.node(
        {{"mesh", text.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", corners}})}});
    return text;
}

/// Loads with single bytes of the buffer changed: a scene or an error, nothing else.
void check_damage(const GltfText& whole) {
    const tests::TemporaryFiles files;
    for (std::uint32_t i = 0; i < 200; ++i) {
        GltfText text = whole;
        char& byte = text.bytes[scenes::hash32(i) %
                                std::min<std::size_t>(text.bytes.size(), i < 100 ? 40 : 1u << 20)];
        byte = static_cast<char>(scenes::hash32(i + 1000u));
        try {
            files.load("a.glb", text.glb());
        } catch (const reference::Error& error) {
            CHECK(error.kind() == reference::ErrorKind::bad_input);
        }
    }
}

}  // namespace

TEST_CASE("gltf: Draco meshes, by both of its methods", "[scenes][gltf][compression]") {
    const Grid grid(9);
    for (const int speed : {0, 5, 10}) {
        const Scene scene = tests::load_gltf(draco_text(grid, speed));
        check_same_triangles(scene, grid);
    }
    const Scene scene = tests::load_gltf(draco_text(grid, 5, true));
    check_same_triangles(scene, grid);
    REQUIRE(scene.normals.size() == scene.vertices.size());
    CHECK(scene.normals[0].z == Approx(1.0f));
}

TEST_CASE("gltf: meshoptimizer's views, over a fallback buffer that is missing",
          "[scenes][gltf][compression]") {
    const Grid grid(9);
    check_same_triangles(tests::load_gltf(meshopt_text(grid, false)), grid);
    check_same_triangles(tests::load_gltf(meshopt_text(grid, true)), grid);
}

TEST_CASE("gltf: compressed data that is damaged is an error and no crash",
          "[scenes][gltf][compression][hostile]") {
    const Grid grid(9);
    check_damage(draco_text(grid, 5));
    check_damage(draco_text(grid, 10));
    check_damage(meshopt_text(grid, false));
    check_damage(meshopt_text(grid, true));
}

TEST_CASE("gltf: compressed data that contradicts the file is named with its element",
          "[scenes][gltf][compression]") {
    const Grid grid(2);
    GltfText text = draco_text(grid, 5);
    json& primitive = text.root["meshes"][0]["primitives"][0];
    json& draco = primitive["extensions"]["KHR_draco_mesh_compression"];
    const std::string place = "primitives[0]: extensions: KHR_draco_mesh_compression";
    draco["attributes"]["POSITION"] = 77;
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring(place) && ContainsSubstring("no attribute 77"));
    draco["attributes"] = json::object();
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring(place) && ContainsSubstring("POSITION is missing"));
    draco["bufferView"] = 77;
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring(place) && ContainsSubstring("bufferViews[77]"));

    const auto refused = [&](const char* key, const json& value, const char* what) {
        GltfText packed = meshopt_text(grid, false);
        packed.root["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][key] = value;
        INFO(key);
        CHECK_THROWS_WITH(
            tests::load_gltf(packed),
            ContainsSubstring("bufferViews[0]: extensions: EXT_meshopt_compression") &&
                ContainsSubstring(what));
    };
    refused("mode", "POINTS", "'POINTS'");
    refused("byteStride", 10, "elements of 10 bytes");
    refused("byteStride", 512, "elements of 512 bytes");
    refused("count", 1u << 30, "do not fit");
    refused("count", 100, "damaged");
    refused("filter", "OCTAHEDRAL", "does not go with a byteStride of 12");
    refused("byteLength", 3, "damaged");
    refused("byteLength", 1u << 20, "its buffer has");
}
