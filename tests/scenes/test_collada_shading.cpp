/// Materials, lights and cameras of COLLADA files: what is exact, and what is named.

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/scenes/collada_text.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::LightKind;
using reference::MaterialKind;
using reference::Scene;
using reference::Vec3;
using tests::ColladaText;
using tests::replaced;
using tests::TemporaryFiles;
using tests::warns;

namespace {

ColladaText point_light(const std::string& more) {
    ColladaText text;
    text.light =
        "<technique_common><point><color>4 8 12</color>" + more + "</point></technique_common>";
    return text;
}

std::string attenuation(const char* constant, const char* linear, const char* quadratic) {
    return std::string("<constant_attenuation>") + constant +
           "</constant_attenuation><linear_attenuation>" + linear +
           "</linear_attenuation><quadratic_attenuation>" + quadratic + "</quadratic_attenuation>";
}

/// What a surface with this shader warns of.
std::string shader_warnings(const std::string& shader) {
    ColladaText text;
    text.common = shader;
    return tests::all_warnings(load(text));
}

}  // namespace

TEST_CASE("collada: a purely quadratic attenuation divides a point light's colour",
          "[scenes][collada]") {
    const Scene scene = load(point_light(attenuation("0", "0", "4")));
    CHECK(scene.lights[0].radiance == Vec3(1, 2, 3));
    CHECK(scene.warnings.empty());
    CHECK(load(point_light("")).lights[0].radiance == Vec3(4, 8, 12));
    for (const auto& other : {attenuation("1", "0", "0"), attenuation("1", "0", "0.5"),
                              attenuation("0", "1", "1"), attenuation("0", "0", "0"),
                              std::string("<constant_attenuation>1</constant_attenuation>")}) {
        const Scene approximated = load(point_light(other));
        CHECK(approximated.lights[0].radiance == Vec3(4, 8, 12));
        CHECK(warns(approximated, "attenuation"));
    }
    CHECK_THROWS_WITH(load(point_light(attenuation("0", "0", "-1"))),
                      ContainsSubstring("quadratic_attenuation") && ContainsSubstring("negative"));
}

TEST_CASE("collada: the unit does not change what a point light does to its scene",
          "[scenes][collada]") {
    ColladaText text = point_light("");
    text.light_transform = "<translate>0 0 2</translate>";
    const auto irradiance = [&](const char* unit) {
        text.unit = unit;
        const Scene scene = load(text);
        const Vec3 away = scene.lights[0].position - scene.vertices[0];
        return scene.lights[0].radiance.x / reference::dot(away, away);
    };
    CHECK(irradiance("1") == Approx(1.0));
    CHECK(irradiance("0.01") == Approx(1.0));
    CHECK(irradiance("1000") == Approx(1.0));
    CHECK(irradiance("2.54e-2") == Approx(1.0));
    text.unit = "0.01m";
    CHECK_THROWS_WITH(load(text), ContainsSubstring("meter") && ContainsSubstring("0.01m"));
}

TEST_CASE("collada: a light's strength in a foreign extra is named", "[scenes][collada]") {
    ColladaText text = point_light("");
    text.light +=
        "<extra><technique profile=\"FCOLLADA\"><intensity>2</intensity></technique></extra>";
    CHECK(warns(load(text), "<intensity> of the profile FCOLLADA"));
    text.light = replaced(text.light, ">2<", ">1<");
    CHECK(load(text).warnings.empty());
}

