/// Scenes, lights, cameras and materials of glTF files.

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/scenes/gltf_text.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using nlohmann::json;
using reference::LightKind;
using reference::Material;
using reference::MaterialKind;
using reference::Scene;
using reference::Vec3;
using tests::GltfText;
using tests::square_gltf;
using tests::TemporaryFiles;
using tests::warns;

namespace {

Scene load_material(const json& material) {
    GltfText text = square_gltf();
    text.root["meshes"][0]["primitives"][0]["material"] = 0;
    text.root["materials"] = json::array({material});
    return tests::load_gltf(text);
}

Material material_of(const json& material) {
    const Scene scene = load_material(material);
    return scene.materials.at(scene.material_of.at(0));
}

json metal(double metallic, double roughness) {
    return {{"baseColorFactor", {0.9, 0.8, 0.7, 1}},
            {"metallicFactor", metallic},
            {"roughnessFactor", roughness}};
}

const json kPaint = {
    {"pbrMetallicRoughness", {{"baseColorFactor", {0.8, 0.7, 0.6, 1}}, {"metallicFactor", 0}}}};

json perspective(double yfov) {
    return {{"type", "perspective"}, {"perspective", {{"yfov", yfov}, {"znear", 0.1}}}};
}

}  // namespace

TEST_CASE("gltf: transforms, camera and lights", "[scenes][gltf]") {
    GltfText text = square_gltf({{"translation", {0, 0, 1}}, {"scale", {2, 2, 2}}});
    text.root["meshes"][0]["primitives"][0]["material"] = text.append("materials", kPaint);
    text.node({{"camera", text.append("cameras", perspective(0.8))}, {"translation", {0, 0, 5}}});
    json point = text.light_node(
        text.light({{"type", "point"}, {"color", {1, 0.5, 0.25}}, {"intensity", 4}}));
    point["translation"] = {0, 3, 0};
    text.node(point);
    json sun = text.light_node(text.light({{"type", "directional"}, {"intensity", 2}}));
    sun["rotation"] = {-0.70710678, 0, 0, 0.70710678};
    text.node(sun);
    const Scene scene = tests::load_gltf(text);
    INFO(tests::all_warnings(scene));
    CHECK(scene.warnings.empty());
    CHECK(scene.vertices[1] == Vec3(2, -2, 1));
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
    CHECK(scene.lights[1].radiance == Vec3(2, 2, 2));
}

TEST_CASE("gltf: which scene is shown", "[scenes][gltf]") {
    GltfText text = square_gltf();
    text.root["nodes"].push_back({{"mesh", 0}, {"translation", {7, 0, 0}}});
    text.root["scenes"].push_back({{"nodes", {1}}});
    text.root["scene"] = 1;
    CHECK(tests::load_gltf(text).vertices[0] == Vec3(6, -1, 0));
    CHECK(warns(tests::load_gltf(text), "a further scene"));
    text.root.erase("scene");
    CHECK(tests::load_gltf(text).vertices[0] == Vec3(-1, -1, 0));
    CHECK(warns(tests::load_gltf(text), "does not say which of its scenes"));
    text.root.erase("scenes");
    CHECK(tests::load_gltf(text).triangles.size() == 4);
    text.root["scene"] = 3;
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring("scenes[3]") && ContainsSubstring("out of range"));
}

TEST_CASE("gltf: what no scene shows may be wrong", "[scenes][gltf]") {
    GltfText text = square_gltf();
    text.append("meshes", {{"primitives", {{{"attributes", {{"POSITION", 77}}}}}}});
    text.append("accessors", {{"bufferView", 99}});
    CHECK(tests::load_gltf(text).triangles.size() == 2);
}

