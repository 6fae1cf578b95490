#include "tests/fuzz/readers.h"

#include <fstream>

#include "scenes/scenes.h"
#include "verify/capture/capture.h"
#include "verify/capture/npy.h"
#include "verify/capture/ray_file.h"
#include "verify/golden/golden.h"
#include "verify/golden/ledger.h"
#include "verify/golden/waivers.h"

namespace scotty::tests {

namespace fs = std::filesystem;

namespace {

fs::path write(const fs::path& folder, const char* name, std::string_view bytes) {
    const fs::path file = folder / name;
    std::ofstream(file, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file;
}

template <int kind>
void read_scene(const fs::path& folder, std::string_view bytes) {
    constexpr const char* kNames[] = {"a.dae", "a.obj", "a.ply", "a.gltf", "a.glb"};
    scenes::load_scene(write(folder, kNames[kind], bytes).string());
}

/// The bytes are the index; buffers are looked for where it says.
void read_capture(const fs::path& folder, std::string_view bytes) {
    write(folder, "index.json", bytes);
    const auto capture = verify::Capture::open(folder);
    for (const auto& stage : capture.stages()) capture.load(stage);
}

void read_npy(const fs::path& folder, std::string_view bytes) {
    verify::read_npy(write(folder, "a.npy", bytes));
}
void read_rays(const fs::path& folder, std::string_view bytes) {
    verify::read_rays(write(folder, "a.rays", bytes));
}
void read_triangles(const fs::path& folder, std::string_view bytes) {
    verify::read_scene_file(write(folder, "a.scene", bytes));
}
void read_manifest(const fs::path& folder, std::string_view bytes) {
    write(folder, "manifest.json", bytes);
    verify::read_manifest(folder);
}
void read_waivers(const fs::path& folder, std::string_view bytes) {
    write(folder, "waivers.json", bytes);
    verify::read_waivers(folder);
}
void read_ledger(const fs::path& folder, std::string_view bytes) {
    verify::to_text(verify::read_ledger(write(folder, "a.txt", bytes)));
}

}  // namespace

const std::vector<Reader>& file_readers() {
    static const std::vector<Reader> readers{
        {"collada", read_scene<0>},  {"obj", read_scene<1>},    {"ply", read_scene<2>},
        {"gltf", read_scene<3>},     {"glb", read_scene<4>},    {"capture", read_capture},
        {"npy", read_npy},           {"rays", read_rays},       {"triangles", read_triangles},
        {"manifest", read_manifest}, {"waivers", read_waivers}, {"ledger", read_ledger}};
    return readers;
}

}  // namespace scotty::tests
