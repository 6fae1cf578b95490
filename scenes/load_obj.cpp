#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>

#include "reference/base/error.h"
#include "reference/contract/records.h"
#include "scenes/add_polygon.h"
#include "scenes/corner_vertices.h"
#include "scenes/file_scene.h"
#include "scenes/loaders.h"
#include "scenes/mesh.h"
#include "scenes/obj_lines.h"
#include "scenes/obj_materials.h"
#include "scenes/parse_number.h"

namespace scotty::scenes {

using reference::Error;
using reference::Scene;

namespace {

/// Unknown materials and keywords that are named in warnings before the rest is only counted.
constexpr std::size_t kMaxNamed = 8;

/// A number of a list, from 1 or from -1 on; 0: not given.
struct ObjCorner {
    std::int64_t position = 0;
    std::int64_t texture = 0;
    std::int64_t normal = 0;
};

template <std::size_t count>
bool is_among(std::string_view key, const std::string_view (&list)[count]) {
    return std::find(std::begin(list), std::end(list), key) != std::end(list);
}

constexpr std::string_view kWithoutEffect[] = {
    "g",          "o",         "mg",    "bevel", "c_interp", "d_interp", "lod",
    "shadow_obj", "trace_obj", "ctech", "stech", "vp",       "vt"};
constexpr std::string_view kFreeForm[] = {"curv", "curv2", "surf", "bzp", "bsp",  "cdc",
                                          "cdp",  "res",   "con",  "sp",  "scrv", "hole"};
/// What belongs to a free-form element that has been noted by itself.
constexpr std::string_view kFreeFormParts[] = {"cstype", "deg",  "bmat", "step",
                                               "parm",   "trim", "end"};

/// Reads the file twice: first the lists of positions and normals, which faces may refer to before
/// they are complete, then the faces. So no face is kept in a form other than its triangles.
class ObjLoader {
 public:
    explicit ObjLoader(std::string path) : path_(std::move(path)), materials_(notes_) {}

    Scene load(CameraChoice choice) {
        read_lists();
        if (scene_.vertices.empty()) {
            throw Error::bad_input(path_,
                                   "no vertices ('v' lines): not an OBJ file, or an empty one");
        }
        if (scene_.vertices.size() >= reference::kNone) {
            throw Error::bad_input(path_, fmt::format("{} vertices, at most {} can be numbered: "
                                                      "split the file",
                                                      scene_.vertices.size(), reference::kNone));
        }
        read_faces();
        note_unknown_names();
        materials_.note_missing();
        if (scene_.triangles.empty()) throw no_triangles();
        scene_.file.meshes = scene_.file.instances = 1;
        settle_emission(scene_, notes_);
        settle_camera(scene_, {}, choice, notes_);
        notes_.write_to(scene_.warnings);
        return std::move(scene_);
    }

 private:
    void read_lists() {
        ObjLines lines(path_);
        const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
        std::size_t faces = 0;
        while (lines.next()) {
            const std::string_view key = lines.key();
            if (key == "v") {
                read_position(lines);
            } else if (key == "vn") {
                read_normal(lines);
            } else if (key == "vt") {
                ++texture_coordinates_;
            } else if (key == "f" || key == "fo") {
                ++faces;
            } else if (key == "mtllib") {
                materials_.read_libraries(folder, lines.rest());
            }
        }
        position_count_ = scene_.vertices.size();
        scene_.normals.resize(position_count_);
        scene_.triangles.reserve(faces);
        scene_.material_of.reserve(faces);
    }

    void read_position(const ObjLines& lines) {
        std::string_view text = lines.numbers();
        Vec3 position;
        for (int k = 0; k < 3; ++k) position[k] = coordinate(lines, take_word(text));
        scene_.vertices.push_back(position);
        if (trimmed(text).empty()) return;
        int more = 0;
        float weight = 1.0f;
        for (std::string_view word = take_word(text); !word.empty(); word = take_word(text)) {
            const float value = coordinate(lines, word);
            if (more++ == 0) weight = value;
        }
        if (more >= 3) notes_.add("vertex colours are not supported: left out");
        if (more == 1 && weight != 1.0f) {
            notes_.add("a vertex with a weight, which is for curves: taken without");
        }
    }

