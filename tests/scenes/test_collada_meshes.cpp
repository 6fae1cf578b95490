
#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/scenes/collada_text.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::Scene;
using reference::Vec3;
using tests::ColladaText;
using tests::replaced;
using tests::TemporaryFiles;
using tests::warns;

namespace {

/// A mesh of these positions (x y z ...) and primitives; their <input> is "INPUT".
ColladaText mesh_of(const std::string& positions, const std::string& count,
                    std::string primitives) {
    for (std::size_t at; (at = primitives.find("INPUT")) != std::string::npos;) {
        primitives.replace(at, 5, "<input semantic=\"VERTEX\" source=\"#sv\" offset=\"0\"/>");
    }
    ColladaText text;
    text.geometry =
        "<geometry id=\"square\"><mesh><source id=\"sp\"><float_array id=\"spa\">" + positions +
        "</float_array><technique_common><accessor source=\"#spa\" stride=\"3\" count=\"" + count +
        "\"/></technique_common></source><vertices id=\"sv\"><input "
        "semantic=\"POSITION\" source=\"#sp\"/></vertices>" +
        primitives + "</mesh></geometry>";
    return text;
}

double area_of(const Scene& scene) {
    double area = 0.0;
    for (const auto& [a, b, c] : scene.triangles) {
        area += 0.5 * reference::length(reference::cross(scene.vertices[b] - scene.vertices[a],
                                                         scene.vertices[c] - scene.vertices[a]));
    }
    return area;
}

/// How many triangles lie over or under (x, y).
int covers(const Scene& scene, float x, float y) {
    int count = 0;
    for (const auto& triangle : scene.triangles) {
        bool inside = true;
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& a = scene.vertices[triangle[k]];
            const Vec3& b = scene.vertices[triangle[(k + 1) % 3]];
            inside &= (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x) > 0.0f;
        }
        count += inside ? 1 : 0;
    }
    return count;
}

const std::string kLetterC = "0 0 0 4 0 0 4 1 0 1 1 0 1 3 0 4 3 0 4 4 0 0 4 0";

}  // namespace

TEST_CASE("collada: a concave polygon covers its inside only", "[scenes][collada]") {
    const std::string corners = "<p>0 1 2 3 4 5 6 7</p>";
    for (const std::string& primitives :
         {"<polylist count=\"1\">INPUT<vcount>8</vcount>" + corners + "</polylist>",
          "<polygons count=\"1\">INPUT" + corners + "</polygons>"}) {
        const Scene scene = load(mesh_of(kLetterC, "8", primitives));
        CHECK(area_of(scene) == Approx(10));
        CHECK(covers(scene, 2.5f, 2.0f) == 0);
        CHECK(covers(scene, 0.5f, 2.0f) == 1);
        CHECK(covers(scene, 2.5f, 0.4f) == 1);
        CHECK_FALSE(warns(scene, "polygon"));
    }
}

TEST_CASE("collada: holes of polygons are cut out", "[scenes][collada]") {
    const Scene scene =
        load(mesh_of("0 0 0 4 0 0 4 4 0 0 4 0 1 1 0 1 2 0 2 2 0 2 1 0 3 3 0 3.5 3 0 3 3.5 0", "11",
                     "<polygons count=\"2\">INPUT<ph><p>0 1 2 3</p><h>4 5 6 7</h><h>8 9 10</h></ph>"
                     "<p>4 7 6</p></polygons>"));
    CHECK(area_of(scene) == Approx(16 - 1 - 0.125 + 0.5));
    CHECK(covers(scene, 1.2f, 1.7f) == 0);
    CHECK(covers(scene, 3.1f, 3.1f) == 0);
    CHECK(covers(scene, 0.5f, 3.5f) == 1);
    CHECK_FALSE(warns(scene, "hole"));
}

TEST_CASE("collada: a polygon that crosses itself is named", "[scenes][collada]") {
    CHECK(warns(load(mesh_of("0 0 0 2 0 0 0 3 0 2 3 0", "4",
                             "<polylist count=\"1\">INPUT<vcount>4</vcount><p>0 1 2 3</p>"
                             "</polylist>")),
                "crosses itself"));
}

