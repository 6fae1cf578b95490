/// Cameras in files of their own, behind any scene.
#include <cstring>

#include "reference/base/error.h"
#include "scenes/camera_file.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/temporary_folder.h"

namespace scotty::scenes {

using Catch::Matchers::ContainsSubstring;
using reference::Camera;
using tests::spill;
using tests::TemporaryFolder;

TEST_CASE("camera files: a camera comes back in the same bits, behind any scene", "[scenes]") {
    const TemporaryFolder folder;
    const Camera own = load_scene("coil").camera;
    Camera camera = own;
    camera.position.x += 0.1f;
    camera.tan_half_fov = 1.0f / 3.0f;
    camera.tan_half_width = 0.7f;
    const std::string file = folder.file("a.camera");
    spill(file, camera_text(camera));
    const reference::Scene scene = load_scene("coil#camera=" + file);
    CHECK(std::memcmp(&scene.camera, &camera, sizeof(Camera)) == 0);
    CHECK(scene.name == "coil");
    CHECK(scene.source == "coil#camera=" + file);
    const reference::Scene other = load_scene("blob:triangles=1000#camera=" + file);
    CHECK(std::memcmp(&other.camera, &camera, sizeof(Camera)) == 0);
    // Beside a file's other choices, which stay.
    for (const char* form :
         {"x.obj#lights=none,camera=b.camera", "x.obj#camera=b.camera,lights=none"}) {
        std::string specification = form;
        CHECK(take_camera_file(specification) == "b.camera");
        CHECK(specification == "x.obj#lights=none");
    }
    std::string fit = "x.obj#camera=fit";
    CHECK_FALSE(take_camera_file(fit));
    CHECK(fit == "x.obj#camera=fit");
}

TEST_CASE("camera files: what is wrong is named", "[scenes]") {
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(load_scene("coil#camera=" + folder.file("none.camera")),
                      ContainsSubstring("no such camera file"));
    const auto load = [&](const std::string& text) {
        spill(folder.file("a.camera"), text);
        return load_scene("coil#camera=" + folder.file("a.camera"));
    };
    CHECK_THROWS_WITH(load("[1]"), ContainsSubstring("JSON object"));
    CHECK_THROWS_WITH(load("{}"), ContainsSubstring("position"));
    CHECK_THROWS_WITH(load(R"({"position":[1,2]})"), ContainsSubstring("three numbers"));
    CHECK_THROWS_WITH(load(R"({"position":[1,2,"x"]})"), ContainsSubstring("not made of numbers"));
    CHECK_THROWS_WITH(load(std::string(5000, ' ')), ContainsSubstring("too long"));
    Camera squashed = load_scene("coil").camera;
    squashed.up = squashed.up * 0.5f;
    CHECK_THROWS_WITH(load(camera_text(squashed)), ContainsSubstring("camera"));
}

}  // namespace scotty::scenes