    float coordinate(const ObjLines& lines, std::string_view word) const {
        const std::optional<float> value = parse_finite_float(word);
        if (value && std::abs(*value) <= reference::kMaxCoordinate) return *value;
        lines.fail(
            fmt::format("vertex {}: expected three finite numbers of at most {:g}, found "
                        "'{}'",
                        scene_.vertices.size() + 1, reference::kMaxCoordinate, shown(word)));
    }

    void read_normal(const ObjLines& lines) {
        std::string_view text = lines.numbers();
        Vec3 normal;
        for (int k = 0; k < 3; ++k) {
            const std::string_view word = take_word(text);
            const std::optional<float> value = parse_finite_float(word);
            if (!value && !is_not_finite(word)) {
                lines.fail(fmt::format("normal {}: expected three numbers, found '{}'",
                                       normals_.size() + 1, shown(word)));
            }
            normal[k] = value.value_or(std::nanf(""));
        }
        if (std::isnan(normal.x + normal.y + normal.z)) {
            notes_.add("a normal that is not finite: flat there");
            normal = Vec3(0.0f);
        }
        normals_.push_back(normal);
    }

    void read_faces() {
        ObjLines lines(path_);
        CornerVertices vertices(scene_);
        PolygonAdder polygons(scene_, notes_);
        std::vector<std::uint32_t> corners;
        while (lines.next()) {
            const std::string_view key = lines.key();
            if (key == "v") {
                ++before_.position;
            } else if (key == "vt") {
                ++before_.texture;
            } else if (key == "vn") {
                ++before_.normal;
            } else if (key == "f" || key == "fo") {
                read_face(lines, vertices, corners);
                polygons.add(corners, material());
            } else if (key == "usemtl") {
                material_name_ = lines.rest();
                material_ = reference::kNone;
            } else if (key == "s") {
                std::string_view text = lines.numbers();
                const std::string_view group = take_word(text);
                is_smooth_ = !group.empty() && group != "off" && group != "0";
            } else {
                note_statement(key);
            }
        }
        vertices.drop_unused();
    }

    void read_face(const ObjLines& lines, CornerVertices& vertices,
                   std::vector<std::uint32_t>& corners) {
        corners.clear();
        bool has_normals = false;
        std::string_view text = lines.numbers();
        for (std::string_view word = take_word(text); !word.empty(); word = take_word(text)) {
            const ObjCorner corner = read_corner(lines, word);
            const std::size_t position =
                index(lines, corner.position, before_.position, position_count_, "vertex", "v");
            Vec3 normal(0.0f);
            if (corner.normal != 0) {
                has_normals = true;
                normal = normals_[index(lines, corner.normal, before_.normal, normals_.size(),
                                        "normal", "vn")];
            }
            if (corner.texture != 0) check_texture(corner.texture);
            corners.push_back(vertices.vertex(static_cast<std::uint32_t>(position), normal));
        }
        if (corners.size() < 3) {
            lines.fail(
                fmt::format("a face needs at least 3 corners, found {} (lines are 'l' "
                            "elements, points 'p')",
                            corners.size()));
        }
        if (is_smooth_ && !has_normals) {
            notes_.add("a smoothed face without normals ('vn'): it is flat");
        }
    }

    /// v, v/vt, v//vn or v/vt/vn; slashes with nothing behind them are taken, too.
    static ObjCorner read_corner(const ObjLines& lines, std::string_view word) {
        ObjCorner corner;
        const char* at = word.data();
        const char* end = at + word.size();
        std::int64_t* const fields[] = {&corner.position, &corner.texture, &corner.normal};
        for (std::int64_t* const field : fields) {
            if (at != end && *at != '/') {
                if (*at == '+' && at + 1 != end && at[1] != '-') ++at;
                const auto [stop, status] = std::from_chars(at, end, *field);
                if (status != std::errc() || *field == 0) break;
                at = stop;
            }
            if (at == end || *at != '/' || field == &corner.normal) break;
            ++at;
        }
        if (at == end && corner.position != 0) return corner;
        lines.fail(
            fmt::format("expected a vertex index, from 1 or from -1 on, as in 7, 7/1, "
                        "7//3 or 7/1/3, found '{}'",
                        shown(word)));
    }

    /// From 0 on. `before`: how many of the list precede the face; negative numbers count back from
    /// there.
    static std::size_t index(const ObjLines& lines, std::int64_t number, std::int64_t before,
                             std::size_t count, const char* what, const char* key) {
        if (number > 0 && static_cast<std::uint64_t>(number) <= count) {
            return static_cast<std::size_t>(number - 1);
        }
        if (number < 0 && number >= -before) return static_cast<std::size_t>(before + number);
        lines.fail(number < 0
                       ? fmt::format("{} index {} out of range, {} '{}' lines come before it", what,
                                     number, before, key)
                       : fmt::format("{} index {} out of range, the file has {} '{}' lines", what,
                                     number, count, key));
    }

