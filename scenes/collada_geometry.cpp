#include <cstring>

#include "scenes/collada_parts.h"
#include "scenes/collada_primitives.h"
#include "scenes/geodesic.h"
#include "scenes/triangulate_polygon.h"

namespace scotty::scenes {

namespace {

/// Frequency of the geodesic that stands for an analytic sphere: 11,520 triangles, an error in
/// radius of about 0.06 %.
constexpr std::uint32_t kSphereFrequency = 24;

/// Collects corners: each pair of position and normal becomes one vertex.
class CornerMerger {
 public:
    explicit CornerMerger(ColladaMesh& mesh) : mesh_(mesh) {}

    std::uint32_t vertex(const std::vector<Point>& positions, std::uint32_t position,
                         const std::vector<Point>* normals, std::uint32_t normal,
                         std::size_t sources) {
        const Key key{sources, static_cast<std::uint64_t>(position) << 32 | normal};
        const auto [entry, is_new] =
            known_.emplace(key, static_cast<std::uint32_t>(mesh_.positions.size()));
        if (is_new) {
            mesh_.positions.push_back(positions[position]);
            mesh_.normals.push_back(normals ? (*normals)[normal] : Point{});
        }
        return entry->second;
    }

 private:
    struct Key {
        std::size_t sources;
        std::uint64_t pair;
        bool operator==(const Key&) const = default;
    };
    struct Hash {
        std::size_t operator()(const Key& key) const {
            return (key.pair + key.sources) * 0x9e3779b97f4a7c15ull >> 16;
        }
    };
    ColladaMesh& mesh_;
    std::unordered_map<Key, std::uint32_t, Hash> known_;
};

void check_index(const ColladaDocument& document, pugi::xml_node primitives, const char* what,
                 std::uint32_t index, std::size_t polygon, std::size_t count) {
    if (index < count) return;
    throw document.error(
        primitives, fmt::format("polygon {}: {} index {} out of range, there are {}", polygon, what,
                                index, count));
}

/// Reads the polygons of one element, corner by corner, and cuts them into triangles.
class PolygonReader {
 public:
    PolygonReader(const ColladaDocument& document, pugi::xml_node primitives, std::size_t number,
                  CornerMerger& merger, Notes& notes)
        : document_(document),
          primitives_(primitives),
          number_(number),
          merger_(merger),
          notes_(notes),
          inputs_(read_inputs(document, primitives, notes)),
          polygons_(read_polygons(document, primitives, inputs_.stride, notes)) {}

    ColladaMesh::Part read() {
        part_.symbol = primitives_.attribute("material").value();
        const std::uint32_t* corner = polygons_.corners.data();
        std::size_t first_ring = 0;
        for (std::size_t polygon = 0; first_ring < polygons_.ring_sizes.size(); ++polygon) {
            const std::size_t count =
                polygons_.ring_counts.empty() ? 1 : polygons_.ring_counts[polygon];
            const auto rings = std::span(polygons_.ring_sizes).subspan(first_ring, count);
            vertices_.clear();
            corners_.clear();
            for (const std::uint32_t size : rings) {
                for (std::uint32_t k = 0; k < size; ++k, corner += inputs_.stride) {
                    take_corner(corner, polygon);
                }
            }
            cut(rings);
            first_ring += count;
        }
        return std::move(part_);
    }

 private:
    void take_corner(const std::uint32_t* corner, std::size_t polygon) {
        const std::uint32_t position = corner[inputs_.position_offset];
        const std::uint32_t normal = inputs_.has_normals ? corner[inputs_.normal_offset] : 0;
        check_index(document_, primitives_, "position", position, polygon,
                    inputs_.positions.size());
        if (inputs_.has_normals) {
            check_index(document_, primitives_, "normal", normal, polygon, inputs_.normals.size());
        }
        vertices_.push_back(merger_.vertex(inputs_.positions, position,
                                           inputs_.has_normals ? &inputs_.normals : nullptr, normal,
                                           number_));
        corners_.push_back(inputs_.positions[position]);
    }

