/// How the materials of file formats become ours: one place for each kind of description.
#pragma once

#include "reference/contract/records.h"
#include "scenes/notes.h"

namespace scotty::scenes {

/// A surface of the metallic-roughness model (glTF 2.0, appendix B): metallic from 0.5 on is a
/// metal, a mirror where its roughness is at most 0.001 and else a rough conductor of that colour
/// head on; everything else is diffuse. Notes where it is not quite so. A base colour beyond 0 to 1
/// is clamped, with a note.
reference::Material material_from_metallic_roughness(const reference::Vec3& base_colour,
                                                     float metallic, float roughness, Notes& notes);

/// A reflectance or transmittance within 0 to 1; NaN becomes 0. Notes what it changes.
reference::Vec3 clamped_tint(const reference::Vec3& colour, Notes& notes);

}  // namespace scotty::scenes
