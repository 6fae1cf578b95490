#include <cstring>

#include "scenes/collada_parts.h"
#include "scenes/geodesic.h"

namespace scotty::scenes {

namespace {

/// Frequency of the geodesic that stands for an analytic sphere: 11,520 triangles, an error in
/// radius of about 0.06 %.
constexpr std::uint32_t kSphereFrequency = 24;

/// A <source> of 3-vectors, checked against its accessor.
std::vector<Point> read_vectors(const ColladaDocument& document, pugi::xml_node source) {
    const pugi::xml_node accessor = source.child("technique_common").child("accessor");
    if (!accessor) throw document.error(source, "expected <technique_common><accessor>");
    const std::vector<double> values =
        document.numbers(document.target(accessor, "source", "float_array"));
    const std::size_t count = document.count_attribute(accessor, "count", 0);
    const std::size_t stride = document.count_attribute(accessor, "stride", 1);
    const std::size_t offset = document.count_attribute(accessor, "offset", 0);
    if (stride < 3)
        throw document.error(accessor, fmt::format("stride: expected 3, found {}", stride));
    if (count != 0 && offset + (count - 1) * stride + 3 > values.size()) {
        throw document.error(accessor,
                             fmt::format("expected {} vectors of stride {} from {} on, the array "
                                         "holds {} numbers (truncated?)",
                                         count, stride, offset, values.size()));
    }
    std::vector<Point> vectors(count);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k) vectors[i][k] = values[offset + i * stride + k];
    }
    return vectors;
}

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

/// One <triangles>, <polylist> or <polygons> element: where its inputs are.
struct Layout {
    std::vector<Point> positions;
    std::vector<Point> normals;
    bool has_normals = false;
    std::uint32_t position_offset = 0;
    std::uint32_t normal_offset = 0;
    std::uint32_t stride = 0;
};

Layout read_layout(const ColladaDocument& document, pugi::xml_node primitives, Notes& notes) {
    Layout layout;
    bool has_positions = false;
    const auto take_normals = [&](pugi::xml_node input, std::uint32_t offset) {
        if (layout.has_normals) return;
        layout.normals = read_vectors(document, document.target(input, "source", "source"));
        layout.normal_offset = offset;
        layout.has_normals = true;
    };
    for (const pugi::xml_node input : primitives.children("input")) {
        const std::string semantic = input.attribute("semantic").value();
        const std::uint32_t offset = document.count_attribute(input, "offset", 0);
        if (offset > 64) throw document.error(input, fmt::format("offset {} is absurd", offset));
        layout.stride = std::max(layout.stride, offset + 1);
        if (semantic == "VERTEX") {
            const pugi::xml_node vertices = document.target(input, "source", "vertices");
            for (const pugi::xml_node inner : vertices.children("input")) {
                const std::string kind = inner.attribute("semantic").value();
                if (kind == "POSITION") {
                    layout.positions =
                        read_vectors(document, document.target(inner, "source", "source"));
                    layout.position_offset = offset;
                    has_positions = true;
                } else if (kind == "NORMAL") {
                    take_normals(inner, offset);
                }
            }
        } else if (semantic == "NORMAL") {
            take_normals(input, offset);
        } else if (semantic == "COLOR") {
            notes.add("vertex colours are not supported: left out");
        }
    }
    if (!has_positions) {
        throw document.error(primitives, "expected an <input> VERTEX with a POSITION");
    }
    return layout;
}

/// How many corners each polygon has, and all corner indices.
struct Polygons {
    std::vector<std::uint32_t> sizes;
    std::vector<std::uint32_t> corners;
};

