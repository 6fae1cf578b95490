
#include <limits>

#include "reference/base/error.h"
#include "reference/contract/scene.h"
#include "tests/catch.h"

using namespace scotty::reference;
using Catch::Matchers::ContainsSubstring;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// One triangle, one material, one point light: nothing to complain about.
Scene sound_scene() {
    Scene scene;
    scene.name = "sound";
    scene.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
    scene.triangles = {{0, 1, 2}};
    scene.material_of = {0};
    scene.materials.resize(1);
    Light light;
    light.radiance = Vec3(1, 1, 1);
    scene.lights = {light};
    return scene;
}

Light emitting_square() {
    Light light;
    light.kind = LightKind::parallelogram;
    light.edge_x = Vec3(2, 0, 0);
    light.edge_y = Vec3(0, 3, 0);
    light.area = 6;
    light.radiance = Vec3(1, 1, 1);
    return light;
}

void check_rejected(const Scene& broken, const std::string& element, const std::string& what) {
    Scene scene = broken;
    CHECK_THROWS_WITH(validate_and_repair(scene), ContainsSubstring("sound") &&
                                                      ContainsSubstring(element) &&
                                                      ContainsSubstring(what));
}

}  // namespace

TEST_CASE("scene: a sound one passes without a word", "[scene]") {
    Scene scene = sound_scene();
    scene.lights.push_back(emitting_square());
    scene.normals.assign(3, Vec3(0, 0, 1));
    validate_and_repair(scene);
    CHECK(scene.warnings.empty());
}

TEST_CASE("scene: no triangles is an error", "[scene]") {
    Scene scene = sound_scene();
    scene.triangles.clear();
    scene.material_of.clear();
    check_rejected(scene, "geometry", "no triangles");
}

TEST_CASE("scene: indices out of range name the triangle", "[scene]") {
    Scene vertex = sound_scene();
    vertex.triangles[0][1] = 3;
    check_rejected(vertex, "triangle 0", "vertex index 3 out of range");
    Scene material = sound_scene();
    material.material_of[0] = 1;
    check_rejected(material, "triangle 0", "material index 1 out of range");
}

TEST_CASE("scene: arrays of unequal length are an error", "[scene]") {
    Scene normals = sound_scene();
    normals.normals.resize(2);
    check_rejected(normals, "normals", "expected one per vertex (3)");
    Scene materials = sound_scene();
    materials.material_of.clear();
    check_rejected(materials, "material indices", "expected one per triangle");
}

TEST_CASE("scene: a vertex that is not finite, or too far out, is an error in any component",
          "[scene]") {
    const int axis = GENERATE(0, 1, 2);
    const float bad = GENERATE(values<float>({kNan, kInfinity, -kInfinity, 1.1e12f}));
    Scene scene = sound_scene();
    INFO("axis " << axis << " value " << bad);
    scene.vertices[2][axis] = bad;
    check_rejected(scene, "vertex 2", "position");
}

TEST_CASE("scene: material values out of range name the material and the field", "[scene]") {
    Scene scene = sound_scene();
    SECTION("albedo above one") {
        scene.materials[0].reflectance.y = 1.5f;
        check_rejected(scene, "material 0", "reflectance");
    }
    SECTION("negative albedo") {
        scene.materials[0].reflectance.y = -0.5f;
        check_rejected(scene, "material 0", "reflectance");
    }
    SECTION("transmittance that is no number") {
        scene.materials[0].transmittance.z = kNan;
        check_rejected(scene, "material 0", "transmittance");
    }
    SECTION("negative emission") {
        scene.materials[0].emission.x = -1.0f;
        check_rejected(scene, "material 0", "emission");
    }
    SECTION("infinite emission") {
        scene.materials[0].emission.x = kInfinity;
        check_rejected(scene, "material 0", "emission");
    }
    SECTION("index of refraction zero") {
        scene.materials[0].ior = 0.0f;
        check_rejected(scene, "material 0", "index of refraction");
    }
    SECTION("unknown kind") {
        scene.materials[0].kind = static_cast<MaterialKind>(kMaterialKinds);
        check_rejected(scene, "material 0", "kind");
    }
    SECTION("a flag that is none") {
        scene.materials[0].emission_is_sampled = 2;
        check_rejected(scene, "material 0", "emission_is_sampled");
    }
}