TEST_CASE("collada: transparency is named where a surface would be seen through",
          "[scenes][collada]") {
    struct Case {
        const char* transparent;
        const char* transparency;
        bool opaque;
    };
    const auto [transparent, transparency, opaque] = GENERATE(values<Case>({
        {"", "", true},
        {"", "<float>1</float>", true},
        {"", "<float>0.5</float>", false},
        {"<transparent><color>1 1 1 1</color></transparent>", "", true},
        {"<transparent><color>1 1 1</color></transparent>", "", true},
        {"<transparent opaque=\"A_ONE\"><color>1 1 1 .3</color></transparent>", "", false},
        {"<transparent opaque=\"A_ONE\"><color>0 0 0 1</color></transparent>", "<float>1</float>",
         true},
        {"<transparent opaque=\"A_ONE\"><color>1 1 1 1</color></transparent>", "<float>0</float>",
         false},
        {"<transparent opaque=\"A_ZERO\"><color>1 1 1 0</color></transparent>", "", true},
        {"<transparent opaque=\"A_ZERO\"><color>1 1 1 1</color></transparent>", "", false},
        {"<transparent opaque=\"RGB_ZERO\"><color>1 1 1 1</color></transparent>", "", false},
        {"<transparent opaque=\"RGB_ZERO\"><color>1 1 1 1</color></transparent>",
         "<float>1</float>", false},
        {"<transparent opaque=\"RGB_ZERO\"><color>0 0 0 1</color></transparent>",
         "<float>1</float>", true},
        {"<transparent opaque=\"RGB_ZERO\"><color>1 1 1 1</color></transparent>",
         "<float>0</float>", true},
        {"<transparent opaque=\"RGB_ONE\"><color>1 1 1 0</color></transparent>", "", true},
        {"<transparent opaque=\"RGB_ONE\"><color>1 0 1 1</color></transparent>", "", false},
        {"<transparent><texture texture=\"t\"/></transparent>", "", false},
    }));
    INFO(transparent << " " << transparency);
    std::string shader =
        std::string("<lambert><diffuse><color>.5 .5 .5 1</color></diffuse>") + transparent;
    if (*transparency != '\0') {
        shader += std::string("<transparency>") + transparency + "</transparency>";
    }
    CHECK(shader_warnings(shader + "</lambert>").empty() == opaque);
}

TEST_CASE("collada: an unknown rule of transparency is an error", "[scenes][collada]") {
    CHECK_THROWS_WITH(shader_warnings("<lambert><diffuse><color>1 1 1 1</color></diffuse>"
                                      "<transparent opaque=\"HALF\"/></lambert>"),
                      ContainsSubstring("HALF") && ContainsSubstring("RGB_ZERO"));
}

TEST_CASE("collada: a channel's texture never shines and is named once", "[scenes][collada]") {
    ColladaText text;
    text.common =
        "<phong><emission><texture/></emission><diffuse><color>.1 .2 .3 1</color></diffuse>"
        "<specular><texture/></specular></phong>";
    const Scene scene = load(text);
    CHECK(scene.materials[0].emission == Vec3(0, 0, 0));
    CHECK(scene.materials[0].reflectance == Vec3(0.1f, 0.2f, 0.3f));
    CHECK(warns(scene, "texture of <emission>"));
    CHECK(scene.warnings.size() == 2);
}

TEST_CASE("collada: a colour may be a parameter, which the material may set", "[scenes][collada]") {
    ColladaText text;
    text.common =
        "<newparam sid=\"tint\"><float3>.3 .2 .1</float3></newparam>"
        "<lambert><diffuse><param ref=\"tint\"/></diffuse></lambert>";
    CHECK(load(text).materials[0].reflectance == Vec3(0.3f, 0.2f, 0.1f));
    const std::string file =
        replaced(text.text(), "<instance_effect url=\"#fx\"/>",
                 "<instance_effect url=\"#fx\"><setparam ref=\"tint\"><float3>.7 .8 .9</float3>"
                 "</setparam></instance_effect>");
    CHECK(TemporaryFiles().load("a.dae", file).materials[0].reflectance == Vec3(0.7f, 0.8f, 0.9f));
    text.common = replaced(text.common, "ref=\"tint\"", "ref=\"gone\"");
    CHECK_THROWS_WITH(load(text),
                      ContainsSubstring("newparam") && ContainsSubstring("float3 or float4"));
}

