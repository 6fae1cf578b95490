#include "scenes/built_in.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Scene;

Scene cornell_room() {
    Scene scene;
    const std::uint32_t white = add_diffuse(scene, Vec3(0.73f, 0.73f, 0.73f));
    const std::uint32_t red = add_diffuse(scene, Vec3(0.63f, 0.065f, 0.05f));
    const std::uint32_t green = add_diffuse(scene, Vec3(0.14f, 0.45f, 0.091f));
    // Fronts inwards: cross(edge_x, edge_y) points into the room.
    add_quad(scene, Vec3(-1, 0, 1), Vec3(2, 0, 0), Vec3(0, 0, -2), white);  // floor
    add_quad(scene, Vec3(-1, 2, -1), Vec3(2, 0, 0), Vec3(0, 0, 2), white);  // ceiling
    add_quad(scene, Vec3(-1, 0, -1), Vec3(2, 0, 0), Vec3(0, 2, 0), white);  // back
    add_quad(scene, Vec3(-1, 0, 1), Vec3(0, 0, -2), Vec3(0, 2, 0), red);    // left
    add_quad(scene, Vec3(1, 0, -1), Vec3(0, 0, 2), Vec3(0, 2, 0), green);   // right
    add_lamp(scene, Vec3(-0.375f, 1.99f, -0.375f), Vec3(0.75f, 0, 0), Vec3(0, 0, 0.75f),
             Vec3(12, 11, 9));
    scene.camera = look_at(Vec3(0, 1, 3.6f), Vec3(0, 1, 0), Vec3(0, 1, 0), 0.4f);
    return scene;
}

const Generator kCornell = {
    "cornell", "empty Cornell box with a square lamp", {}, [](const Parameters&) {
        return cornell_room();
    }};

}  // namespace scotty::scenes
