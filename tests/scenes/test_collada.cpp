
#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/scenes/collada_text.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::Light;
using reference::LightKind;
using reference::MaterialKind;
using reference::Scene;
using reference::Vec3;
using tests::ColladaText;
using tests::TemporaryFiles;
using tests::warns;

namespace {

void check_close(const Vec3& found, const Vec3& expected) {
    INFO("found " << found.x << " " << found.y << " " << found.z);
    CHECK(reference::length(found - expected) < 1e-5f);
}

}  // namespace

TEST_CASE("collada: a plain file loads without a warning", "[scenes][collada]") {
    const Scene scene = load(ColladaText{});
    INFO(tests::all_warnings(scene));
    CHECK(scene.warnings.empty());
    CHECK(scene.name == "scene.dae");
    CHECK(scene.triangles.size() == 2);
    CHECK(scene.vertices.size() == 4);
    CHECK(scene.normals == std::vector<Vec3>(4, Vec3(0, 0, 1)));
    CHECK(scene.materials[0].reflectance == Vec3(0.1f, 0.2f, 0.3f));
    CHECK(tests::front_of(scene, 0) == Vec3(0, 0, 1));
}

TEST_CASE("collada: up axes are turned to y, exactly", "[scenes][collada]") {
    ColladaText text;
    text.mesh_transform = "<translate>0.1 0.2 0.3</translate>";
    CHECK(load(text).vertices[0] == Vec3(0.1f, 0.2f, 0.3f));
    text.up_axis = "Z_UP";
    CHECK(load(text).vertices[0] == Vec3(0.1f, 0.3f, -0.2f));
    text.up_axis = "X_UP";
    CHECK(load(text).vertices[0] == Vec3(-0.2f, 0.1f, 0.3f));
    text.up_axis = "UPWARDS";
    CHECK_THROWS_WITH(load(text), ContainsSubstring("up_axis") && ContainsSubstring("UPWARDS"));
}

TEST_CASE("collada: units become metres", "[scenes][collada]") {
    ColladaText text;
    text.unit = std::string("0.5");
    const Scene scene = load(text);
    CHECK(scene.vertices[2] == Vec3(0.5f, 0.5f, 0));
    check_close(scene.camera.position, Vec3(0, 0, 2.5f));
    text.unit = std::string("0");
    CHECK_THROWS_WITH(load(text), ContainsSubstring("<unit>") && ContainsSubstring("more than 0"));
}

TEST_CASE("collada: transforms apply in order, all of them", "[scenes][collada]") {
    ColladaText text;
    SECTION("scale, each axis its own") {
        text.mesh_transform = "<translate>0 0 1</translate><scale>2 3 4</scale>";
        CHECK(load(text).vertices[2] == Vec3(2, 3, 1));
    }
    SECTION("z too") {
        text.mesh_transform = "<scale>2 3 4</scale><translate>0 0 1</translate>";
        CHECK(load(text).vertices[2] == Vec3(2, 3, 4));
    }
    SECTION("rotation is an axis and an angle in degrees") {
        text.mesh_transform = "<rotate>0 0 2 90</rotate>";
        check_close(load(text).vertices[1], Vec3(0, 1, 0));
    }
    SECTION("matrix, row by row") {
        text.mesh_transform = "<matrix>0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1</matrix>";
        CHECK(load(text).vertices[1] == Vec3(5, 7, 7));
    }
    SECTION("nodes inside nodes") {
        text.mesh_transform = "<translate>1 0 0</translate>";
        text.more_nodes =
            "<node><translate>0 10 0</translate><node><scale>2 2 2</scale>"
            "<instance_geometry url=\"#square\"/></node></node>";
        const Scene scene = load(text);
        CHECK(scene.triangles.size() == 4);
        CHECK(scene.vertices[6] == Vec3(2, 12, 0));
        CHECK(warns(scene, "a mesh without material"));
    }
    SECTION("skew is named") {
        text.mesh_transform = "<skew>1 2 3 4 5 6 7</skew>";
        CHECK(warns(load(text), "<skew>"));
    }
}

