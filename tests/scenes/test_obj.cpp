#include <fmt/format.h>

#include <filesystem>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::LightKind;
using reference::MaterialKind;
using reference::Scene;
using reference::Vec3;
using tests::TemporaryFiles;
using tests::warns;

namespace {

const std::string kSquareObj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// Whether the scene is the square of `kSquareObj`, in two triangles with the front towards +z.
void check_obj_square(const Scene& scene) {
    INFO(tests::all_warnings(scene));
    REQUIRE(scene.triangles.size() == 2);
    REQUIRE(scene.vertices.size() == 4);
    CHECK(scene.vertices[0] == Vec3(0, 0, 0));
    CHECK(scene.vertices[2] == Vec3(1, 1, 0));
    CHECK(tests::area_of(scene) == Approx(1.0));
    CHECK(tests::front_of(scene, 0) == Vec3(0, 0, 1));
    CHECK(tests::front_of(scene, 1) == Vec3(0, 0, 1));
}

const Vec3& reflectance(const Scene& scene, std::size_t triangle) {
    return scene.materials[scene.material_of[triangle]].reflectance;
}

const Vec3 kRed(1, 0, 0);
const Vec3 kGreen(0, 1, 0);
const Vec3 kGrey(0.5f, 0.5f, 0.5f);

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
        CHECK_THROWS_WITH(files.load("a.obj", text), ContainsSubstring("a.obj") &&
                                                         ContainsSubstring(line) &&
                                                         ContainsSubstring(what));
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
    CHECK_THROWS_WITH(files.load("a.obj", kSquareObj + "l 1 2\n"),
                      ContainsSubstring("no triangles"));
    CHECK(warns(files.load("a.obj", "mtllib gone.mtl\n" + kSquareObj + "f 1 2 3\n"),
                "material library 'gone.mtl' is missing"));
}

