#include "scenes/collada_primitives.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>

namespace scotty::scenes {

namespace {

/// Where in an element of a source its x, y and z are: parameters without a name are skipped.
std::array<std::size_t, 3> find_axes(pugi::xml_node accessor) {
    std::array<std::size_t, 3> axes = {0, 1, 2};
    std::vector<std::size_t> named;
    std::array<std::size_t, 3> by_letter{};
    std::size_t letters = 0;
    std::size_t place = 0;
    for (const pugi::xml_node parameter : accessor.children("param")) {
        const char* name = parameter.attribute("name").value();
        if (*name != '\0') named.push_back(place);
        for (std::size_t k = 0; k < 3; ++k) {
            const char letter[2] = {"XYZ"[k], '\0'};
            if (std::strcmp(name, letter) != 0) continue;
            by_letter[k] = place;
            letters |= std::size_t{1} << k;
        }
        ++place;
    }
    if (letters == 7) return by_letter;
    if (named.size() >= 3) std::copy_n(named.begin(), 3, axes.begin());
    return axes;
}

/// A <source> of 3-vectors, checked against its accessor.
std::vector<Point> read_vectors(const ColladaDocument& document, pugi::xml_node source,
                                Notes& notes) {
    const pugi::xml_node accessor = source.child("technique_common").child("accessor");
    if (!accessor) throw document.error(source, "expected <technique_common><accessor>");
    const pugi::xml_node array = document.target(accessor, "source", "float_array");
    const std::vector<double> values = document.numbers(array);
    const auto announced = document.count_attribute(
        array, "count", static_cast<std::uint32_t>(std::min<std::size_t>(values.size(), ~0u)));
    if (announced != values.size()) {
        notes.add("a <float_array> does not hold as many numbers as its count says");
    }
    const std::size_t count = document.count_attribute(accessor, "count", 0);
    const std::size_t stride = document.count_attribute(accessor, "stride", 1);
    const std::size_t offset = document.count_attribute(accessor, "offset", 0);
    if (stride < 3)
        throw document.error(accessor, fmt::format("stride: expected 3, found {}", stride));
    const std::array<std::size_t, 3> axes = find_axes(accessor);
    const std::size_t last_axis = *std::max_element(axes.begin(), axes.end());
    if (last_axis >= stride) {
        throw document.error(
            accessor, fmt::format("a <param> in place {}, the stride is {}", last_axis, stride));
    }
    if (count != 0 && offset + (count - 1) * stride + last_axis + 1 > values.size()) {
        throw document.error(accessor,
                             fmt::format("expected {} vectors of stride {} from {} on, the array "
                                         "holds {} numbers (truncated?)",
                                         count, stride, offset, values.size()));
    }
    std::vector<Point> vectors(count);
    for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t k = 0; k < 3; ++k) vectors[i][k] = values[offset + i * stride + axes[k]];
    }
    return vectors;
}

/// Appends a corner's indices once more.
void repeat_corner(const std::vector<std::uint32_t>& indices, std::size_t corner,
                   std::uint32_t stride, std::vector<std::uint32_t>& out) {
    const auto first = indices.begin() + static_cast<std::ptrdiff_t>(corner * stride);
    out.insert(out.end(), first, first + stride);
}

/// One <p> of <tristrips> or <trifans> as triangles. Those that repeat a corner only join strips.
void add_strip(const std::vector<std::uint32_t>& indices, std::uint32_t stride, bool is_fan,
               Polygons& polygons) {
    const std::size_t corners = indices.size() / stride;
    const auto same = [&](std::size_t a, std::size_t b) {
        return std::equal(indices.begin() + static_cast<std::ptrdiff_t>(a * stride),
                          indices.begin() + static_cast<std::ptrdiff_t>((a + 1) * stride),
                          indices.begin() + static_cast<std::ptrdiff_t>(b * stride));
    };
    for (std::size_t i = 2; i < corners; ++i) {
        std::array<std::size_t, 3> triangle = {is_fan ? 0 : i - 2, i - 1, i};
        if (!is_fan && i % 2 == 1) std::swap(triangle[0], triangle[1]);
        const auto [a, b, c] = triangle;
        if (same(a, b) || same(b, c) || same(c, a)) continue;
        polygons.ring_sizes.push_back(3);
        for (const std::size_t corner : triangle) {
            repeat_corner(indices, corner, stride, polygons.corners);
        }
    }
}

/// <p> elements of their own: strips, fans, and polygons that may have holes (<ph>).
class SeparateReader {
 public:
    SeparateReader(const ColladaDocument& document, std::uint32_t stride, Notes& notes)
        : document_(document), stride_(stride), notes_(notes) {}