TEST_CASE("collada: normals follow a transform that is not uniform", "[scenes][collada]") {
    ColladaText text;
    text.mesh_transform = "<rotate>0 1 0 45</rotate><scale>1 1 3</scale>";
    const Scene scene = load(text);
    check_close(scene.normals[0], tests::front_of(scene, 0));
}

TEST_CASE("collada: a mirroring transform leaves fronts in front", "[scenes][collada]") {
    ColladaText text;
    text.mesh_transform = "<scale>-1 1 1</scale>";
    const Scene scene = load(text);
    CHECK(tests::front_of(scene, 0) == Vec3(0, 0, 1));
    CHECK(scene.normals[0] == Vec3(0, 0, 1));
    CHECK(scene.warnings.empty());
}

TEST_CASE("collada: winding against normals is named", "[scenes][collada]") {
    ColladaText text;
    text.geometry = tests::replaced(text.geometry, ">0 0 1<", ">0 0 -1<");
    CHECK(warns(load(text), "winding and normals disagree"));
}

TEST_CASE("collada: library nodes are instanced, a circle of them is an error",
          "[scenes][collada]") {
    ColladaText text;
    text.libraries =
        "<library_nodes><node id=\"twice\"><translate>0 0 2</translate>"
        "<instance_geometry url=\"#square\"/></node></library_nodes>";
    text.more_nodes = "<node><instance_node url=\"#twice\"/></node>";
    CHECK(load(text).vertices[4] == Vec3(0, 0, 2));
    text.libraries =
        "<library_nodes><node id=\"twice\"><instance_node url=\"#twice\"/></node>"
        "</library_nodes>";
    CHECK_THROWS_WITH(load(text), ContainsSubstring("in a circle"));
}

TEST_CASE("collada: vertices merge by position and normal index, not more", "[scenes][collada]") {
    ColladaText text;
    text.geometry =
        tests::replaced(text.geometry, "count=\"3\">0 0 1<", "count=\"6\">0 0 1 0 0 1<");
    text.geometry = tests::replaced(text.geometry, "#sna\" count=\"1\"", "#sna\" count=\"2\"");
    text.geometry = tests::replaced(text.geometry, "count=\"1\"><input", "count=\"2\"><input");
    text.geometry = tests::replaced(text.geometry, "<vcount>4</vcount><p>0 0 1 0 2 0 3 0</p>",
                                    "<vcount>3 3</vcount><p>0 0 1 0 2 0 0 0 2 1 3 1</p>");
    const Scene scene = load(text);
    CHECK(scene.vertices.size() == 5);
    CHECK(scene.vertices[scene.triangles[0][2]] == scene.vertices[scene.triangles[1][1]]);
    CHECK(scene.triangles[0][0] == scene.triangles[1][0]);
}

TEST_CASE("collada: triangles and polygons are read as polylists are", "[scenes][collada]") {
    ColladaText text;
    const std::string head = "<polylist material=\"paint\" count=\"1\">";
    const std::string body = "<vcount>4</vcount><p>0 0 1 0 2 0 3 0</p></polylist>";
    SECTION("triangles") {
        text.geometry =
            tests::replaced(text.geometry, head, "<triangles material=\"paint\" count=\"2\">");
        text.geometry =
            tests::replaced(text.geometry, body, "<p>0 0 1 0 2 0 0 0 2 0 3 0</p></triangles>");
    }
    SECTION("polygons") {
        text.geometry =
            tests::replaced(text.geometry, head, "<polygons material=\"paint\" count=\"1\">");
        text.geometry = tests::replaced(text.geometry, body, "<p>0 0 1 0 2 0 3 0</p></polygons>");
    }
    CHECK(reference::fingerprint(load(text)) == reference::fingerprint(load(ColladaText{})));
}