TEST_CASE("gltf: lights are joined to nodes by number, whatever their names", "[scenes][gltf]") {
    GltfText text = square_gltf();
    const std::size_t shared = text.light({{"type", "point"}, {"name", "Light"}, {"intensity", 1}});
    const std::size_t other = text.light({{"type", "point"}, {"name", "Light"}, {"intensity", 3}});
    for (const std::size_t index : {shared, shared, other}) {
        json node = text.light_node(index);
        node["name"] = "Light";
        text.node(node);
    }
    text.node({{"name", "Light"}, {"camera", text.append("cameras", perspective(1))}});
    const Scene scene = tests::load_gltf(text);
    REQUIRE(scene.lights.size() == 3);
    CHECK(scene.lights[1].radiance == Vec3(1, 1, 1));
    CHECK(scene.lights[2].radiance == Vec3(3, 3, 3));
    CHECK_FALSE(warns(scene, "further camera"));
    text.node(text.light_node(9));
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring("lights[9]") && ContainsSubstring("nodes[5]"));
}

TEST_CASE("gltf: a light's range is noted, its values are checked", "[scenes][gltf]") {
    const auto with = [](const json& light) {
        GltfText text = square_gltf();
        text.node(text.light_node(text.light(light)));
        return tests::load_gltf(text);
    };
    CHECK(warns(with({{"type", "point"}, {"range", 0.5}}), "range"));
    CHECK_THROWS_WITH(with({{"type", "point"}, {"intensity", -1}}),
                      ContainsSubstring("lights[0]") && ContainsSubstring("negative"));
    const Scene spot = with({{"type", "spot"},
                             {"intensity", 5},
                             {"spot", {{"innerConeAngle", 0.3}, {"outerConeAngle", 0.6}}}});
    REQUIRE(spot.lights.size() == 1);
    CHECK(spot.lights[0].kind == LightKind::spot);
    CHECK(spot.lights[0].normal == Vec3(0, 0, -1));
    CHECK(reference::spot_cone(spot.lights[0]).inner == Approx(std::cos(0.3)));
    CHECK(reference::spot_cone(spot.lights[0]).outer == Approx(std::cos(0.6)));
    const Scene standard = with({{"type", "spot"}});
    CHECK(reference::spot_cone(standard.lights[0]).inner == 1.0f);
    CHECK(reference::spot_cone(standard.lights[0]).outer == Approx(std::sqrt(0.5)));
    CHECK_THROWS_WITH(with({{"type", "spot"}, {"spot", {{"innerConeAngle", 1.0}}}}),
                      ContainsSubstring("lights[0]") && ContainsSubstring("innerConeAngle"));
    CHECK_THROWS_WITH(with({{"type", "area"}}),
                      ContainsSubstring("lights[0]") && ContainsSubstring("'area'"));
}

TEST_CASE("gltf: cameras keep their numbers, and the first that a node has is used",
          "[scenes][gltf]") {
    GltfText text = square_gltf();
    text.append("cameras", perspective(0.2));
    text.append("cameras", perspective(1.2));
    text.append("cameras", {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}}}});
    text.node({{"camera", 2}});
    text.node({{"camera", 1}});
    text.node({{"camera", 0}});
    const Scene scene = tests::load_gltf(text);
    CHECK(scene.camera.tan_half_fov == Approx(std::tan(0.6)));
    CHECK(warns(scene, "orthographic"));
    CHECK(warns(scene, "a further camera"));
    text.root["cameras"][1] = perspective(-1);
    CHECK_THROWS_WITH(tests::load_gltf(text),
                      ContainsSubstring("cameras[1]") && ContainsSubstring("found -1"));
}