TEST_CASE("collada: strips and fans are read as the triangles that they stand for",
          "[scenes][collada]") {
    const std::string positions = "0 0 0 0 1 0 1 0 0 1 1 0 2 0 0 2 1 0";
    const auto of = [&](const std::string& primitives) {
        return load(mesh_of(positions, "6", primitives));
    };
    const Scene triangles =
        of("<triangles count=\"4\">INPUT<p>0 2 1 1 2 3 2 4 3 3 4 5</p></triangles>");
    const Scene strip = of("<tristrips count=\"1\">INPUT<p>1 0 3 2 5 4</p></tristrips>");
    CHECK(strip.triangles.size() == 4);
    CHECK(area_of(strip) == Approx(2));
    for (std::size_t t = 0; t < 4; ++t) {
        CHECK(tests::front_of(strip, t) == tests::front_of(triangles, t));
    }
    INFO("a strip that repeats corners joins two strips");
    const Scene joined =
        of("<tristrips count=\"2\">INPUT<p>1 0 3 3 2 2 4 3 5</p><p>0 2 1</p></tristrips>");
    CHECK(joined.triangles.size() == 4);
    CHECK_FALSE(warns(joined, "zero area"));
    const Scene fan = of("<trifans count=\"1\">INPUT<p>0 4 5 1</p></trifans>");
    CHECK(fan.triangles.size() == 2);
    CHECK(area_of(fan) == Approx(2));
    CHECK(tests::front_of(fan, 1) == Vec3(0, 0, 1));
    CHECK_THROWS_WITH(of("<trifans count=\"2\">INPUT<p>0 4 5 1</p></trifans>"),
                      ContainsSubstring("expected 2 <p>") && ContainsSubstring("found 1"));
    CHECK_THROWS_WITH(of("<tristrips count=\"1\">INPUT<p>0 1 6</p></tristrips>"),
                      ContainsSubstring("index 6 out of range"));
    CHECK(warns(of("<triangles count=\"1\">INPUT<p>0 2 1</p></triangles>"
                   "<tristrips count=\"1\">INPUT<p>0 1</p></tristrips>"),
                "fewer than 3 corners"));
}

TEST_CASE("collada: empty primitives are no error", "[scenes][collada]") {
    ColladaText text;
    text.geometry = replaced(text.geometry, "</mesh>", "<polylist count=\"0\"/></mesh>");
    CHECK(load(text).warnings.empty());
}

TEST_CASE("collada: numbers in every spelling, with comments and blank lines between",
          "[scenes][collada]") {
    ColladaText text;
    const Scene plain = load(text);
    text.geometry =
        replaced(text.geometry, "0 0 0 1 0 0 1 1 0 0 1 0",
                 "\n\n 0 -0 .0\t+1 0. 0e0 <!-- here -->1E0 10.0e-1\r\n 0 0<![CDATA[ 1.000 ]]>0 \n");
    CHECK(reference::fingerprint(load(text)) == reference::fingerprint(plain));
    text.geometry = replaced(text.geometry, "1E0", "1,0");
    CHECK_THROWS_WITH(load(text), ContainsSubstring("spa") && ContainsSubstring("'1,0'"));
}

TEST_CASE("collada: an accessor's parameters say where x, y and z are", "[scenes][collada]") {
    ColladaText text;
    const Scene plain = load(text);
    const std::string accessor = "<accessor source=\"#spa\" count=\"4\" stride=\"3\"/>";
    SECTION("an unnamed parameter is skipped") {
        text.geometry = replaced(text.geometry, "\"12\">0 0 0 1 0 0 1 1 0 0 1 0",
                                 "\"16\">9 0 0 0 9 1 0 0 9 1 1 0 9 0 1 0");
        text.geometry = replaced(text.geometry, accessor,
                                 "<accessor source=\"#spa\" count=\"4\" stride=\"4\"><param "
                                 "type=\"float\"/><param name=\"X\"/><param name=\"Y\"/><param "
                                 "name=\"Z\"/></accessor>");
    }
    SECTION("letters may come in any order") {
        text.geometry =
            replaced(text.geometry, "0 0 0 1 0 0 1 1 0 0 1 0", "0 0 0 0 0 1 0 1 1 0 1 0");
        text.geometry = replaced(text.geometry, accessor,
                                 "<accessor source=\"#spa\" count=\"4\" stride=\"3\"><param "
                                 "name=\"Z\"/><param name=\"Y\"/><param name=\"X\"/></accessor>");
    }
    CHECK(reference::fingerprint(load(text)) == reference::fingerprint(plain));
}

TEST_CASE("collada: an array that is not as long as it says is named", "[scenes][collada]") {
    ColladaText text;
    text.geometry = replaced(text.geometry, "count=\"12\">0 0 0", "count=\"15\">0 0 0");
    CHECK(warns(load(text), "<float_array> does not hold as many numbers as its count says"));
}

TEST_CASE("collada: vertex colours are named wherever they stand", "[scenes][collada]") {
    ColladaText text;
    text.geometry = replaced(text.geometry, "<input semantic=\"POSITION\" source=\"#sp\"/>",
                             "<input semantic=\"POSITION\" source=\"#sp\"/><input "
                             "semantic=\"COLOR\" source=\"#sn\"/>");
    CHECK(warns(load(text), "vertex colours"));
}

TEST_CASE("collada: an id tells elements of different kinds apart, but not two of one kind",
          "[scenes][collada]") {
    ColladaText text;
    text.libraries = "<library_nodes><node id=\"square\"/></library_nodes>";
    CHECK(load(text).warnings.empty());
    text.geometry += text.geometry;
    CHECK_THROWS_WITH(load(text),
                      ContainsSubstring("several <geometry>") && ContainsSubstring("unique"));
}