TEST_CASE("collada: a surface without a colour, and a bump map, are named", "[scenes][collada]") {
    CHECK_THAT(shader_warnings("<phong/>"), ContainsSubstring("without a <diffuse>: black"));
    CHECK(shader_warnings("<constant><emission><color>1 1 1 1</color></emission></constant>")
              .empty());
    CHECK_THAT(
        shader_warnings("<lambert><diffuse><color>1 1 1 1</color></diffuse></lambert>"
                        "<extra><technique profile=\"FCOLLADA\"><bump/></technique></extra>"),
        ContainsSubstring("bump"));
}

TEST_CASE("collada: the profile CGL says what CMU462 says", "[scenes][collada]") {
    ColladaText text;
    text.geometry =
        "<geometry id=\"square\"><extra><technique profile=\"CMU462\"><sphere><radius>.5</radius>"
        "</sphere></technique></extra></geometry>";
    text.light = tests::light_extra("<area><color>3 3 3</color></area>");
    const char* material =
        GENERATE("<mirror><reflectance>0.3 0.4 0.5</reflectance></mirror>",
                 "<glass><reflectance>1 1 1</reflectance><transmittance>1 1 1</transmittance>"
                 "<ior>1.45</ior></glass>",
                 "<emission><radiance>1 2 3</radiance></emission>",
                 "<diffuse><albedo>.4 .5 .6</albedo></diffuse>");
    text.extra = material;
    const std::string cmu = text.text();
    std::string cgl = cmu;
    for (std::size_t at; (at = cgl.find("CMU462")) != std::string::npos;) cgl.replace(at, 6, "CGL");
    const TemporaryFiles files;
    const Scene expected = files.load("scene.dae", cmu);
    const Scene found = files.load("scene.dae", cgl);
    CHECK(reference::fingerprint(found) == reference::fingerprint(expected));
    CHECK(found.warnings == expected.warnings);
    CHECK(found.triangles.size() == 11520);
    CHECK(warns(found, "as Scotty3D does"));
}

TEST_CASE("collada: the field of view in all its spellings", "[scenes][collada]") {
    ColladaText text;
    const auto camera = [&](const std::string& inside) {
        text.optics = "<perspective>" + inside + "</perspective>";
        return load(text).camera;
    };
    const float tan30 = 0.577350269f;
    CHECK(camera("<yfov>60</yfov>").tan_half_fov == Approx(tan30));
    CHECK(camera("<yfov>60</yfov><aspect_ratio>2</aspect_ratio>").tan_half_fov == Approx(tan30));
    CHECK(camera("<yfov>60</yfov><aspect_ratio>2</aspect_ratio>").tan_half_width == 0.0f);
    CHECK(camera("<xfov>90</xfov><yfov>60</yfov>").tan_half_fov == Approx(tan30));
    CHECK(camera("<xfov>60</xfov><aspect_ratio>2</aspect_ratio>").tan_half_fov ==
          Approx(tan30 / 2));
    CHECK(camera("<xfov>60</xfov><aspect_ratio>2</aspect_ratio>").tan_half_width == 0.0f);
    INFO("a width alone waits for the shape of the picture");
    CHECK(camera("<xfov>60</xfov>").tan_half_width == Approx(tan30));
    CHECK(load(text).warnings.empty());
    const auto fitted = load(text, "#camera=fit").camera;
    CHECK(fitted.tan_half_width == 0.0f);
    CHECK(fitted.tan_half_fov == Approx(tan30));
    CHECK_THROWS_WITH(camera("<xfov>200</xfov>"),
                      ContainsSubstring("<xfov>") && ContainsSubstring("200"));
    CHECK_THROWS_WITH(camera("<aspect_ratio>1</aspect_ratio>"),
                      ContainsSubstring("<yfov> or <xfov>"));
}

TEST_CASE("collada: the up axis may stand between blanks", "[scenes][collada]") {
    ColladaText text;
    text.up_axis = "\n  Z_UP ";
    CHECK(load(text).vertices[2] == Vec3(1, 0, -1));
}