TEST_CASE("gltf: materials", "[scenes][gltf]") {
    const Material mirror = material_of({{"pbrMetallicRoughness", metal(1, 0)}});
    CHECK(mirror.kind == MaterialKind::mirror);
    CHECK(mirror.reflectance == Vec3(0.9f, 0.8f, 0.7f));
    CHECK(material_of(json::object()).reflectance == Vec3(1, 1, 1));
    const Material rough = material_of({{"pbrMetallicRoughness", metal(1, 0.25)}});
    CHECK(rough.kind == MaterialKind::conductor);
    CHECK(rough.ior == 0.25f);
    CHECK(rough.reflectance == Vec3(0.9f, 0.8f, 0.7f));
    CHECK(load_material({{"pbrMetallicRoughness", metal(1, 0.25)}}).warnings.size() ==
          load_material({{"pbrMetallicRoughness", metal(1, 0)}}).warnings.size());
    CHECK(material_of({{"pbrMetallicRoughness", metal(0.5, 1)}}).kind == MaterialKind::conductor);
    CHECK(material_of({{"pbrMetallicRoughness", metal(0.49, 1)}}).kind == MaterialKind::diffuse);
    CHECK(warns(load_material({{"pbrMetallicRoughness", metal(0.5, 1)}}), "between metal and not"));
    CHECK(warns(load_material({{"pbrMetallicRoughness", metal(0, 0.5)}}),
                "gloss on what is no metal"));
    json glass = {{"pbrMetallicRoughness", metal(0, 0)},
                  {"extensions",
                   {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                    {"KHR_materials_ior", {{"ior", 1.25}}}}}};
    CHECK(material_of(glass).kind == MaterialKind::glass);
    CHECK(material_of(glass).ior == 1.25f);
    CHECK(material_of(glass).transmittance == Vec3(0.9f, 0.8f, 0.7f));
    CHECK(warns(load_material(glass), "thin wall"));
    glass["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1}};
    CHECK(!warns(load_material(glass), "thin wall"));
    glass["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = 0.5;
    CHECK(material_of(glass).kind == MaterialKind::diffuse);
    CHECK(warns(load_material(glass), "partial transmission"));
}

TEST_CASE("gltf: emission", "[scenes][gltf]") {
    json glow = {{"emissiveFactor", {0.5, 0.25, 1}}};
    CHECK(material_of(glow).emission == Vec3(0.5f, 0.25f, 1));
    CHECK(load_material(glow).lights.size() == 2);
    glow["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 8;
    CHECK(material_of(glow).emission == Vec3(4, 2, 8));
    CHECK_FALSE(warns(load_material(glow), "front side only"));
    glow["doubleSided"] = true;
    CHECK(warns(load_material(glow), "front side only"));
    glow["emissiveTexture"] = {{"index", 0}};
    CHECK(warns(load_material(glow), "an emissive texture is not supported"));
    CHECK(reference::is_zero(material_of(glow).emission));
    CHECK_THROWS_WITH(load_material({{"emissiveFactor", {-1, 0, 0}}}),
                      ContainsSubstring("materials[0]"));
}

TEST_CASE("gltf: what a material has that is not supported is said", "[scenes][gltf]") {
    const json unlit = {{"extensions", {{"KHR_materials_unlit", json::object()}}}};
    CHECK(warns(load_material(unlit), "unlit"));
    CHECK_FALSE(warns(load_material(unlit), "metal"));
    json textured = kPaint;
    textured["normalTexture"] = {{"index", 0}};
    textured["occlusionTexture"] = {{"index", 0}};
    textured["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    CHECK(warns(load_material(textured),
                "a texture is not supported: the plain colour is used (2 "
                "times)"));
    const json old = {
        {"extensions",
         {{"KHR_materials_pbrSpecularGlossiness", {{"diffuseFactor", {0.1, 0.2, 0.3, 1}}}}}}};
    CHECK(material_of(old).reflectance == Vec3(0.1f, 0.2f, 0.3f));
    CHECK(warns(load_material(old), "specular"));
}

TEST_CASE("gltf: alpha is opaque, invisible or noted", "[scenes][gltf]") {
    const auto with = [](const char* mode, double alpha, bool textured) {
        json material = kPaint;
        material["alphaMode"] = mode;
        material["pbrMetallicRoughness"]["baseColorFactor"][3] = alpha;
        if (textured) material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
        return load_material(material);
    };
    CHECK_FALSE(warns(with("OPAQUE", 0.2, false), "opaque"));
    CHECK_FALSE(warns(with("MASK", 0.6, false), "opaque"));
    CHECK(warns(with("MASK", 0.6, true), "an alpha mask"));
    CHECK(warns(with("BLEND", 0.6, false), "partial opacity"));
    CHECK(warns(with("BLEND", 1.0, true), "partial opacity"));
    CHECK_THROWS_WITH(with("MASK", 0.4, false),
                      ContainsSubstring("no triangles") && ContainsSubstring("all transparent"));
    CHECK_THROWS_WITH(with("FADE", 1.0, false), ContainsSubstring("'FADE'"));
}
