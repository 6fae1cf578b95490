#include "scenes/built_in.h"
#include "scenes/geodesic.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

namespace {

reference::Scene generate_spheres(const Parameters& parameters) {
    reference::Scene scene = cornell_room();
    const std::uint32_t frequency = parameters.integer("frequency");
    // A millimetre above the floor, so that no vertex lies in it.
    add_sphere(scene, Vec3(-0.42f, 0.421f, -0.35f), 0.42f, frequency,
               add_mirror(scene, Vec3(0.95f, 0.95f, 0.95f)));
    add_sphere(scene, Vec3(0.45f, 0.381f, 0.25f), 0.38f, frequency,
               add_glass(scene, Vec3(1, 1, 1), 1.5f));
    return scene;
}

}  // namespace

const Generator kSpheres = {"spheres",
                            "Cornell box with a mirror and a glass sphere",
                            {{"frequency", 16, 1, 1000}},
                            generate_spheres};

}  // namespace scotty::scenes