TEST_CASE("collada: primitives that are no polygons are named", "[scenes][collada]") {
    ColladaText text;
    text.geometry =
        tests::replaced(text.geometry, "</mesh>",
                        "<lines count=\"0\"/><lines count=\"0\"/><linestrips count=\"0\"/></mesh>");
    const Scene scene = load(text);
    CHECK(warns(scene, "<lines> is not supported: left out (2 times)"));
    CHECK(warns(scene, "<linestrips>"));
}

TEST_CASE("collada: an analytic sphere becomes a smooth, closed mesh", "[scenes][collada]") {
    ColladaText text;
    text.geometry =
        "<geometry id=\"square\"><extra><technique profile=\"CMU462\"><sphere><radius>.5"
        "</radius></sphere></technique></extra></geometry>";
    text.mesh_transform = "<translate>0 0 -3</translate><scale>2 2 2</scale>";
    const Scene scene = load(text);
    CHECK(warns(scene, "an analytic sphere is approximated"));
    CHECK(scene.materials[0].reflectance == Vec3(0.1f, 0.2f, 0.3f));
    CHECK(tests::open_edges(scene, 0) == 0);
    CHECK(tests::worst_normal(scene) < 1e-5f);
    for (std::size_t i = 0; i < scene.vertices.size(); i += 97) {
        check_close(scene.vertices[i] - Vec3(0, 0, -3), scene.normals[i]);
    }
    text.geometry = tests::replaced(text.geometry, ".5", "0");
    CHECK_THROWS_WITH(load(text), ContainsSubstring("radius"));
}

TEST_CASE("collada: a geometry of an unknown kind is named, an empty scene is an error",
          "[scenes][collada]") {
    ColladaText text;
    text.more_nodes = "<node><instance_geometry url=\"#nurbs\"/></node>";
    text.geometry += "<geometry id=\"nurbs\"><spline/></geometry>";
    CHECK(warns(load(text), "<spline> is not supported"));
    text.geometry = "<geometry id=\"square\"><spline/></geometry><geometry id=\"nurbs\"/>";
    CHECK_THROWS_WITH(load(text), ContainsSubstring("no triangles"));
}

