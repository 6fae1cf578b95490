/// Materials as assimp reports them, turned into ours.
#pragma once

#include <assimp/scene.h>

#include "reference/contract/scene.h"
#include "scenes/notes.h"

namespace scotty::scenes {

/// OBJ: illum 3 and 5 are mirrors, 4, 6 and 7 glass. glTF: full metal without roughness is a
/// mirror, full transmission glass. The rest is diffuse; emission is kept. Notes what is left out.
reference::Material from_assimp(const aiMaterial& source, Notes& notes);

}  // namespace scotty::scenes