    void check_texture(std::int64_t number) {
        const bool is_there = number > 0
                                  ? static_cast<std::uint64_t>(number) <= texture_coordinates_
                                  : number >= -before_.texture;
        if (!is_there) {
            notes_.add("an index of a texture coordinate ('vt') out of range: not needed");
        }
    }

    std::uint32_t material() {
        if (material_ == reference::kNone) material_ = find_material();
        return material_;
    }

    std::uint32_t find_material() {
        if (!material_name_) {
            notes_.add(kDefaultMaterialNote);
            return default_material();
        }
        const auto known = indices_.find(*material_name_);
        if (known != indices_.end()) return known->second;
        const ObjMaterial* found = materials_.find(*material_name_);
        if (found == nullptr) ++unknown_materials_;
        const std::uint32_t made =
            found == nullptr ? default_material() : add_material(scene_, from_obj(*found, notes_));
        if (found == nullptr && unknown_materials_ <= kMaxNamed) note_unknown(*material_name_);
        indices_.emplace(*material_name_, made);
        return made;
    }

    std::uint32_t default_material() {
        if (default_material_ == reference::kNone) default_material_ = add_default_material(scene_);
        return default_material_;
    }

    void note_unknown(const std::string& name) {
        const std::string other = materials_.name_in_other_case(name);
        const std::string hint =
            other.empty() ? "" : fmt::format(" (there is '{}'; case counts)", shown(other));
        notes_.add(fmt::format("the material '{}' is in no material library{}: grey 0.5",
                               shown(name), hint));
    }

    void note_statement(std::string_view key) {
        if (key == "mtllib" || is_among(key, kWithoutEffect) || is_among(key, kFreeFormParts)) {
            return;
        }
        if (key == "l" || key == "p" || is_among(key, kFreeForm)) {
            notes_.add(
                fmt::format("'{}' elements (lines, points, curves, surfaces) are not "
                            "supported: left out",
                            key));
        } else if (key == "usemap" || key == "maplib") {
            notes_.add("a texture is not supported: the plain colour is used");
        } else if (key == "call" || key == "csh") {
            notes_.add(
                fmt::format("'{}' statements (other files, commands) are not supported: "
                            "left out",
                            key));
        } else if (unknown_keys_.size() < kMaxNamed || unknown_keys_.contains(key)) {
            ++unknown_keys_.emplace(std::string(key), 0u).first->second;
        } else {
            ++further_unknown_;
        }
    }

    void note_unknown_names() {
        for (const auto& [key, times] : unknown_keys_) {
            notes_.add(fmt::format("'{}' is no statement of an OBJ file: left out", shown(key)),
                       times);
        }
        notes_.add("a line that is no statement of an OBJ file: left out", further_unknown_);
        if (unknown_materials_ > kMaxNamed) {
            notes_.add(fmt::format("{} further materials are in no material library: grey 0.5",
                                   unknown_materials_ - kMaxNamed));
        }
    }

    Error no_triangles() const {
        return Error::bad_input(
            path_, notes_.explain(fmt::format("no triangles in the file ({} vertices and no "
                                              "faces), nothing to render",
                                              position_count_)));
    }

    std::string path_;
    Notes notes_;
    Scene scene_;
    ObjMaterials materials_;
    std::vector<Vec3> normals_;
    std::size_t position_count_ = 0;  ///< the file's; copies for further normals come behind
    std::size_t texture_coordinates_ = 0;
    /// How many lines of each list have been passed.
    ObjCorner before_;
    bool is_smooth_ = false;
    std::optional<std::string> material_name_;
    std::uint32_t material_ = reference::kNone;  ///< kNone: to be looked up
    std::uint32_t default_material_ = reference::kNone;
    std::map<std::string, std::uint32_t> indices_;
    std::size_t unknown_materials_ = 0;
    std::map<std::string, std::size_t, std::less<>> unknown_keys_;
    std::size_t further_unknown_ = 0;
};

}  // namespace

Scene load_obj(const std::string& path, CameraChoice camera) {
    return ObjLoader(path).load(camera);
}

}  // namespace scotty::scenes