TEST_CASE("collada: material extras", "[scenes][collada]") {
    ColladaText text;
    SECTION("mirror") {
        text.extra = "<mirror><reflectance>0.3 0.4 0.5</reflectance></mirror>";
        const auto material = load(text).materials[0];
        CHECK(material.kind == MaterialKind::mirror);
        CHECK(material.reflectance == Vec3(0.3f, 0.4f, 0.5f));
    }
    SECTION("rough mirror") {
        text.extra =
            "<mirror><reflectance>0.3 0.4 0.5</reflectance><roughness>0.25</roughness></mirror>";
        const auto material = load(text).materials[0];
        CHECK(material.kind == MaterialKind::conductor);
        CHECK(material.ior == 0.25f);
        CHECK(material.reflectance == Vec3(0.3f, 0.4f, 0.5f));
        text.extra = tests::replaced(text.extra, "0.25", "-1");
        CHECK_THROWS_WITH(load(text), ContainsSubstring("roughness: expected 0 to 1, found -1"));
    }
    SECTION("glass") {
        text.extra =
            "<glass><reflectance>1 1 1</reflectance><transmittance>1 0.75 0.5"
            "</transmittance><roughness>0</roughness><ior>1.45</ior></glass>";
        const Scene scene = load(text);
        CHECK(scene.materials[0].kind == MaterialKind::glass);
        CHECK(scene.materials[0].reflectance == Vec3(1, 1, 1));
        CHECK(scene.materials[0].transmittance == Vec3(1, 0.75f, 0.5f));
        CHECK(scene.materials[0].ior == 1.45f);
        CHECK(load(text, "#camera=file").warnings.empty());
        text.extra = tests::replaced(text.extra, "<roughness>0<", "<roughness>0.2<");
        CHECK(warns(load(text), "roughness of <glass>"));
        text.extra = tests::replaced(text.extra, "1.45", "0");
        CHECK_THROWS_WITH(load(text), ContainsSubstring("<ior>") && ContainsSubstring("found 0"));
    }
    SECTION("diffuse wins over the common profile") {
        text.extra = "<diffuse><reflectance>0.7 0.7 0.7</reflectance></diffuse>";
        CHECK(load(text).materials[0].reflectance == Vec3(0.7f, 0.7f, 0.7f));
    }
    SECTION("refraction") {
        text.extra = "<refraction><transmittance>1 1 1</transmittance><ior>1.3</ior></refraction>";
        const Scene scene = load(text);
        CHECK(scene.materials[0].kind == MaterialKind::glass);
        CHECK(scene.materials[0].reflectance == Vec3(0, 0, 0));
        CHECK(warns(scene, "<refraction> is approximated"));
    }
    SECTION("emission is light, not an albedo") {
        text.extra = "<emission><radiance>10 9 8</radiance></emission>";
        const auto material = load(text).materials[0];
        CHECK(material.kind == MaterialKind::diffuse);
        CHECK(material.reflectance == Vec3(0, 0, 0));
        CHECK(material.emission == Vec3(10, 9, 8));
    }
    SECTION("anything else is named, once") {
        text.extra = "<microfacet/>";
        const Scene scene = load(text);
        CHECK(warns(scene, "<microfacet> is not supported"));
        CHECK(scene.materials[0].reflectance == Vec3(0.1f, 0.2f, 0.3f));
    }
    SECTION("a missing value is an error") {
        text.extra = "<mirror/>";
        CHECK_THROWS_WITH(load(text),
                          ContainsSubstring("<mirror>") && ContainsSubstring("<reflectance>"));
    }
    SECTION("a tint beyond 1 is clamped, and said") {
        text.extra = "<mirror><reflectance>2 0.4 0.5</reflectance></mirror>";
        CHECK(load(text).materials[0].reflectance.x == 1.0f);
        CHECK(warns(load(text), "clamped"));
    }
}

TEST_CASE("collada: the common profile: what it has and what is left out", "[scenes][collada]") {
    ColladaText text;
    text.common =
        "<phong><emission><color>1 2 3 1</color></emission><diffuse><texture/></diffuse>"
        "<specular><color>1 1 1 1</color></specular><transparency><float>0.5</float>"
        "</transparency></phong>";
    const Scene scene = load(text);
    CHECK(scene.materials[0].emission == Vec3(1, 2, 3));
    CHECK(scene.materials[0].reflectance == Vec3(0.5f, 0.5f, 0.5f));
    CHECK(warns(scene, "texture of <diffuse>"));
    CHECK(warns(scene, "specular highlights"));
    CHECK(warns(scene, "transparency"));
}

TEST_CASE("collada: animation is named", "[scenes][collada]") {
    ColladaText text;
    text.libraries = "<library_animations><animation/><animation/></library_animations>";
    CHECK(warns(load(text), "animation is not supported: the scene stands still (2 times)"));
}

