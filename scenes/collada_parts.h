/// The pieces of a COLLADA file that load_collada() puts together.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reference/contract/scene.h"
#include "scenes/affine.h"
#include "scenes/collada_document.h"
#include "scenes/notes.h"

namespace scotty::scenes {

/// Triangles of one geometry, in its own coordinates.
struct ColladaMesh {
    struct Part {
        std::string symbol;  ///< what <instance_material> binds; empty: any
        std::vector<std::array<std::uint32_t, 3>> triangles;
    };
    std::vector<Point> positions;  ///< one for each pair of position and normal index
    std::vector<Point> normals;    ///< as many; zero where the file gives none
    std::vector<Part> parts;
};

/// <geometry>: a <mesh>, or an analytic sphere in the extras (tessellated).
ColladaMesh read_geometry(const ColladaDocument& document, pugi::xml_node geometry, Notes& notes);

/// <material>: the Scotty3D extra of its effect where there is one, else the common profile.
reference::Material read_material(const ColladaDocument& document, pugi::xml_node material,
                                  Notes& notes);

/// A node's own transform: its elements in order, each applied before those in front of it.
Affine read_transform(const ColladaDocument& document, pugi::xml_node node, Notes& notes);

/// A <matrix> of 16 numbers, or another element that holds one. Throws for a perspective.
Affine read_matrix(const ColladaDocument& document, pugi::xml_node element);

/// <light> as placed by `place`; nothing where it cannot shine (a note says so). Light falls off
/// with distance in the document's unit, of `metres` each.
std::optional<reference::Light> read_light(const ColladaDocument& document, pugi::xml_node light,
                                           const Affine& place, double metres, Notes& notes);

/// <camera> as placed by `place`: it looks along its -z. Nothing where it is not a perspective one.
std::optional<reference::Camera> read_camera(const ColladaDocument& document, pugi::xml_node camera,
                                             const Affine& place, Notes& notes);

}  // namespace scotty::scenes