TEST_CASE("collada: references may be escaped", "[scenes][collada]") {
    ColladaText text;
    std::string file = text.text();
    file = replaced(file, "<geometry id=\"square\">", "<geometry id=\"a square\">");
    file = replaced(file, "url=\"#square\"", "url=\"#a%20square\"");
    CHECK(TemporaryFiles().load("scene.dae", file).triangles.size() == 2);
    file = replaced(file, "#a%20square", "other.dae#square");
    CHECK_THROWS_WITH(TemporaryFiles().load("scene.dae", file), ContainsSubstring("in this file"));
}

TEST_CASE("collada: an older version is refused by name", "[scenes][collada]") {
    CHECK_THROWS_WITH(
        TemporaryFiles().load("a.dae", "<COLLADA version=\"1.3.1\"><library/></COLLADA>"),
        ContainsSubstring("COLLADA 1.3.1 is not supported") && ContainsSubstring("1.4"));
}

TEST_CASE("collada: a skin is shown as it was bound, a morph in its basic form",
          "[scenes][collada]") {
    ColladaText text;
    text.libraries =
        "<library_controllers><controller id=\"skin\"><skin "
        "source=\"#square\"><bind_shape_matrix>1 "
        "0 0 5 0 1 0 0 0 0 1 0 0 0 0 1</bind_shape_matrix></skin></controller><controller "
        "id=\"morph\"><morph source=\"#square\"/></controller><controller id=\"both\"><skin "
        "source=\"#morph\"/></controller></library_controllers>";
    const auto node = [](const std::string& id) {
        return "<node><translate>0 0 1</translate><instance_controller url=\"#" + id +
               "\"><bind_material><technique_common><instance_material symbol=\"paint\" "
               "target=\"#mat\"/></technique_common></bind_material></instance_controller></node>";
    };
    text.more_nodes = node("skin");
    const Scene skinned = load(text);
    CHECK(warns(skinned, "a skin is not supported: the mesh is in the pose"));
    CHECK(skinned.triangles.size() == 4);
    CHECK(skinned.vertices[4] == Vec3(5, 0, 1));
    CHECK(skinned.materials.size() == 1);
    text.more_nodes = node("both");
    const Scene both = load(text);
    CHECK(warns(both, "a skin is not supported"));
    CHECK(warns(both, "a morph is not supported"));
    CHECK(both.vertices[4] == Vec3(0, 0, 1));
    text.libraries = replaced(text.libraries, "morph source=\"#square\"", "morph source=\"#both\"");
    CHECK_THROWS_WITH(load(text), ContainsSubstring("controllers in a circle"));
    text.more_nodes = node("nothing");
    CHECK_THROWS_WITH(load(text), ContainsSubstring("no <controller id=\"nothing\">"));
}

TEST_CASE("collada: instances of instances end in an error before memory or patience do",
          "[scenes][collada]") {
    ColladaText text;
    text.libraries = "<library_nodes><node id=\"n0\"/>";
    for (int i = 1; i < 60; ++i) {
        const std::string below = "<instance_node url=\"#n" + std::to_string(i - 1) + "\"/>";
        text.libraries += "<node id=\"n" + std::to_string(i) + "\">" + below + below + "</node>";
    }
    text.libraries += "</library_nodes>";
    text.more_nodes = "<node><instance_node url=\"#n59\"/></node>";
    CHECK_THROWS_WITH(load(text), ContainsSubstring("instances of instances"));
}

TEST_CASE("collada: an empty scene says what was left out on the way", "[scenes][collada]") {
    ColladaText text;
    text.geometry = "<geometry id=\"square\"><mesh><lines count=\"1\"/></mesh></geometry>";
    text.libraries = "<library_animations><animation/></library_animations>";
    CHECK_THROWS_WITH(load(text), ContainsSubstring("no triangles") &&
                                      ContainsSubstring("<lines> is not supported") &&
                                      ContainsSubstring("an animation is not supported"));
}

TEST_CASE("collada: a mesh of vertices alone is named", "[scenes][collada]") {
    CHECK_THROWS_WITH(load(mesh_of(kLetterC, "8", "")),
                      ContainsSubstring("no triangles") && ContainsSubstring("vertices alone"));
}

TEST_CASE("collada: of several scenes the one that is instanced is shown", "[scenes][collada]") {
    ColladaText text;
    std::string file = text.text();
    file = replaced(file, "<library_visual_scenes>",
                    "<library_visual_scenes><visual_scene id=\"other\"><node/></visual_scene>");
    CHECK(TemporaryFiles().load("scene.dae", file).warnings.empty());
    file = replaced(file, "<scene><instance_visual_scene url=\"#s\"/></scene>", "");
    CHECK_THROWS_WITH(TemporaryFiles().load("scene.dae", file),
                      ContainsSubstring("<visual_scene id=\"other\">") &&
                          ContainsSubstring("the first <visual_scene> is used"));
}