TEST_CASE("collada: common lights", "[scenes][collada]") {
    ColladaText text;
    const auto light = [&](const std::string& content) {
        text.light = "<technique_common>" + content + "</technique_common>";
        return load(text);
    };
    text.light_transform = "<translate>1 2 3</translate><rotate>1 0 0 -90</rotate>";
    SECTION("point") {
        const Scene scene = light("<point><color>4 5 6</color></point>");
        CHECK(scene.lights[0].kind == LightKind::point);
        CHECK(scene.lights[0].position == Vec3(1, 2, 3));
        CHECK(scene.lights[0].radiance == Vec3(4, 5, 6));
        CHECK(scene.warnings.empty());
    }
    SECTION("directional shines along -z of its node, whatever its place") {
        const Scene scene = light("<directional><color>1 1 1</color></directional>");
        CHECK(scene.lights[0].kind == LightKind::directional);
        check_close(scene.lights[0].normal, Vec3(0, -1, 0));
    }
    SECTION("ambient") {
        const Scene scene = light("<ambient><color>1 2 3</color></ambient>");
        CHECK(scene.lights[0].kind == LightKind::environment);
        CHECK(scene.lights[0].radiance == Vec3(1, 2, 3));
    }
    SECTION("spot: its angle is that from one side of the cone to the other") {
        const auto spot = [&](const std::string& falloff) {
            return light("<spot><color>1 2 3</color>" + falloff + "</spot>");
        };
        const Scene scene = spot("<falloff_angle>60</falloff_angle>");
        CHECK(scene.lights[0].kind == LightKind::spot);
        CHECK(scene.lights[0].position == Vec3(1, 2, 3));
        CHECK(scene.lights[0].radiance == Vec3(1, 2, 3));
        check_close(scene.lights[0].normal, Vec3(0, -1, 0));
        CHECK(reference::spot_cone(scene.lights[0]).outer == Approx(std::sqrt(0.75)));
        CHECK(reference::spot_cone(scene.lights[0]).inner == Approx(std::sqrt(0.75)));
        CHECK(scene.warnings.empty());
        CHECK(reference::spot_cone(spot("").lights[0]).outer == Approx(0.0).margin(1e-6));
        const Scene wide = spot("<falloff_angle>240</falloff_angle>");
        CHECK(reference::spot_cone(wide.lights[0]).outer == Approx(-0.5));
        const Scene all = spot("<falloff_angle>360</falloff_angle>");
        CHECK(all.lights[0].kind == LightKind::point);
        CHECK(all.warnings.empty());
        const Scene soft = spot("<falloff_exponent>0.15</falloff_exponent>");
        CHECK(soft.lights[0].kind == LightKind::spot);
        CHECK(warns(soft, "falloff_exponent"));
        CHECK_THROWS_WITH(spot("<falloff_angle>0</falloff_angle>"),
                          ContainsSubstring("falloff_angle") && ContainsSubstring("more than 0"));
        const Scene divided = spot("<quadratic_attenuation>4</quadratic_attenuation>");
        CHECK(divided.lights[0].radiance == Vec3(0.25f, 0.5f, 0.75f));
    }
    SECTION("none") { CHECK(warns(light(""), "no known kind")); }
    SECTION("negative") {
        CHECK_THROWS_WITH(light("<point><color>-1 0 0</color></point>"),
                          ContainsSubstring("negative"));
    }
}

TEST_CASE("collada: light extras win over the common form", "[scenes][collada]") {
    ColladaText text;
    const auto kind_of = [&](const std::string& extra) {
        text.light = tests::light_extra(extra);
        return load(text).lights.at(0).kind;
    };
    const std::string colour = "<color>1 1 1</color>";
    CHECK(kind_of("<area>" + colour + "</area>") == LightKind::parallelogram);
    CHECK(kind_of("<point>" + colour + "</point>") == LightKind::point);
    CHECK(kind_of("<directional>" + colour + "</directional>") == LightKind::directional);
    CHECK(kind_of("<hemisphere>" + colour + "</hemisphere>") == LightKind::hemisphere);
    CHECK(kind_of("<ambient>" + colour + "</ambient>") == LightKind::environment);
    CHECK(kind_of("<laser>" + colour + "</laser>") == LightKind::point);
    CHECK(warns(load(text), "<laser>"));
}