Polygons read_polygons(const ColladaDocument& document, pugi::xml_node primitives,
                       const Layout& layout, Notes& notes) {
    Polygons polygons;
    const std::uint32_t count = document.count_attribute(primitives, "count", 0);
    if (std::strcmp(primitives.name(), "polygons") == 0) {
        for (const pugi::xml_node child : primitives.children()) {
            const bool has_holes = std::strcmp(child.name(), "ph") == 0;
            if (!has_holes && std::strcmp(child.name(), "p") != 0) continue;
            if (has_holes) notes.add("holes in polygons are not supported: filled");
            const auto corners = document.indices(has_holes ? child.child("p") : child);
            polygons.sizes.push_back(static_cast<std::uint32_t>(corners.size()) / layout.stride);
            polygons.corners.insert(polygons.corners.end(), corners.begin(), corners.end());
        }
    } else {
        polygons.corners = document.indices(primitives.child("p"));
        if (const pugi::xml_node sizes = primitives.child("vcount")) {
            polygons.sizes = document.indices(sizes);
        } else {
            polygons.sizes.assign(polygons.corners.size() / (3ull * layout.stride), 3);
        }
    }
    std::uint64_t corners = 0;
    for (const std::uint32_t size : polygons.sizes) corners += size;
    if (polygons.sizes.size() != count) {
        throw document.error(primitives, fmt::format("expected {} polygons (its count), found {}",
                                                     count, polygons.sizes.size()));
    }
    if (corners * layout.stride != polygons.corners.size()) {
        throw document.error(
            primitives, fmt::format("expected {} indices in <p>, found {}", corners * layout.stride,
                                    polygons.corners.size()));
    }
    return polygons;
}

void check_index(const ColladaDocument& document, pugi::xml_node primitives, const char* what,
                 std::uint32_t index, std::size_t polygon, std::size_t count) {
    if (index < count) return;
    throw document.error(
        primitives, fmt::format("polygon {}: {} index {} out of range, there are {}", polygon, what,
                                index, count));
}

void read_primitives(const ColladaDocument& document, pugi::xml_node primitives, std::size_t number,
                     CornerMerger& merger, ColladaMesh& mesh, Notes& notes) {
    const Layout layout = read_layout(document, primitives, notes);
    const Polygons polygons = read_polygons(document, primitives, layout, notes);
    ColladaMesh::Part part;
    part.symbol = primitives.attribute("material").value();
    const std::uint32_t* corner = polygons.corners.data();
    std::vector<std::uint32_t> vertices;
    for (std::size_t polygon = 0; polygon < polygons.sizes.size(); ++polygon) {
        vertices.clear();
        for (std::uint32_t k = 0; k < polygons.sizes[polygon]; ++k, corner += layout.stride) {
            const std::uint32_t position = corner[layout.position_offset];
            const std::uint32_t normal = layout.has_normals ? corner[layout.normal_offset] : 0;
            check_index(document, primitives, "position", position, polygon,
                        layout.positions.size());
            if (layout.has_normals) {
                check_index(document, primitives, "normal", normal, polygon, layout.normals.size());
            }
            vertices.push_back(merger.vertex(layout.positions, position,
                                             layout.has_normals ? &layout.normals : nullptr, normal,
                                             number));
        }
        if (vertices.size() < 3) notes.add("a polygon with fewer than 3 corners: left out");
        for (std::size_t k = 2; k < vertices.size(); ++k) {
            part.triangles.push_back({vertices[0], vertices[k - 1], vertices[k]});
        }
    }
    mesh.parts.push_back(std::move(part));
}

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
    for (const pugi::xml_node child : element.children()) {
        const std::string name = child.name();
        if (name == "triangles" || name == "polylist" || name == "polygons") {
            const std::string inputs = inputs_of(child);
            const auto found = std::find(known_inputs.begin(), known_inputs.end(), inputs);
            const auto number = static_cast<std::size_t>(found - known_inputs.begin());
            if (found == known_inputs.end()) known_inputs.push_back(inputs);
            read_primitives(document, child, number, merger, mesh, notes);
        } else if (name == "lines" || name == "linestrips" || name == "trifans" ||
                   name == "tristrips") {
            notes.add(fmt::format("<{}> is not supported: left out", name));
        }
    }
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
    const pugi::xml_node content = extra ? extra : geometry.first_child();
    notes.add(fmt::format("a geometry of <{}> is not supported: left out", content.name()));
    return {};
}

}  // namespace scotty::scenes