    Polygons read(pugi::xml_node primitives) {
        const bool is_fan = std::strcmp(primitives.name(), "trifans") == 0;
        const bool is_strip = std::strcmp(primitives.name(), "tristrips") == 0;
        std::uint32_t found = 0;
        for (const pugi::xml_node child : primitives.children()) {
            const bool has_holes = std::strcmp(child.name(), "ph") == 0;
            if (!has_holes && std::strcmp(child.name(), "p") != 0) continue;
            ++found;
            if (is_fan || is_strip) {
                const std::vector<std::uint32_t> indices = whole_corners(child);
                if (indices.size() < 3 * stride_) {
                    notes_.add("a strip or fan with fewer than 3 corners: left out");
                }
                add_strip(indices, stride_, is_fan, polygons_);
                continue;
            }
            std::uint32_t rings = 1;
            add_ring(has_holes ? child.child("p") : child);
            for (const pugi::xml_node hole : child.children("h")) {
                add_ring(hole);
                ++rings;
            }
            polygons_.ring_counts.push_back(rings);
        }
        const std::uint32_t count = document_.count_attribute(primitives, "count", 0);
        if (found != count) {
            throw document_.error(primitives,
                                  fmt::format("expected {} {} (its count), found {}", count,
                                              is_fan || is_strip ? "<p>" : "polygons", found));
        }
        return std::move(polygons_);
    }

 private:
    std::vector<std::uint32_t> whole_corners(pugi::xml_node element) const {
        std::vector<std::uint32_t> indices = document_.indices(element);
        if (indices.size() % stride_ != 0) {
            throw document_.error(element, fmt::format("expected {} indices for each corner, found "
                                                       "{} in all",
                                                       stride_, indices.size()));
        }
        return indices;
    }

    void add_ring(pugi::xml_node element) {
        const std::vector<std::uint32_t> indices = whole_corners(element);
        polygons_.ring_sizes.push_back(static_cast<std::uint32_t>(indices.size()) / stride_);
        polygons_.corners.insert(polygons_.corners.end(), indices.begin(), indices.end());
    }

    const ColladaDocument& document_;
    std::uint32_t stride_;
    Notes& notes_;
    Polygons polygons_;
};

/// <triangles> and <polylist>: all corners in one <p>.
Polygons read_joint(const ColladaDocument& document, pugi::xml_node primitives,
                    std::uint32_t stride) {
    Polygons polygons;
    polygons.corners = document.indices(primitives.child("p"));
    if (std::strcmp(primitives.name(), "polylist") == 0) {
        polygons.ring_sizes = document.indices(primitives.child("vcount"));
    } else {
        polygons.ring_sizes.assign(polygons.corners.size() / (3ull * stride), 3);
    }
    const std::uint32_t count = document.count_attribute(primitives, "count", 0);
    if (polygons.ring_sizes.size() != count) {
        throw document.error(primitives, fmt::format("expected {} polygons (its count), found {}",
                                                     count, polygons.ring_sizes.size()));
    }
    const std::uint64_t corners =
        std::accumulate(polygons.ring_sizes.begin(), polygons.ring_sizes.end(), std::uint64_t{0});
    if (corners * stride != polygons.corners.size()) {
        throw document.error(primitives, fmt::format("expected {} indices in <p>, found {}",
                                                     corners * stride, polygons.corners.size()));
    }
    return polygons;
}

}  // namespace

CornerInputs read_inputs(const ColladaDocument& document, pugi::xml_node primitives, Notes& notes) {
    CornerInputs inputs;
    bool has_positions = false;
    const auto take_normals = [&](pugi::xml_node input, std::uint32_t offset) {
        if (inputs.has_normals) return;
        inputs.normals = read_vectors(document, document.target(input, "source", "source"), notes);
        inputs.normal_offset = offset;
        inputs.has_normals = true;
    };
    const auto note_colours = [&] { notes.add("vertex colours are not supported: left out"); };
    for (const pugi::xml_node input : primitives.children("input")) {
        const std::string semantic = input.attribute("semantic").value();
        const std::uint32_t offset = document.count_attribute(input, "offset", 0);
        if (offset > 64) throw document.error(input, fmt::format("offset {} is absurd", offset));
        inputs.stride = std::max(inputs.stride, offset + 1);
        if (semantic == "NORMAL") take_normals(input, offset);
        if (semantic == "COLOR") note_colours();
        if (semantic != "VERTEX") continue;
        const pugi::xml_node vertices = document.target(input, "source", "vertices");
        for (const pugi::xml_node inner : vertices.children("input")) {
            const std::string kind = inner.attribute("semantic").value();
            if (kind == "NORMAL") take_normals(inner, offset);
            if (kind == "COLOR") note_colours();
            if (kind != "POSITION") continue;
            inputs.positions =
                read_vectors(document, document.target(inner, "source", "source"), notes);
            inputs.position_offset = offset;
            has_positions = true;
        }
    }
    if (!has_positions) {
        throw document.error(primitives, "expected an <input> VERTEX with a POSITION");
    }
    return inputs;
}

bool holds_polygons(const char* name) {
    for (const char* known : {"triangles", "tristrips", "trifans", "polylist", "polygons"}) {
        if (std::strcmp(name, known) == 0) return true;
    }
    return false;
}

Polygons read_polygons(const ColladaDocument& document, pugi::xml_node primitives,
                       std::uint32_t stride, Notes& notes) {
    const std::string kind = primitives.name();
    if (kind == "triangles" || kind == "polylist") return read_joint(document, primitives, stride);
    return SeparateReader(document, stride, notes).read(primitives);
}

}  // namespace scotty::scenes