TEST_CASE("collada: an area light is centred on its node and shines along its -z",
          "[scenes][collada]") {
    ColladaText text;
    text.up_axis = "Z_UP";
    text.light = tests::light_extra("<area><color>3 3 3</color></area>");
    text.light_transform = "<matrix>0.6 0 0 0 0 0.8 0 1 0 0 1 1.49 0 0 0 1</matrix>";
    const Light light = load(text).lights[0];
    CHECK(light.normal == Vec3(0, -1, 0));
    CHECK(light.area == Approx(0.48));
    check_close(light.position + 0.5f * (light.edge_x + light.edge_y), Vec3(0, 1.49f, -1));
    text.light_transform = "<matrix>-0.6 0 0 0 0 0.8 0 1 0 0 1 1.49 0 0 0 1</matrix>";
    CHECK(load(text).lights[0].normal == Vec3(0, -1, 0));
    text.light_transform = "<scale>0 1 1</scale>";
    CHECK(warns(load(text), "an area light without area"));
}

TEST_CASE("collada: the camera looks along its -z with the file's field of view",
          "[scenes][collada]") {
    ColladaText text;
    text.camera_transform = "<translate>1 2 3</translate><rotate>0 1 0 90</rotate>";
    const auto camera = load(text).camera;
    CHECK(camera.position == Vec3(1, 2, 3));
    check_close(camera.forward, Vec3(-1, 0, 0));
    check_close(camera.up, Vec3(0, 1, 0));
    check_close(camera.right, Vec3(0, 0, -1));
    CHECK(camera.tan_half_fov == Approx(0.57735));
    text.optics = "<perspective><xfov>90</xfov><aspect_ratio>2</aspect_ratio></perspective>";
    CHECK(load(text).camera.tan_half_fov == Approx(0.5));
    text.optics = "<perspective><xfov>200</xfov></perspective>";
    CHECK_THROWS_WITH(load(text), ContainsSubstring("<xfov>") && ContainsSubstring("200"));
    text.optics = "<perspective><xfov>90</xfov><aspect_ratio>0</aspect_ratio></perspective>";
    CHECK_THROWS_WITH(load(text), ContainsSubstring("aspect_ratio"));
    text.optics = "<orthographic/>";
    CHECK(warns(load(text), "not a perspective one"));
}

TEST_CASE("collada: lookat places a camera", "[scenes][collada]") {
    ColladaText text;
    text.camera_transform = "<lookat>1 2 3 1 2 -5 0 1 0</lookat>";
    const auto camera = load(text).camera;
    CHECK(camera.position == Vec3(1, 2, 3));
    check_close(camera.forward, Vec3(0, 0, -1));
}

TEST_CASE("collada: a camera's broken matrix is repaired, a mesh's is an error",
          "[scenes][collada]") {
    ColladaText text;
    const std::string broken = "<matrix>-1 0 0 0 0 0 1 3 0 0 0 0 0 0 1</matrix>";
    text.camera_transform = broken;
    const Scene scene = load(text);
    CHECK(warns(scene, "15 numbers instead of 16"));
    CHECK(warns(scene, "the scene's up is used"));
    CHECK(scene.camera.position == Vec3(0, 3, 0));
    text.mesh_transform = broken;
    CHECK_THROWS_WITH(load(text), ContainsSubstring("<matrix>") &&
                                      ContainsSubstring("expected 16 numbers, found 15"));
}

TEST_CASE("collada: without a camera, or on demand, one is fitted", "[scenes][collada]") {
    ColladaText text;
    const Scene own = load(text, "#camera=file");
    CHECK(own.camera.position == Vec3(0, 0, 5));
    const Scene fitted = load(text, "#camera=fit");
    CHECK(fitted.warnings.empty());
    check_close(fitted.camera.forward, own.camera.forward);
    CHECK(fitted.camera.position.z < 1.5f);
    text.has_camera = false;
    const Scene none = load(text);
    CHECK(warns(none, "no camera in the file"));
    for (const Vec3& vertex : none.vertices) {
        const Vec3 offset = vertex - none.camera.position;
        const float depth = reference::dot(offset, none.camera.forward);
        CHECK(depth > 0);
        for (const Vec3& axis : {none.camera.right, none.camera.up}) {
            CHECK(std::abs(reference::dot(offset, axis)) < depth * none.camera.tan_half_fov);
        }
    }
}
