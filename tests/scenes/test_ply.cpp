#include <algorithm>
#include <cstring>
#include <limits>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/scenes/mesh_checks.h"
#include "tests/scenes/temporary_files.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using reference::Scene;
using reference::Vec3;
using tests::TemporaryFiles;
using tests::warns;

namespace {

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kIndices = "property list uchar int vertex_indices\n";

/// "element vertex 3", xyz, then `more`.
std::string ply_header(const std::string& format, std::size_t vertices, const std::string& more) {
    return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(vertices) + "\n" +
           kXyz + more + "end_header\n";
}

const std::string kPlyHeader = ply_header("ascii", 3, "element face 1\n" + kIndices);
const std::string kSquare = "-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n";
const std::string kSquareHeader = ply_header("ascii", 4, "element face 1\n" + kIndices);

/// [-1, 1]^2 at z = 0, in two triangles with the front towards +z.
void check_ply_square(const Scene& scene) {
    INFO(tests::all_warnings(scene));
    REQUIRE(scene.triangles.size() == 2);
    CHECK(scene.vertices.size() == 4);
    CHECK(tests::area_of(scene) == Approx(4.0));
    CHECK(tests::front_of(scene, 0) == Vec3(0, 0, 1));
    CHECK(tests::front_of(scene, 1) == Vec3(0, 0, 1));
}

/// Values as they stand in a binary file.
class Bytes {
 public:
    explicit Bytes(bool is_big) : is_big_(is_big) {}

    template <class Value>
    Bytes& add(Value value) {
        char raw[sizeof value];
        std::memcpy(raw, &value, sizeof value);
        if (is_big_) std::reverse(raw, raw + sizeof value);
        text_.append(raw, sizeof value);
        return *this;
    }
    /// `value` as the type that PLY calls `name`.
    Bytes& add(const std::string& name, double value) {
        if (name == "char" || name == "int8") return add(static_cast<std::int8_t>(value));
        if (name == "uchar" || name == "uint8") return add(static_cast<std::uint8_t>(value));
        if (name == "short" || name == "int16") return add(static_cast<std::int16_t>(value));
        if (name == "ushort" || name == "uint16") return add(static_cast<std::uint16_t>(value));
        if (name == "int" || name == "int32") return add(static_cast<std::int32_t>(value));
        if (name == "uint" || name == "uint32") return add(static_cast<std::uint32_t>(value));
        if (name == "float" || name == "float32") return add(static_cast<float>(value));
        return add(value);
    }
    const std::string& text() const { return text_; }

 private:
    bool is_big_;
    std::string text_;
};

const char* const kTypes[] = {"char",  "uchar",  "short",   "ushort", "int",   "uint",
                              "float", "double", "int8",    "uint8",  "int16", "uint16",
                              "int32", "uint32", "float32", "float64"};

constexpr double kCorners[4][3] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};

}  // namespace

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
    CHECK_THROWS_WITH(files.load("b.ply", binary),
                      ContainsSubstring("face 0") && ContainsSubstring("truncated?"));
}

