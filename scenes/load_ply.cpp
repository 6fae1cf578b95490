#include <algorithm>
#include <array>

#include "reference/base/error.h"
#include "reference/contract/records.h"
#include "scenes/add_polygon.h"
#include "scenes/corner_vertices.h"
#include "scenes/file_scene.h"
#include "scenes/loaders.h"
#include "scenes/mesh.h"
#include "scenes/ply_values.h"

namespace scotty::scenes {

using reference::Error;
using reference::Scene;

namespace {

constexpr std::array<const char*, 3> kPositionNames = {"x", "y", "z"};
constexpr std::array<const char*, 3> kNormalNames = {"nx", "ny", "nz"};

class PlyLoader {
 public:
    explicit PlyLoader(std::string path) : path_(std::move(path)), polygons_(scene_, notes_) {}

    Scene load(CameraChoice choice) {
        FileReader reader(path_);
        header_ = read_ply_header(reader);
        check_vertices();
        note_what_is_left_out();
        if (vertices_come_first()) {
            read_elements(reader, true, true);
        } else {
            // Polygons are cut once the positions of their corners are known.
            read_elements(reader, true, false);
            FileReader again(path_);
            read_ply_header(again);
            read_elements(again, false, true);
        }
        if (scene_.triangles.empty()) throw no_triangles();
        drop_unused_vertices(scene_, is_used_);
        scene_.file.meshes = scene_.file.instances = 1;
        settle_emission(scene_, notes_);
        settle_camera(scene_, {}, choice, notes_);
        notes_.write_to(scene_.warnings);
        return std::move(scene_);
    }

 private:
    [[noreturn]] void fail_header(const std::string& what) const {
        throw Error::bad_input(path_ + ": header", what);
    }

    void check_vertices() {
        const PlyElement* vertex = header_.element("vertex");
        if (vertex == nullptr || vertex->count == 0) {
            fail_header("no vertices (an element 'vertex' with at least one)");
        }
        if (vertex->count >= reference::kNone) {
            fail_header(fmt::format("{} vertices, at most {} can be numbered: split the file",
                                    vertex->count, reference::kNone));
        }
        for (const char* name : kPositionNames) {
            if (vertex->values_named(name) == 1 && vertex->value(name) != nullptr) continue;
            fail_header(
                fmt::format("vertex: expected one '{}', found {} (a single value is needed)", name,
                            vertex->values_named(name)));
        }
        vertex_count_ = static_cast<std::uint32_t>(vertex->count);
        has_normals_ = std::all_of(kNormalNames.begin(), kNormalNames.end(), [&](const char* name) {
            return vertex->values_named(name) == 1 && vertex->value(name) != nullptr;
        });
    }

    bool vertices_come_first() const {
        for (const PlyElement& element : header_.elements) {
            if (element.name == "vertex") return true;
            if (element.name == "face" || element.name == "tristrips") return false;
        }
        return true;
    }

    void note_what_is_left_out() {
        for (const PlyElement& element : header_.elements) {
            if (element.count == 0) continue;
            if (element.name == "vertex" || element.name == "face") {
                if (has_colours(element)) {
                    notes_.add(element.name == "vertex"
                                   ? "vertex colours are not supported: left out"
                                   : "face colours are not supported: left out");
                }
            } else if (element.name == "edge") {
                notes_.add("lines and points are not supported: left out");
            } else if (element.name != "tristrips") {
                notes_.add(fmt::format("the element '{}' is not supported: left out",
                                       shown(element.name)));
            }
        }
        if (header_.names_texture) {
            notes_.add("a texture is not supported: the plain colour is used");
        }
    }

    static bool has_colours(const PlyElement& element) {
        for (const char* name : {"red", "diffuse_red", "r", "f_dc_0"}) {
            if (element.values_named(name) > 0) return true;
        }
        return false;
    }

    void read_elements(FileReader& reader, bool with_vertices, bool with_faces) {
        PlyValues values(reader, header_.format);
        for (const PlyElement& element : header_.elements) {
            if (element.properties.empty()) continue;
            if (with_vertices && element.name == "vertex") {
                read_vertices(element, reader.left(), values);
            } else if (with_faces && (element.name == "face" || element.name == "tristrips")) {
                read_faces(element, reader.left(), values);
            } else {
                for (std::uint64_t i = 0; i < element.count; ++i) {
                    values.begin(element, i);
                    for (const PlyProperty& property : element.properties) values.skip(property);
                }
            }
        }
        if (!with_faces) return;
        const bool is_over =
            header_.format == PlyFormat::ascii ? reader.word().empty() : reader.left() == 0;
        if (!is_over) {
            notes_.add(
                "data behind the last element: left out (is a count in the header too small?)");
        }
    }

    /// The count of a header may be a lie: what is reserved has to fit into the file.
    static std::size_t believable(std::uint64_t count, std::uint64_t bytes_left) {
        constexpr std::uint64_t kFewestBytes = 3;
        return static_cast<std::size_t>(std::min(count, bytes_left / kFewestBytes + 1));
    }

