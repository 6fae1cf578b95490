/// The built-in scenes' generators: one file each, y up, metres, boxes of about two metres.
#pragma once

#include "reference/contract/scene.h"
#include "scenes/parameters.h"

namespace scotty::scenes {

/// One row of the table in scenes.cpp.
struct Generator {
    const char* name;
    const char* description;
    std::vector<ParameterRange> parameters;
    reference::Scene (*generate)(const Parameters& parameters);
};

extern const Generator kCornell;
extern const Generator kSpheres;
extern const Generator kCoil;
extern const Generator kBlob;
extern const Generator kFurnace;
extern const Generator kVeil;
extern const Generator kSlivers;
extern const Generator kMetals;
/// Found by its name, but not among those that are listed and verified one by one (probe.h).
extern const Generator kProbe;

/// The Cornell box that several scenes stand in: x and z from -1 to 1, y from 0 to 2, open at
/// z = 1 where the camera looks in; a square lamp a centimetre under the ceiling.
reference::Scene cornell_room();

}  // namespace scotty::scenes