TEST_CASE("obj: spellings of the same square", "[scenes][obj]") {
    const TemporaryFiles files;
    const auto is_square = [&](const std::string& text) {
        INFO(text);
        check_obj_square(files.load("a.obj", text));
    };
    const std::string face = "f 1 2 3 4";
    is_square(kSquareObj + face + " # the quad\n");
    is_square(kSquareObj + face + "# the quad\n");
    is_square("v 0 0 0 # 1 2 3\nv 1 0 0#\nv 1 1 0\t# 4\nv 0 1 0\n" + face);
    is_square("  v 0 0 0\n\tv 1 0 0\n v 1 1 0\n v 0 1 0\n  f 1 2 3 4\n");
    is_square("v .0 -.0 0.\nv +1 0 0\nv 1.e0 10e-1 0\nv 0 +.1E1 0\n" + face);
    is_square(kSquareObj + "vt .5 .5\nvt 0.5\nvt 1 2 3\nf 1/1 2/2 3/3 4/1\n");
    is_square(kSquareObj + "f 1/ 2// 3 4/\n");
    is_square("v 0 0 0\r\nv 1 0 0\r\nv 1 1 0\r\nv 0 1 0\r\nf 1 2 3 4\r\n");
    is_square("v 0 0 0\rv 1 0 0\rv 1 1 0\rv 0 1 0\rf 1 2 3 4\r");
    is_square("\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + face);
    is_square("v\t0\t0   0  \nv 1 0 0\nv 1 1 0\nv 0 1 0\nf\t1 2\t3 4 \t\n");
    is_square("V 0 0 0\nV 1 0 0\nv 1 1 0\nv 0 1 0\nF 1 2 3 4\n");
    is_square("v 0 0 \\\n0\nv 1 \\\r\n 0 0\nv 1 1 0\nv 0 1 0\nf 1 \\\n2 \\\n 3 4\n");
    is_square("# made by C:\\models\\\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n" + face);
    is_square("f 1 2 3 4\n" + kSquareObj);
    is_square(kSquareObj + "v 5 5 5\nv 6 6 6\n" + face);
    is_square(kSquareObj + "fo 1 2 3 4\n");
    is_square(kSquareObj + "f 1 2 2 3 4 1\n");
    is_square(kSquareObj + "f +1 2/ +3// +4\n");
    is_square(kSquareObj + "f 1 2 \\ \t\n3 \\  \r\n 4\n");
}

TEST_CASE("obj: line numbers count every line of a continued one", "[scenes][obj]") {
    CHECK_THROWS_WITH(TemporaryFiles().load("a.obj", "v 0 0 \\\n0\n# x\n\nv 1 0 \\\n\\\nx\n"),
                      ContainsSubstring("a.obj: line 5") && ContainsSubstring("'x'"));
}

TEST_CASE("obj: relative indices count back from where the face stands", "[scenes][obj]") {
    const Scene scene =
        TemporaryFiles().load("a.obj",
                              "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 0 0 5\nv 1 0 5\nv 1 1 5\n"
                              "vn 0 0 1\nf -3//-1 -2//-1 -1//-1\n");
    REQUIRE(scene.triangles.size() == 2);
    CHECK(scene.vertices[scene.triangles[1][0]] == Vec3(0, 0, 5));
    CHECK(scene.normals[scene.triangles[1][0]] == Vec3(0, 0, 1));
    CHECK(scene.normals[scene.triangles[0][0]] == Vec3(0, 0, 0));
}

TEST_CASE("obj: a vertex for each pair of position and normal", "[scenes][obj]") {
    const TemporaryFiles files;
    const std::string normals = "vn 0 0 1\nvn 0 1 0\nvn 0 0 1\n";
    // The third normal is the first one again.
    const Scene scene = files.load("a.obj", kSquareObj + normals +
                                                "f 1//1 2//1 3//1\nf 1//3 3//2 4//2\n"
                                                "f 1//2 2//2 3//2\nf 1 2 3\n");
    REQUIRE(scene.triangles.size() == 4);
    CHECK(scene.triangles[0][0] == scene.triangles[1][0]);
    CHECK(scene.triangles[1][1] == scene.triangles[2][2]);
    // Positions 1, 2 and 3 come with both normals and without one, 4 with one.
    CHECK(scene.vertices.size() == 10);
    for (const auto& [a, b, c] : scene.triangles) {
        CHECK(scene.vertices[a] == Vec3(0, 0, 0));
        CHECK(scene.normals[b] == scene.normals[c]);
    }
}

TEST_CASE("obj: many normals at one position take no more than their share of time",
          "[scenes][obj]") {
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (int i = 1; i <= 20000; ++i) text += fmt::format("vn 1 {} 0\n", i);
    for (int i = 1; i <= 20000; ++i) text += fmt::format("f 1//{0} 2//{0} 3//{0}\n", i);
    CHECK(TemporaryFiles().load("a.obj", text).vertices.size() == 60000);
}

TEST_CASE("obj: normals that are no numbers are flat, with a warning", "[scenes][obj]") {
    const TemporaryFiles files;
    for (const char* normal : {"nan nan nan", "-nan 0 1", "-1.#IND -1.#IND -1.#IND", "inf 0 0",
                               "1.#QNAN 0 0", "-nan(ind) 0 0"}) {
        INFO(normal);
        const Scene scene =
            files.load("a.obj", kSquareObj + "vn " + normal + "\nf 1//1 2//1 3//1 4//1\n");
        check_obj_square(scene);
        CHECK(scene.normals.empty());
        CHECK(warns(scene, "a normal that is not finite"));
    }
    CHECK_THROWS_WITH(files.load("a.obj", kSquareObj + "vn 0 up 0\nf 1 2 3\n"),
                      ContainsSubstring("line 5") && ContainsSubstring("'up'"));
}

TEST_CASE("obj: a concave polygon covers its area and nothing else", "[scenes][obj]") {
    // A C of area 10, open to the right: nothing at x > 1, 1 < y < 3.
    const Scene scene = TemporaryFiles().load(
        "a.obj",
        "v 0 0 0\nv 4 0 0\nv 4 1 0\nv 1 1 0\nv 1 3 0\nv 4 3 0\nv 4 4 0\nv 0 4 0\n"
        "f 1 2 3 4 5 6 7 8\n");
    CHECK(scene.triangles.size() == 6);
    CHECK(tests::area_of(scene) == Approx(10.0));
    for (std::size_t i = 0; i < scene.triangles.size(); ++i) {
        CHECK(tests::front_of(scene, i) == Vec3(0, 0, 1));
    }
}

TEST_CASE("obj: moved and turned in the file is moved and turned in the scene", "[scenes][obj]") {
    const TemporaryFiles files;
    const Scene plain = files.load("a.obj", kSquareObj + "f 1 2 3\nf 1 3 4\n");
    const Scene moved =
        files.load("a.obj", "v 7 0 -2\nv 7 1 -2\nv 7 1 -1\nv 7 0 -1\nf 1 2 3\nf 1 3 4\n");
    REQUIRE(plain.triangles == moved.triangles);
    for (std::size_t i = 0; i < plain.vertices.size(); ++i) {
        const Vec3& v = plain.vertices[i];
        CHECK(moved.vertices[i] == Vec3(7, v.x, v.y - 2));
    }
}

TEST_CASE("obj: names of material libraries", "[scenes][obj]") {
    const TemporaryFiles files;
    files.write("a.mtl", "newmtl red\nKd 1 0 0\n");
    files.write("b.mtl", "newmtl green\nKd 0 1 0\n");
    files.write("my colours.mtl", "newmtl red\nKd 1 0 0\n");
    files.write("#1.mtl", "newmtl red\nKd 1 0 0\n");
    const auto load = [&](const std::string& names) {
        return files.load("a.obj", "mtllib " + names + "\n" + kSquareObj +
                                       "usemtl red\nf 1 2 3\nusemtl green\nf 1 3 4\n");
    };
    for (const char* name :
         {"a.mtl", "a.mtl   ", "a.mtl\t# colours", ".\\a.mtl", "./a.mtl", "\"a.mtl\"",
          "my colours.mtl", "\"my colours.mtl\"", "my colours.mtl # of mine", "A.MTL",
          "C:\\Users\\me\\My Colours.mtl", "/models/me/a.mtl", "#1.mtl", "gone.mtl a.mtl"}) {
        INFO(name);
        const Scene scene = load(name);
        CHECK(reflectance(scene, 0) == kRed);
        CHECK(reflectance(scene, 1) == kGrey);
        CHECK(warns(scene, "the material 'green' is in no material library"));
        CHECK(warns(scene, "is missing") == (std::string(name) == "gone.mtl a.mtl"));
    }
    for (const char* names : {"a.mtl b.mtl", "my colours.mtl b.mtl", "b.mtl my colours.mtl # both",
                              "a.mtl\nmtllib b.mtl", "\"my colours.mtl\" b.mtl"}) {
        INFO(names);
        const Scene scene = load(names);
        CHECK(reflectance(scene, 0) == kRed);
        CHECK(reflectance(scene, 1) == kGreen);
        CHECK_FALSE(warns(scene, "is missing"));
    }
    CHECK(warns(load("no such file.mtl"), "the material library 'no such file.mtl' is missing"));
    CHECK(warns(load("a.mtl x.mtl y.mtl"), "the material library 'x.mtl y.mtl' is missing"));
    CHECK(warns(load("."), "the material library '.' is missing"));
    CHECK(warns(load("/dev/zero"), "the material library '/dev/zero' is missing"));
}

TEST_CASE("obj: names of materials", "[scenes][obj]") {
    const TemporaryFiles files;
    files.write("a.mtl",
                "newmtl red # of apples\nKd 1 0 0\nnewmtl big green\nKd 0 1 0\n"
                "newmtl m #1\nKd 1 0 0\nnewmtl m #2\nKd 0 1 0\nnewmtl red\nKd 0 0 1\n");
    const auto colour_of = [&](const std::string& name) {
        const Scene scene =
            files.load("a.obj", "mtllib a.mtl\n" + kSquareObj + "usemtl " + name + "\nf 1 2 3 4\n");
        CHECK_FALSE(warns(scene, "is in no material library"));
        return reflectance(scene, 0);
    };
    CHECK(colour_of("red") == Vec3(0, 0, 1));
    CHECK(colour_of("red # of apples") == kRed);
    CHECK(colour_of("red # of the sky") == Vec3(0, 0, 1));
    CHECK(colour_of("big green  ") == kGreen);
    CHECK(colour_of("m #1") == kRed);
    CHECK(colour_of("m #2") == kGreen);
    CHECK(colour_of("m") == kRed);
}

TEST_CASE("obj: an unknown material is named and grey", "[scenes][obj]") {
    const TemporaryFiles files;
    files.write("a.mtl", "newmtl red\nKd 1 0 0\n");
    const Scene scene = files.load("a.obj", "mtllib a.mtl\n" + kSquareObj +
                                                "usemtl blue\nf 1 2 3\nusemtl Red\nf 1 3 4\n"
                                                "usemtl never used\n");
    CHECK(reflectance(scene, 0) == kGrey);
    CHECK(reflectance(scene, 1) == kGrey);
    CHECK(scene.materials.size() == 1);
    CHECK(warns(scene, "the material 'blue' is in no material library"));
    CHECK(warns(scene, "the material 'Red' is in no material library (there is 'red'"));
    CHECK_FALSE(warns(scene, "never used"));
    std::string many = kSquareObj;
    for (int i = 0; i < 20; ++i) many += fmt::format("usemtl m{}\nf 1 2 3\n", i);
    CHECK(warns(files.load("a.obj", many), "12 further materials"));
    CHECK(warns(files.load("a.obj", kSquareObj + "f 1 2 3\n"), "a mesh without material"));
}

TEST_CASE("obj: names that are no UTF-8, or very long, are shown as UTF-8, in part",
          "[scenes][obj]") {
    const TemporaryFiles files;
    const auto warns_of = [&](const std::string& name, const std::string& shown) {
        const Scene scene = files.load("a.obj", kSquareObj + "usemtl " + name + "\nf 1 2 3\n");
        CHECK(warns(scene, "the material '" + shown + "' is in no"));
    };
    warns_of("gr\xfc\x6e", "gr?n");
    warns_of("gr\xc3\xbcn \xe2\x82\xac \xf0\x9f\x99\x82",
             "gr\xc3\xbcn \xe2\x82\xac \xf0\x9f\x99\x82");
    warns_of("\xc0\xaf \xed\xa0\x80 \xf5\x80\x80\x80 \xe2\x82", "?? ??? ???? ??");
    warns_of("\x01x", "?x");
    warns_of(std::string(59, 'x') + "\xc3\xbcyz", std::string(59, 'x') + "\xc3\xbc...");
}

TEST_CASE("obj: statements of a material library", "[scenes][obj]") {
    const TemporaryFiles files;
    std::string warnings;
    const auto material = [&](const std::string& statements) {
        files.write("a.mtl", "newmtl m\n" + statements);
        const Scene scene =
            files.load("a.obj", "mtllib a.mtl\n" + kSquareObj + "usemtl m\nf 1 2 3 4\n");
        warnings = tests::all_warnings(scene);
        return scene.materials[scene.material_of[0]];
    };
    CHECK(material("Kd 0.3").reflectance == Vec3(0.3f));
    CHECK(material("  Kd .1 .2 .3 # red\nillum 1\nKs 1 1 1\n").reflectance ==
          Vec3(0.1f, 0.2f, 0.3f));
    CHECK_THAT(warnings, !ContainsSubstring("specular"));
    CHECK(material("kd 1 0 0\r\nNS 5\r\n").reflectance == kRed);
    CHECK(material("Kd 0.1 \\\n0.2 0.3\n").reflectance == Vec3(0.1f, 0.2f, 0.3f));
    CHECK(material("Ka 1 1 1\n").reflectance == kGrey);
    CHECK_THAT(warnings, ContainsSubstring("without Kd"));
    CHECK(material("Kd 2 -1 0.5\n").reflectance == Vec3(1, 0, 0.5f));
    CHECK_THAT(warnings, ContainsSubstring("beyond 0 to 1"));
    CHECK(material("Kd 1 0 0 1\n").reflectance == kRed);
    CHECK_THAT(warnings, ContainsSubstring("more than three numbers"));
    material("Kd spectral file.rfl\n");
    CHECK_THAT(warnings, ContainsSubstring("'spectral'"));
    CHECK(material("Ke 2\n").emission == Vec3(2.0f));
    CHECK(material("illum 5\nKs 0 0 0\n").kind == MaterialKind::mirror);
    CHECK(material("illum 3\nKs 0.5\n").reflectance == Vec3(0.5f));
    CHECK(material("illum 4\n").kind == MaterialKind::glass);
    CHECK(material("illum 6.0\nNi 1.33\n").ior == 1.33f);
    CHECK(material("illum 7\n").ior == 1.5f);
    CHECK(material("illum 9\n").kind == MaterialKind::diffuse);
    CHECK_THAT(warnings, ContainsSubstring("illumination models 8 to 10"));
    CHECK(material("Kd .9 .8 .7\nPm 1\nPr .25\n").kind == MaterialKind::conductor);
    CHECK(material("Kd .9 .8 .7\nPm 1\nPr .25\n").ior == 0.25f);
    CHECK(material("Kd .9 .8 .7\nPm 1\nPr .25\n").reflectance == Vec3(.9f, .8f, .7f));
    CHECK(material("Pm 1\nPr 0\n").kind == MaterialKind::mirror);
    CHECK(material("Pm 1\n").ior == 1.0f);
    CHECK(material("Ke 1 2 3\nPm 1\n").emission == Vec3(1, 2, 3));
    CHECK(material("Pr .5\n").kind == MaterialKind::diffuse);
    CHECK_THAT(warnings, ContainsSubstring("gloss on what is no metal"));
    for (const char* opacity : {"d 0.5\n", "d -halo 0.5\n", "Tr 0.5\n", "d 0.2\nTr 0\n"}) {
        material(opacity);
        CHECK_THAT(warnings, ContainsSubstring("partial opacity"));
    }
    for (const char* opacity : {"d 1\n", "Tr 0\n", "d 1\nTr 1\n", "Tr 1\nd 1\n"}) {
        material(opacity);
        CHECK_THAT(warnings, !ContainsSubstring("partial opacity"));
    }
    for (const char* texture : {"map_Kd -s 1 1 1 a b.png", "bump x.png", "map_Bump x.png",
                                "refl -type sphere x.png", "norm x.png", "disp x"}) {
        material(texture);
        CHECK_THAT(warnings, ContainsSubstring("a texture is not supported"));
    }
    material("Ps 1\n");
    CHECK_THAT(warnings, ContainsSubstring("physically based"));
    material("blub 1\n");
    CHECK_THAT(warnings, ContainsSubstring("not known"));
}

TEST_CASE("obj: what is wrong in a material library is named with its line", "[scenes][obj]") {
    const TemporaryFiles files;
    const auto fails = [&](const std::string& text, const std::string& line,
                           const std::string& what) {
        files.write("m.mtl", text);
        CHECK_THROWS_WITH(files.load("a.obj", "mtllib m.mtl\n" + kSquareObj + "f 1 2 3\n"),
                          ContainsSubstring("m.mtl: " + line) && ContainsSubstring(what));
    };
    fails("newmtl m\nKd 1 x 0\n", "line 2", "'x'");
    fails("newmtl m\nKd 1 0\n", "line 2", "one or three");
    fails("newmtl m\nKe nan nan nan\n", "line 2", "'nan'");
    fails("newmtl m\nKd\n", "line 2", "one or three");
    fails("newmtl m\nNi glass\n", "line 2", "'glass'");
    fails("newmtl m\nillum\n", "line 2", "illum");
}

TEST_CASE("obj: what is left out is said", "[scenes][obj]") {
    const TemporaryFiles files;
    const auto said = [&](const std::string& text, const std::string& warning) {
        CHECK(warns(files.load("a.obj", kSquareObj + text + "\nf 1 2 3 4\n"), warning));
    };
    said("l 1 2", "'l' elements");
    said("p 1", "'p' elements");
    said("cstype bezier\ndeg 3\ncurv 0 1 1 2 3 4\nparm u 0 1\nend", "'curv' elements");
    said("v 0 0 0 1 0.5 0", "vertex colours");
    said("v 0 0 0 0.5", "weight");
    said("s 1", "smoothed face without normals");
    said("call other.obj", "'call' statements");
    said("usemap x.png", "texture");
    said("f 1/9 2/9 3/9", "texture coordinate");
    said("hello world", "'hello' is no statement");
    const Scene quiet =
        files.load("a.obj", kSquareObj + "g a b\no name\ns off\nvt 0 0\nvp 1\nlod 2\nf 1 2 3 4\n");
    CHECK(quiet.warnings.size() == 3);  // material, light, camera
    CHECK_THROWS_WITH(files.load("a.obj", kSquareObj + "l 1 2\n"),
                      ContainsSubstring("no triangles") && ContainsSubstring("'l' elements"));
}

TEST_CASE("obj: faces that cannot be are named with their line", "[scenes][obj]") {
    const TemporaryFiles files;
    const auto fails = [&](const std::string& face, const std::string& what) {
        INFO(face);
        CHECK_THROWS_WITH(files.load("a.obj", kSquareObj + "vn 0 0 1\n" + face + "\n"),
                          ContainsSubstring("a.obj: line 6") && ContainsSubstring(what));
    };
    fails("f 1//2 2//1 3//1", "normal index 2 out of range");
    fails("f 1//-2 2//1 3//1", "normal index -2 out of range");
    fails("f 1/1/1/1 2 3", "'1/1/1/1'");
    fails("f 1.0 2 3", "'1.0'");
    fails("f 1//0 2 3", "'1//0'");
    fails("f /1 2 3", "'/1'");
    fails("f 99999999999999999999 2 3", "'99999999999999999999'");
    fails("f 4294967297 2 3", "4294967297 out of range");
    fails("f -9223372036854775808 2 3", "out of range");
    fails("f", "found 0");
    CHECK_THROWS_WITH(files.load("a.obj", "v 0 0 2e12\n"),
                      ContainsSubstring("line 1") && ContainsSubstring("2e12"));
}
