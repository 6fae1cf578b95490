/// Transformed in the file is transformed by hand: the same scene, written in two ways.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <random>

#include "reference/base/error.h"
#include "scenes/affine.h"
#include "tests/catch.h"
#include "tests/scenes/collada_text.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::Scene;
using reference::Vec3;
using scenes::Affine;
using scenes::Point;
using tests::ColladaText;
using tests::TemporaryFiles;

namespace {

std::string matrix_text(const Affine& m, double w = 1.0) {
    std::vector<double> values;
    for (const auto& row : m.m) {
        for (const double value : row) values.push_back(value * w);
    }
    return fmt::format("<matrix>{} 0 0 0 {}</matrix>", fmt::join(values, " "), w);
}

/// A step of a transform, as an element and as numbers.
struct Step {
    std::string text;
    Affine affine;
};

Step random_step(std::mt19937& random) {
    std::uniform_real_distribution<double> number(-2.0, 2.0);
    const Point v = {number(random), number(random), number(random)};
    Step step;
    switch (random() % 3) {
        case 0:
            step.text = fmt::format("<translate>{}</translate>", fmt::join(v, " "));
            for (std::size_t k = 0; k < 3; ++k) step.affine.m[k][3] = v[k];
            return step;
        case 1:
            step.text = fmt::format("<scale>{}</scale>", fmt::join(v, " "));
            for (std::size_t k = 0; k < 3; ++k) step.affine.m[k][k] = v[k];
            return step;
        default: {
            const double degrees = 90.0 * v[0];
            const double c = std::cos(degrees * scenes::kDegree);
            const double s = std::sin(degrees * scenes::kDegree);
            step.text = fmt::format("<rotate>0 0 3 {}</rotate>", degrees);
            step.affine.m = {{{c, -s, 0, 0}, {s, c, 0, 0}, {0, 0, 1, 0}}};
            return step;
        }
    }
}

void check_same(const Scene& found, const Scene& expected) {
    REQUIRE(found.vertices.size() == expected.vertices.size());
    CHECK(found.triangles == expected.triangles);
    CHECK(found.warnings == expected.warnings);
    for (std::size_t i = 0; i < found.vertices.size(); ++i) {
        CHECK(reference::length(found.vertices[i] - expected.vertices[i]) < 1e-4f);
        CHECK(reference::length(found.normals[i] - expected.normals[i]) < 1e-4f);
    }
    CHECK(reference::length(found.camera.position - expected.camera.position) < 1e-4f);
    CHECK(reference::length(found.camera.forward - expected.camera.forward) < 1e-4f);
}

}  // namespace

TEST_CASE("collada: steps, nodes inside nodes and one matrix place a mesh alike",
          "[scenes][collada]") {
    std::mt19937 random(11);
    for (int trial = 0; trial < 40; ++trial) {
        std::string steps;
        std::string nodes;
        std::string ends;
        Affine product;
        for (int i = 0; i < 4; ++i) {
            const Step step = random_step(random);
            steps += step.text;
            nodes += "<node>" + step.text;
            ends += "</node>";
            product = product * step.affine;
        }
        INFO(steps);
        const std::string mesh =
            "<instance_geometry url=\"#square\"><bind_material><technique_common>"
            "<instance_material symbol=\"paint\" target=\"#mat\"/></technique_common>"
            "</bind_material></instance_geometry>";
        ColladaText text;
        text.more_nodes = "<node>" + matrix_text(product) + mesh + "</node>";
        const Scene expected = load(text);
        text.more_nodes = "<node>" + steps + mesh + "</node>";
        check_same(load(text), expected);
        text.more_nodes = nodes + mesh + ends;
        check_same(load(text), expected);
        text.libraries = "<library_nodes><node id=\"shape\">" + mesh + "</node></library_nodes>";
        text.more_nodes = "<node>" + steps + "<instance_node url=\"#shape\"/></node>";
        check_same(load(text), expected);
        text.more_nodes = "<node>" + matrix_text(product, 0.99999982) + mesh + "</node>";
        check_same(load(text), expected);
        text.more_nodes = "<node>" + matrix_text(product, 4.0) + mesh + "</node>";
        check_same(load(text), expected);
    }
}

TEST_CASE("collada: a unit is a scale of everything, an up axis a rotation", "[scenes][collada]") {
    ColladaText text;
    text.mesh_transform = "<translate>.1 .2 .3</translate>";
    const Scene plain = load(text);
    for (const auto& [axis, turn] :
         {std::pair{"Z_UP", Affine{{{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}}}}},
          std::pair{"X_UP", Affine{{{{0, -1, 0, 0}, {1, 0, 0, 0}, {0, 0, 1, 0}}}}}}) {
        text.up_axis = axis;
        text.unit = "0.25";
        const Scene found = load(text);
        for (std::size_t i = 0; i < plain.vertices.size(); ++i) {
            const Point turned = turn.point(scenes::widened(plain.vertices[i]));
            const Vec3 expected = scenes::rounded(turned) * 0.25f;
            CHECK(reference::length(found.vertices[i] - expected) < 1e-7f);
        }
        const Vec3 eye = scenes::rounded(turn.point(scenes::widened(plain.camera.position)));
        CHECK(reference::length(found.camera.position - eye * 0.25f) < 1e-6f);
    }
}

TEST_CASE("collada: a matrix that is rounded is read, a perspective is an error",
          "[scenes][collada]") {
    ColladaText text;
    const auto mesh = [&](const std::string& last_row) {
        text.mesh_transform = "<matrix>1 0 0 5 0 1 0 0 0 0 1 0 " + last_row + "</matrix>";
        return load(text);
    };
    CHECK(mesh("0 0 0 1.0000002").vertices[0] == Vec3(5, 0, 0));
    CHECK(mesh("1e-9 -1e-9 0 0.99999982").vertices[0] == Vec3(5, 0, 0));
    CHECK(mesh("0 0 0 1.0000002").warnings.empty());
    CHECK(mesh("0 0 0 2").vertices[0] == Vec3(2.5f, 0, 0));
    CHECK_THROWS_WITH(mesh("0 0 -1 1"),
                      ContainsSubstring("no perspective") && ContainsSubstring("0 0 -1 1"));
    CHECK_THROWS_WITH(mesh("0 0 0 0"), ContainsSubstring("zeros"));
    text.mesh_transform = "<matrix>1 0 0 0 0 1 0 0 0 0 1 0 5 0 0 1</matrix>";
    CHECK_THROWS_WITH(load(text), ContainsSubstring("by columns"));
    text.mesh_transform = "";
    text.camera_transform = "<matrix>1 0 0 0 0 1 0 0 0 0 1 4 0 0 0 1.0000002</matrix>";
    CHECK(load(text).camera.position == Vec3(0, 0, 4));
}
