#include <fmt/format.h>

#include <array>

#include "scenes/gltf_accessor.h"
#include "scenes/gltf_parts.h"

namespace scotty::scenes {

std::vector<Affine> read_gltf_skin(GltfDocument& document, const GltfObject& skin,
                                   const GltfNodes& nodes) {
    const auto joints = skin.wholes("joints");
    if (joints.empty()) throw skin.error("not glTF as specified: a skin without joints");
    std::optional<GltfAccessor> inverses;
    if (const auto index = skin.whole("inverseBindMatrices")) {
        inverses.emplace(document, *index, skin);
        inverses->expect_components(16);
        if (!inverses->is_float() || inverses->count() < joints.size()) {
            throw inverses->error(
                fmt::format("expected {} matrices of floats, one for each joint", joints.size()));
        }
    }
    std::vector<Affine> out;
    for (std::size_t i = 0; i < joints.size(); ++i) {
        const Affine* place = nodes.place_of(joints[i]);
        if (place == nullptr) {
            throw skin.error(fmt::format("joint {}: node {} is not in the scene", i, joints[i]));
        }
        Affine inverse;  // the identity where the file gives none
        if (inverses) {
            std::array<float, 16> columns{};
            inverses->read(i, 1, columns.data());
            for (std::size_t r = 0; r < 3; ++r) {
                for (std::size_t c = 0; c < 4; ++c) {
                    inverse.m[r][c] = static_cast<double>(columns[c * 4 + r]);
                }
            }
        }
        out.push_back(*place * inverse);
    }
    return out;
}

}  // namespace scotty::scenes