    void cut(std::span<const std::uint32_t> rings) {
        if (rings[0] < 3) notes_.add("a polygon with fewer than 3 corners: left out");
        triangles_.clear();
        if (!triangulate_polygon(corners_, rings, triangles_)) {
            notes_.add("a polygon crosses itself or its holes: cut into triangles somehow");
        }
        for (const auto& [a, b, c] : triangles_) {
            part_.triangles.push_back({vertices_[a], vertices_[b], vertices_[c]});
        }
    }

    const ColladaDocument& document_;
    pugi::xml_node primitives_;
    std::size_t number_;
    CornerMerger& merger_;
    Notes& notes_;
    CornerInputs inputs_;
    Polygons polygons_;
    ColladaMesh::Part part_;
    std::vector<std::uint32_t> vertices_;
    std::vector<Point> corners_;
    std::vector<std::array<std::uint32_t, 3>> triangles_;
};

/// A part's key in the merger: parts with the same inputs share their vertices.
std::string inputs_of(pugi::xml_node primitives) {
    std::string key;
    for (const pugi::xml_node input : primitives.children("input")) {
        const std::string semantic = input.attribute("semantic").value();
        if (semantic != "VERTEX" && semantic != "NORMAL") continue;
        key += semantic + input.attribute("source").value() + ' ';
    }
    return key;
}

ColladaMesh read_mesh(const ColladaDocument& document, pugi::xml_node element, Notes& notes) {
    ColladaMesh mesh;
    CornerMerger merger(mesh);
    std::vector<std::string> known_inputs;
    bool has_primitives = false;
    for (const pugi::xml_node child : element.children()) {
        const std::string name = child.name();
        has_primitives |= holds_polygons(child.name()) || name.starts_with("line");
        if (holds_polygons(child.name())) {
            const bool is_empty = !child.child("p") && !child.child("ph");
            if (is_empty && document.count_attribute(child, "count", 0) == 0) continue;
            const std::string inputs = inputs_of(child);
            const auto found = std::find(known_inputs.begin(), known_inputs.end(), inputs);
            const auto number = static_cast<std::size_t>(found - known_inputs.begin());
            if (found == known_inputs.end()) known_inputs.push_back(inputs);
            mesh.parts.push_back(PolygonReader(document, child, number, merger, notes).read());
        } else if (name == "lines" || name == "linestrips") {
            notes.add(fmt::format("<{}> is not supported: left out", name));
        }
    }
    if (!has_primitives) notes.add("a mesh of vertices alone: nothing of it can be seen");
    return mesh;
}

ColladaMesh read_sphere(const ColladaDocument& document, pugi::xml_node sphere, Notes& notes) {
    const double radius = document.number(sphere.child("radius"), 0.0);
    if (!(radius > 0.0)) {
        throw document.error(sphere, fmt::format("radius: expected more than 0, found {}", radius));
    }
    notes.add(fmt::format("an analytic sphere is approximated by {} triangles with smooth normals",
                          geodesic_triangles(kSphereFrequency)));
    reference::Scene tessellated;
    ColladaMesh mesh;
    add_geodesic(tessellated, kSphereFrequency, 0, [&](const Direction& d) {
        mesh.normals.push_back(d);
        mesh.positions.push_back({d[0] * radius, d[1] * radius, d[2] * radius});
        return reference::Vec3(0.0f, 0.0f, 0.0f);
    });
    mesh.parts.push_back({"", std::move(tessellated.triangles)});
    return mesh;
}

}  // namespace

ColladaMesh read_geometry(const ColladaDocument& document, pugi::xml_node geometry, Notes& notes) {
    if (const pugi::xml_node mesh = geometry.child("mesh")) return read_mesh(document, mesh, notes);
    const pugi::xml_node extra = scotty3d_extra(geometry);
    if (std::strcmp(extra.name(), "sphere") == 0) return read_sphere(document, extra, notes);
    const pugi::xml_node unknown = geometry.child("extra").child("technique");
    if (extra || !unknown) {
        const pugi::xml_node content = extra ? extra : geometry.first_child();
        notes.add(fmt::format("a geometry of <{}> is not supported: left out", content.name()));
    } else {
        notes.add(fmt::format("a geometry of the profile {} is not supported: left out",
                              unknown.attribute("profile").value()));
    }
    return {};
}

}  // namespace scotty::scenes