TEST_CASE("scene: light values out of range name the light and the field", "[scene]") {
    Scene scene = sound_scene();
    scene.lights.push_back(emitting_square());
    Light& light = scene.lights[1];
    SECTION("negative radiance") {
        light.radiance.x = -1.0f;
        check_rejected(scene, "light 1", "radiance");
    }
    SECTION("a position that is no number") {
        light.position.x = kNan;
        check_rejected(scene, "light 1", "position");
    }
    SECTION("an area that its edges do not span") {
        light.area = 3.0f;
        check_rejected(scene, "light 1", "area");
    }
    SECTION("no area") {
        light.edge_y = Vec3(1, 0, 0);
        light.area = 0.0f;
        check_rejected(scene, "light 1", "area");
    }
    SECTION("a normal that is not unit") {
        light.normal = Vec3(0, 0, 2);
        check_rejected(scene, "light 1", "normal");
    }
    SECTION("a normal along an edge") {
        light.normal = Vec3(1, 0, 0);
        check_rejected(scene, "light 1", "normal");
    }
    SECTION("an edge that is infinite") {
        light.edge_x.x = kInfinity;
        check_rejected(scene, "light 1", "edge_x");
    }
    SECTION("a directional light without direction") {
        light.kind = LightKind::directional;
        light.normal = Vec3(0, 0, 0);
        check_rejected(scene, "light 1", "normal");
    }
    SECTION("unknown kind") {
        light.kind = static_cast<LightKind>(7);
        check_rejected(scene, "light 1", "kind");
    }
    SECTION("a spot light without direction, or whose cones are not one in the other") {
        light.kind = LightKind::spot;
        set_spot_cone(light, {0.9f, 0.7f});
        CHECK_NOTHROW(validate_and_repair(scene));
        for (const SpotCone& cone :
             {SpotCone{0.7f, 0.9f}, SpotCone{1.5f, 0.0f}, SpotCone{0.5f, -1.5f},
              SpotCone{1.0f, 1.0f}, SpotCone{std::nanf(""), 0.0f}, SpotCone{0.0f, std::nanf("")}}) {
            set_spot_cone(light, cone);
            check_rejected(scene, "light 1", "cone");
        }
        set_spot_cone(light, {0.9f, 0.7f});
        light.normal = Vec3(0, 0, 0);
        check_rejected(scene, "light 1", "normal");
    }
    SECTION("half the area, and a triangle, is right") {
        light.kind = LightKind::triangle;
        light.area = 3.0f;
        CHECK_NOTHROW(validate_and_repair(scene));
    }
}

TEST_CASE("scene: a camera that is not orthonormal and finite is an error", "[scene]") {
    Scene scene = sound_scene();
    SECTION("position") {
        scene.camera.position.y = kNan;
        check_rejected(scene, "camera", "position");
    }
    SECTION("length") {
        scene.camera.up = Vec3(0, 2, 0);
        check_rejected(scene, "camera", "up");
    }
    SECTION("skew") {
        scene.camera.up = normalize_or(Vec3(0.3f, 1, 0), Vec3(0, 0, 0));
        check_rejected(scene, "camera", "orthonormal");
    }
    SECTION("mirrored") {
        scene.camera.forward = Vec3(0, 0, 1);
        check_rejected(scene, "camera", "orthonormal");
    }
    SECTION("field of view") {
        scene.camera.tan_half_fov = GENERATE(values<float>({0.0f, -1.0f, kNan, kInfinity}));
        check_rejected(scene, "camera", "field of view");
    }
    SECTION("horizontal field of view") {
        scene.camera.tan_half_width = GENERATE(values<float>({-1.0f, kNan, kInfinity}));
        check_rejected(scene, "camera", "horizontal field of view");
    }
}