TEST_CASE("ply: what is wrong is named with its element", "[scenes][ply]") {
    const TemporaryFiles files;
    const auto fails = [&](const std::string& text, const std::string& where,
                           const std::string& what) {
        CHECK_THROWS_WITH(files.load("a.ply", text), ContainsSubstring("a.ply") &&
                                                         ContainsSubstring(where) &&
                                                         ContainsSubstring(what));
    };
    fails(kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n", "face 0", "vertex index 7 out of range");
    fails(kPlyHeader + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "face 0", "out of range");
    fails(kPlyHeader + "0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n", "vertex 2", "finite");
    fails(kPlyHeader + "0 0 0\n1 0 0\n", "vertex 2", "truncated?");
    fails(kPlyHeader + "0 0 0\n1 0 hello\n", "vertex 1", "'hello'");
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

TEST_CASE("ply: both byte orders, all types, for coordinates and indices", "[scenes][ply]") {
    const TemporaryFiles files;
    const std::uint64_t right =
        reference::fingerprint(files.load("a.ply", kSquareHeader + kSquare + "4 0 1 2 3\n"));
    for (const bool is_big : {false, true}) {
        for (const std::string type : kTypes) {
            INFO(type << (is_big ? " big" : " little"));
            const bool has_sign = type[0] != 'u';
            const std::string coordinate = has_sign ? type : "float";
            std::string header = tests::replaced(
                kSquareHeader, "ascii", is_big ? "binary_big_endian" : "binary_little_endian");
            for (const char* name : {" x", " y", " z"}) {
                header = tests::replaced(header, std::string("float") + name, coordinate + name);
            }
            header = tests::replaced(header, "uchar int", type + " " + type);
            Bytes bytes(is_big);
            for (const auto& corner : kCorners) {
                for (const double value : corner) bytes.add(coordinate, value);
            }
            for (const double value : {4, 0, 1, 2, 3}) bytes.add(type, value);
            const Scene scene = files.load("a.ply", header + bytes.text());
            check_ply_square(scene);
            CHECK(reference::fingerprint(scene) == right);
            CHECK_THROWS_WITH(
                files.load("b.ply", header + bytes.text().substr(0, bytes.text().size() - 1)),
                ContainsSubstring("face 0") && ContainsSubstring("truncated?"));
            CHECK(warns(files.load("c.ply", header + bytes.text() + "x"),
                        "data behind the last element"));
        }
    }
}

TEST_CASE("ply: properties in any order, elements and lists between", "[scenes][ply]") {
    const TemporaryFiles files;
    const std::string header =
        "comment made by hand\nobj_info nothing\n"
        "element header_things 2\nproperty list char double many\nproperty short one\n"
        "element vertex 4\nproperty double z\nproperty list uchar float weights\n"
        "property float y\nproperty uchar flag\nproperty float x\n"
        "element nothing 7\n"
        "element face 1\nproperty uchar kind\nproperty list uint16 ushort vertex_index\n"
        "property list uchar float texcoord\nelement edge 1\nproperty int vertex1\n"
        "property int vertex2\nend_header\n";
    const Scene text = files.load("a.ply", "ply\nformat ascii 1.0\n" + header +
                                               "3 .5 nan 7 1\n0 2\n"
                                               "0 0 -1 5 -1\n0 2 8 9 -1 5 1\n0 1 8 1 5 1\n0 0 1 5 "
                                               "-1\n8 4 0 1 2 3 2 .5 .5\n0 1\n");
    check_ply_square(text);
    CHECK(warns(text, "the element 'header_things'"));
    CHECK(warns(text, "lines and points"));
    CHECK_FALSE(warns(text, "behind the last element"));
    for (const bool is_big : {false, true}) {
        Bytes bytes(is_big);
        bytes.add("char", 1).add("double", 0.5).add("short", 3);
        bytes.add("char", 0).add("short", 3);
        for (const auto& corner : kCorners) {
            bytes.add("double", corner[2]).add("uchar", 1).add("float", 3);
            bytes.add("float", corner[1]).add("uchar", 5).add("float", corner[0]);
        }
        bytes.add("uchar", 1).add("ushort", 4);
        for (const double index : {0, 1, 2, 3}) bytes.add("ushort", index);
        bytes.add("uchar", 1).add("float", 0.5).add("int", 0).add("int", 1);
        const std::string format = is_big ? "binary_big_endian" : "binary_little_endian";
        const Scene binary =
            files.load("b.ply", "ply\nformat " + format + " 1.0\n" + header + bytes.text());
        CHECK(reference::fingerprint(binary) == reference::fingerprint(text));
        CHECK(binary.warnings == text.warnings);
    }
}

TEST_CASE("ply: data that begins with a line end", "[scenes][ply]") {
    const TemporaryFiles files;
    const std::string header = tests::replaced(kSquareHeader, "ascii", "binary_little_endian");
    for (const char* end : {"\n", "\r\n", "\r"}) {
        for (const std::string first : {"\n", "\n\n", "\r\n", "\r", " \n"}) {
            std::string with_ends;
            for (const char c : header)
                with_ends += c == '\n' ? std::string(end) : std::string(1, c);
            Bytes bytes(false);
            for (const auto& corner : kCorners) {
                for (const double value : corner) bytes.add("float", value);
            }
            // The first coordinate, -1, changes in its last bits.
            std::string data = bytes.text();
            data.replace(0, first.size(), first);
            const std::string face("\4\0\0\0\0\1\0\0\0\2\0\0\0\3\0\0\0", 17);
            INFO("line end of " << std::string(end).size() << " bytes, data after "
                                << first.size());
            const Scene scene = files.load("a.ply", with_ends + data + face);
            REQUIRE(scene.vertices.size() == 4);
            CHECK(scene.vertices[0].x == Approx(-1).epsilon(0.01));
            CHECK(scene.vertices[2] == Vec3(1, 1, 0));
            CHECK_FALSE(warns(scene, "behind the last element"));
        }
    }
}

TEST_CASE("ply: triangle strips", "[scenes][ply]") {
    const TemporaryFiles files;
    const std::string corners = "-1 -1 0\n1 -1 0\n-1 1 0\n1 1 0\n";
    const auto load = [&](const std::string& type, const std::string& strips) {
        return files.load("a.ply", ply_header("ascii", 4,
                                              "element tristrips 1\nproperty list int " + type +
                                                  " vertex_indices\n") +
                                       corners + strips);
    };
    check_ply_square(load("int", "4 0 1 2 3\n"));
    check_ply_square(load("int", "8 0 1 2 -1 1 3 2 -1\n"));
    check_ply_square(load("uint", "7 0 1 2 4294967295 1 3 2\n"));
    check_ply_square(load("uchar", "7 0 1 2 255 1 3 2\n"));
    // Joined by triangles without an area: 0 1 2, 1 2 2, 2 2 2, 2 2 1, then 2 1 3.
    check_ply_square(load("int", "7 0 1 2 2 2 1 3\n"));
    CHECK(load("int", "5 -1 -1 0 1 2\n").triangles.size() == 1);
    CHECK_THROWS_WITH(load("int", "4 0 1 2 9\n"),
                      ContainsSubstring("tristrips 0") && ContainsSubstring("vertex index 9"));
    CHECK_THROWS_WITH(load("int", "4 0 1 2 -2\n"), ContainsSubstring("vertex index -2"));
    CHECK_THROWS_WITH(load("int", "2 0 1\n"), ContainsSubstring("no triangles"));
    CHECK_THROWS_WITH(load("int", "8 0 1 2\n"), ContainsSubstring("truncated?"));
}

TEST_CASE("ply: faces that come before the vertices", "[scenes][ply]") {
    const std::string text = "ply\nformat ascii 1.0\nelement face 1\n" + kIndices +
                             "element vertex 4\n" + kXyz + "end_header\n4 0 1 2 3\n" + kSquare;
    check_ply_square(TemporaryFiles().load("a.ply", text));
}

TEST_CASE("ply: concave polygons, vertices that no face uses, normals", "[scenes][ply]") {
    const TemporaryFiles files;
    const Scene concave =
        files.load("a.ply", ply_header("ascii", 9, "element face 1\n" + kIndices) +
                                "99 99 99\n0 0 0\n4 0 0\n4 1 0\n1 1 0\n1 3 0\n4 3 0\n4 4 0\n0 4 0\n"
                                "8 1 2 3 4 5 6 7 8\n");
    CHECK(tests::area_of(concave) == Approx(10.0));
    CHECK(concave.triangles.size() == 6);
    CHECK(concave.vertices.size() == 8);
    const std::string normals =
        "property float nx\nproperty float ny\nproperty float nz\nelement face 1\n" + kIndices;
    const Scene smooth = files.load("b.ply", ply_header("ascii", 3, normals) +
                                                 "0 0 0 0 0 1\n1 0 0 nan nan nan\n0 1 0 0 2 0\n"
                                                 "3 0 1 2\n");
    CHECK(smooth.normals == std::vector<Vec3>{Vec3(0, 0, 1), Vec3(0, 0, 0), Vec3(0, 1, 0)});
    CHECK(warns(smooth, "a normal that is not finite"));
}

TEST_CASE("ply: moved and turned in the file is moved and turned in the scene", "[scenes][ply]") {
    const TemporaryFiles files;
    const Scene plain = files.load("a.ply", kSquareHeader + kSquare + "4 0 1 2 3\n");
    const Scene moved =
        files.load("a.ply", kSquareHeader + "7 -1 -3\n7 1 -3\n7 1 -1\n7 -1 -1\n4 0 1 2 3\n");
    REQUIRE(plain.triangles == moved.triangles);
    for (std::size_t i = 0; i < plain.vertices.size(); ++i) {
        const Vec3& v = plain.vertices[i];
        CHECK(moved.vertices[i] == Vec3(7, v.x, v.y - 2));
    }
}

TEST_CASE("ply: headers as programs write them", "[scenes][ply]") {
    const TemporaryFiles files;
    const auto is_square = [&](const std::string& from, const std::string& to) {
        INFO(to);
        check_ply_square(files.load(
            "a.ply", tests::replaced(kSquareHeader, from, to) + kSquare + "4 0 1 2 3\n"));
    };
    is_square("ply\n", "\xef\xbb\xbfply\n");
    is_square("ply\n", "ply \n");
    is_square("ply\n", "ply\r\n");
    is_square("ply\n", "ply\ncomment x: 4 # \xc3\xa4\n\ncomment\n");
    is_square("property float x", "  property\tfloat   x  ");
    is_square("vertex_indices", "vertex_index");
    check_ply_square(
        files.load("a.ply", kSquareHeader + "-1 -1\n0 1 -1 0 1 1 0 -1 1 0 4 0\n1 2\n3"));
}

TEST_CASE("ply: what is left out is said", "[scenes][ply]") {
    const TemporaryFiles files;
    const auto said = [&](const std::string& text, const std::string& warning) {
        CHECK(warns(files.load("a.ply", text), warning));
    };
    const std::string colour =
        "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n" +
        kIndices;
    said(ply_header("ascii", 3, colour) + "0 0 0 1 2 3\n1 0 0 1 2 3\n0 1 0 1 2 3\n3 0 1 2\n",
         "vertex colours");
    said(ply_header("ascii", 3, "element face 1\n" + kIndices + "property uchar red\n") +
             "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 7\n",
         "face colours");
    said(tests::replaced(kSquareHeader, "ply\n", "ply\ncomment TextureFile a.png\n") + kSquare +
             "4 0 1 2 3\n",
         "a texture is not supported");
    said(tests::replaced(kSquareHeader, "face 1", "face 2") + kSquare + "4 0 1 2 3\n2 0 1\n",
         "fewer than 3 corners");
    said(kSquareHeader + kSquare + "4 0 1 2 3\n4 0 1 2 3\n", "data behind the last element");
    CHECK_THROWS_WITH(files.load("a.ply", ply_header("ascii", 1, "") + "0 0 0\n"),
                      ContainsSubstring("no triangles") && ContainsSubstring("1 vertices"));
}

TEST_CASE("ply: a count that is a lie costs neither memory nor time", "[scenes][ply]") {
    const TemporaryFiles files;
    for (const char* count : {"4000000000", "4294967294"}) {
        const std::string header =
            tests::replaced(kPlyHeader, "vertex 3", std::string("vertex ") + count);
        CHECK_THROWS_WITH(files.load("a.ply", header + "0 0 0\n"),
                          ContainsSubstring("vertex 1") && ContainsSubstring("truncated?"));
        CHECK_THROWS_WITH(files.load("a.ply", tests::replaced(kPlyHeader, "face 1",
                                                              std::string("face ") + count) +
                                                  "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"),
                          ContainsSubstring("face 1") && ContainsSubstring("truncated?"));
    }
    CHECK_THROWS_WITH(
        files.load("a.ply", tests::replaced(kPlyHeader, "vertex 3", "vertex 18446744073709551615")),
        ContainsSubstring("at most"));
    CHECK_THROWS_WITH(files.load("a.ply", tests::replaced(kPlyHeader, "uchar int", "double int") +
                                              "0 0 0\n1 0 0\n0 1 0\n9e15 0 1 2\n"),
                      ContainsSubstring("face 0") && ContainsSubstring("truncated?"));
    CHECK_THROWS_WITH(files.load("a.ply", tests::replaced(kPlyHeader, "uchar int", "double int") +
                                              "0 0 0\n1 0 0\n0 1 0\n1e300 0 1 2\n"),
                      ContainsSubstring("face 0") && ContainsSubstring("list length"));
}

TEST_CASE("ply: headers and faces that cannot be are named", "[scenes][ply]") {
    const TemporaryFiles files;
    const std::string body = "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    const auto fails = [&](const std::string& from, const std::string& to,
                           const std::string& what) {
        INFO(to);
        CHECK_THROWS_WITH(files.load("a.ply", tests::replaced(kPlyHeader + body, from, to)),
                          ContainsSubstring("a.ply") && ContainsSubstring(what));
    };
    fails("1.0", "2.0", "version 1.0");
    fails("format ascii 1.0\n", "", "no format");
    fails("element face", "element vertex", "occurs twice");
    fails("property list uchar int vertex_indices", "property int vertex_indices",
          "one list 'vertex_indices'");
    fails("vertex_indices", "corners", "one list 'vertex_indices'");
    fails("float x", "list uchar float x", "found 1 (a single value is needed)");
    fails("element face 1", "element face one", "not understood");
    fails("3 0 1 2", "3 0 1 1.5", "vertex index 1.5");
    fails("3 0 1 2", "-3 0 1 2", "list length");
    fails("3 0 1 2", "3.5 0 1 2", "list length");
    fails("1 0 0", "1 0 2e12", "vertex 1: z");
    fails("1 0 0", "1 0 1e99", "vertex 1: z");
}
