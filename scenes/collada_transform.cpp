#include <algorithm>

#include "scenes/collada_parts.h"

namespace scotty::scenes {

namespace {

/// The matrix of a camera: zero for what is missing at its end.
Affine short_matrix(const std::vector<double>& values, Notes& notes) {
    notes.add(
        fmt::format("the <matrix> of a camera has {} numbers instead of 16: zero for what is "
                    "missing",
                    values.size()));
    Affine out;
    for (std::size_t k = 0; k < 12; ++k) out.m[k / 4][k % 4] = values[k];
    return out;
}

Affine from_rotation(const ColladaDocument& document, pugi::xml_node element) {
    const std::vector<double> values = document.numbers(element, 4);
    const Point axis = unit({values[0], values[1], values[2]});
    if (axis == Point{}) {
        if (values[3] == 0.0) return {};
        throw document.error(element, "expected an axis that is not zero");
    }
    const double c = std::cos(values[3] * kDegree);
    const double s = std::sin(values[3] * kDegree);
    const double t = 1.0 - c;
    const auto& [x, y, z] = axis;
    Affine out;
    out.m = {{{t * x * x + c, t * x * y - s * z, t * x * z + s * y, 0.0},
              {t * x * y + s * z, t * y * y + c, t * y * z - s * x, 0.0},
              {t * x * z - s * y, t * y * z + s * x, t * z * z + c, 0.0}}};
    return out;
}

Point cross_of(const Point& a, const Point& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Eye, target, up: the node's -z looks at the target.
Affine from_lookat(const ColladaDocument& document, pugi::xml_node element) {
    const std::vector<double> v = document.numbers(element, 9);
    const Point back = unit({v[0] - v[3], v[1] - v[4], v[2] - v[5]});
    const Point right = unit(cross_of({v[6], v[7], v[8]}, back));
    if (right == Point{}) throw document.error(element, "eye, target and up give no direction");
    const Point up = cross_of(back, right);
    Affine out;
    for (std::size_t r = 0; r < 3; ++r) out.m[r] = {right[r], up[r], back[r], v[r]};
    return out;
}

/// A node that places nothing but a camera.
bool is_camera_alone(pugi::xml_node node) {
    if (!node.child("instance_camera")) return false;
    for (const char* other : {"node", "instance_node", "instance_geometry", "instance_light"}) {
        if (node.child(other)) return false;
    }
    return true;
}

}  // namespace

Affine read_matrix(const ColladaDocument& document, pugi::xml_node element) {
    const std::vector<double> values = document.numbers(element, 16);
    std::array<double, 16> rows{};
    std::copy(values.begin(), values.end(), rows.begin());
    if (const auto affine = affine_of_rows(rows)) return *affine;
    if (rows[15] == 0.0)
        throw document.error(element, "expected a last row of 0 0 0 1, found zeros");
    const bool transposed = rows[3] == 0.0 && rows[7] == 0.0 && rows[11] == 0.0;
    throw document.error(
        element, fmt::format("expected a last row of 0 0 0 1 (no perspective), found {} {} {} {}{}",
                             rows[12], rows[13], rows[14], rows[15],
                             transposed ? "; is the matrix written by columns?" : ""));
}

Affine read_transform(const ColladaDocument& document, pugi::xml_node node, Notes& notes) {
    // A camera that is hard to read may be approximated; geometry may not.
    const bool lenient = is_camera_alone(node);
    Affine total;
    for (const pugi::xml_node element : node.children()) {
        const std::string kind = element.name();
        if (kind == "matrix") {
            const std::vector<double> values = document.numbers(element);
            const bool is_short = lenient && values.size() >= 12 && values.size() < 16;
            total =
                total * (is_short ? short_matrix(values, notes) : read_matrix(document, element));
        } else if (kind == "translate" || kind == "scale") {
            const std::vector<double> values = document.numbers(element, 3);
            Affine step;
            for (std::size_t k = 0; k < 3; ++k) {
                (kind == "scale" ? step.m[k][k] : step.m[k][3]) = values[k];
            }
            total = total * step;
        } else if (kind == "rotate") {
            total = total * from_rotation(document, element);
        } else if (kind == "lookat") {
            total = total * from_lookat(document, element);
        } else if (kind == "skew") {
            notes.add("<skew> transforms are not supported: left out");
        }
    }
    return total;
}

}  // namespace scotty::scenes