TEST_CASE("scene: normals are repaired, with a count", "[scene]") {
    Scene scene = sound_scene();
    scene.normals = {Vec3(0, 0, 4), Vec3(0, kNan, 1), Vec3(0, 0, 0)};
    validate_and_repair(scene);
    CHECK(scene.normals[0] == Vec3(0, 0, 1));
    CHECK(scene.normals[1] == Vec3(0, 0, 0));
    REQUIRE(scene.warnings.size() == 1);
    CHECK_THAT(scene.warnings[0], ContainsSubstring("2 normals"));
}

TEST_CASE("scene: zero-area triangles are kept and counted, thin ones are not called empty",
          "[scene]") {
    Scene scene = sound_scene();
    scene.vertices.emplace_back(1e-30f, 1e-30f, 0.0f);
    scene.triangles.push_back({0, 0, 1});
    scene.triangles.push_back({0, 1, 3});
    scene.material_of = {0, 0, 0};
    validate_and_repair(scene);
    CHECK(scene.triangles.size() == 3);
    REQUIRE(scene.warnings.size() == 1);
    CHECK_THAT(scene.warnings[0],
               ContainsSubstring("1 triangles have zero area") && ContainsSubstring("triangle 1"));
}

TEST_CASE("scene: no light and no emission is said, either one is enough", "[scene]") {
    Scene dark = sound_scene();
    dark.lights.clear();
    validate_and_repair(dark);
    REQUIRE(dark.warnings.size() == 1);
    CHECK_THAT(dark.warnings[0], ContainsSubstring("the picture is black"));
    Scene glowing = sound_scene();
    glowing.lights.clear();
    glowing.materials[0].emission = Vec3(1, 0, 0);
    validate_and_repair(glowing);
    CHECK(glowing.warnings.empty());
}

TEST_CASE("fingerprint: equal scenes are equal, names and warnings do not count", "[scene]") {
    const Scene scene = sound_scene();
    Scene renamed = scene;
    renamed.name = "other";
    renamed.source = "elsewhere";
    renamed.warnings = {"a word"};
    CHECK(fingerprint(renamed) == fingerprint(scene));
}

TEST_CASE("fingerprint: is the same on every machine", "[scene]") {
    CHECK(fingerprint(sound_scene()) == 0xe527446e6c24efffu);
}

TEST_CASE("fingerprint: every field that influences a picture changes it", "[scene]") {
    const Scene scene = sound_scene();
    Scene changed = scene;
    const int field = GENERATE(range(0, 21));
    INFO("field " << field);
    switch (field) {
        case 0:
            changed.vertices[1].y = 0.5f;
            break;
        case 1:
            changed.normals.assign(3, Vec3(0, 0, 1));
            break;
        case 2:
            changed.triangles[0] = {1, 2, 0};
            break;
        case 3:
            changed.material_of[0] = 1;
            break;
        case 4:
            changed.materials[0].kind = MaterialKind::glass;
            break;
        case 5:
            changed.materials[0].reflectance.z = 0.1f;
            break;
        case 6:
            changed.materials[0].transmittance.x = 0.1f;
            break;
        case 7:
            changed.materials[0].ior = 1.5f;
            break;
        case 8:
            changed.materials[0].emission.y = 2;
            break;
        case 9:
            changed.materials[0].emission_is_sampled = 1;
            break;
        case 10:
            changed.lights[0].kind = LightKind::environment;
            break;
        case 11:
            changed.lights[0].position.x = 1;
            break;
        case 12:
            changed.lights[0].edge_x.x = 1;
            break;
        case 13:
            changed.lights[0].edge_y.x = 1;
            break;
        case 14:
            changed.lights[0].normal.x = 1;
            break;
        case 15:
            changed.lights[0].radiance.x = 2;
            break;
        case 16:
            changed.lights[0].area = 1;
            break;
        case 17:
            changed.camera.position.z = 1;
            break;
        case 18:
            changed.camera.tan_half_fov = 0.25f;
            break;
        case 19:
            changed.camera.tan_half_width = 0.25f;
            break;
        default:
            changed.camera.forward.x = 0.1f;
            break;
    }
    CHECK(fingerprint(changed) != fingerprint(scene));
}