    void read_vertices(const PlyElement& element, std::uint64_t bytes_left, PlyValues& values) {
        scene_.vertices.reserve(believable(element.count, bytes_left));
        scene_.normals.reserve(believable(element.count, bytes_left));
        // Where each property goes: 0 to 2 a position, 3 to 5 a normal.
        std::vector<std::size_t> places;
        for (const PlyProperty& property : element.properties) {
            places.push_back(place_of(property.name));
        }
        std::array<float, 6> row{};
        for (std::uint64_t i = 0; i < element.count; ++i) {
            values.begin(element, i);
            bool has_direction = has_normals_;
            for (std::size_t k = 0; k < places.size(); ++k) {
                const PlyProperty& property = element.properties[k];
                if (places[k] == row.size()) {
                    values.skip(property);
                    continue;
                }
                const std::optional<float> value = values.finite_float(property);
                if (places[k] < 3) check_coordinate(value, property, values);
                has_direction = has_direction && value;
                row[places[k]] = value.value_or(0.0f);
            }
            if (has_normals_ && !has_direction)
                notes_.add("a normal that is not finite: flat there");
            add_vertex(scene_, Vec3(row[0], row[1], row[2]),
                       has_direction ? Vec3(row[3], row[4], row[5]) : Vec3(0.0f));
        }
        is_used_.resize(scene_.vertices.size());
    }

    std::size_t place_of(const std::string& name) const {
        for (std::size_t k = 0; k < 3; ++k) {
            if (name == kPositionNames[k]) return k;
            if (has_normals_ && name == kNormalNames[k]) return k + 3;
        }
        return 6;
    }

    static void check_coordinate(std::optional<float> value, const PlyProperty& property,
                                 const PlyValues& values) {
        if (value && std::abs(*value) <= reference::kMaxCoordinate) return;
        values.fail(fmt::format("{}: expected a finite number of at most {:g}", property.name,
                                reference::kMaxCoordinate));
    }

    /// Faces, or triangle strips.
    void read_faces(const PlyElement& element, std::uint64_t bytes_left, PlyValues& values) {
        const bool are_strips = element.name == "tristrips";
        const auto is_corners = [](const PlyProperty& property) {
            return property.count_type && property.name.rfind("vertex_ind", 0) == 0;
        };
        const auto lists =
            std::count_if(element.properties.begin(), element.properties.end(), is_corners);
        if (lists != 1 && element.count > 0) {
            fail_header(fmt::format("{}: expected one list 'vertex_indices', found {}",
                                    element.name, lists));
        }
        scene_.triangles.reserve(scene_.triangles.size() + believable(element.count, bytes_left));
        scene_.material_of.reserve(scene_.triangles.capacity());
        for (std::uint64_t i = 0; i < element.count; ++i) {
            values.begin(element, i);
            for (const PlyProperty& property : element.properties) {
                if (!is_corners(property)) {
                    values.skip(property);
                } else if (are_strips) {
                    read_strip(property, values);
                } else {
                    read_face(property, values);
                }
            }
        }
    }

    void read_face(const PlyProperty& list, PlyValues& values) {
        const std::uint64_t count = values.length(list);
        if (count == 0) values.fail("a face without corners");
        corners_.clear();
        for (std::uint64_t k = 0; k < count; ++k) {
            corners_.push_back(vertex(values.number(list, list.type), values));
        }
        if (count < 3) {
            notes_.add("a face with fewer than 3 corners: left out");
            return;
        }
        for (const std::uint32_t corner : corners_) is_used_[corner] = true;
        polygons_.add(corners_, material());
    }

    /// Each index makes a triangle with the two before it, every other one wound the other way; -1
    /// begins a new strip.
    void read_strip(const PlyProperty& list, PlyValues& values) {
        const std::uint64_t count = values.length(list);
        std::uint32_t a = 0;
        std::uint32_t b = 0;
        std::uint64_t length = 0;
        for (std::uint64_t k = 0; k < count; ++k) {
            const double number = values.number(list, list.type);
            if (is_restart(number, list.type)) {
                length = 0;
                continue;
            }
            const std::uint32_t c = vertex(number, values);
            // Strips are joined by triangles with two equal corners, which have no area.
            if (++length >= 3 && a != b && b != c && a != c) {
                const bool is_turned = length % 2 == 0;
                for (const std::uint32_t corner : {a, b, c}) is_used_[corner] = true;
                add_triangle(scene_, is_turned ? b : a, is_turned ? a : b, c, material());
            }
            a = b;
            b = c;
        }
    }

    bool is_restart(double number, PlyType type) const {
        if (number == -1.0) return true;
        // The same bits in an unsigned type.
        const bool has_all_bits = (type == PlyType::uint32 && number == 4294967295.0) ||
                                  (type == PlyType::uint16 && number == 65535.0) ||
                                  (type == PlyType::uint8 && number == 255.0);
        return has_all_bits && number >= vertex_count_;
    }

    std::uint32_t vertex(double number, const PlyValues& values) const {
        if (number >= 0.0 && number < vertex_count_) {
            const auto index = static_cast<std::uint32_t>(number);
            if (index == number) return index;
        }
        values.fail(
            fmt::format("vertex index {} out of range, the file has {} vertices, "
                        "numbered from 0",
                        number, vertex_count_));
    }

    std::uint32_t material() {
        if (scene_.materials.empty()) {
            notes_.add(kDefaultMaterialNote);
            add_default_material(scene_);
        }
        return 0;
    }

    Error no_triangles() const {
        return Error::bad_input(
            path_, notes_.explain(fmt::format("no triangles in the file, nothing to render: {} "
                                              "vertices and no element 'face' or 'tristrips' with "
                                              "triangles",
                                              vertex_count_)));
    }

    std::string path_;
    PlyHeader header_;
    std::uint32_t vertex_count_ = 0;
    bool has_normals_ = false;
    Notes notes_;
    Scene scene_;
    PolygonAdder polygons_;
    std::vector<bool> is_used_;
    std::vector<std::uint32_t> corners_;
};

}  // namespace

Scene load_ply(const std::string& path, CameraChoice camera) {
    return PlyLoader(path).load(camera);
}

}  // namespace scotty::scenes
