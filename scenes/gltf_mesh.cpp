#include <fmt/format.h>

#include "scenes/gltf_primitive.h"

namespace scotty::scenes {

namespace {

constexpr std::uint64_t kTriangles = 4;
constexpr std::uint64_t kFan = 6;

std::optional<GltfAccessor> attribute(GltfDocument& document, const GltfObject& attributes,
                                      const char* name) {
    const auto index = attributes.whole(name);
    if (!index) return std::nullopt;
    return GltfAccessor(document, *index, attributes);
}

void check_attribute(const GltfAccessor& accessor, const GltfObject& primitive, const char* name,
                     std::uint64_t vertices, bool quantised, Notes& notes) {
    accessor.expect_components(3);
    if (accessor.count() != vertices) {
        throw primitive.error(fmt::format("{}: expected {} elements, as POSITION has, found {}",
                                          name, vertices, accessor.count()));
    }
    if (accessor.is_float()) return;
    if (!accessor.is_short()) {
        throw accessor.error(fmt::format("{}: 32-bit whole numbers are not allowed here", name));
    }
    if (!quantised) {
        notes.add(
            "an attribute of small whole numbers, but no KHR_mesh_quantization: read as if it were "
            "there");
    }
}

void note_unsupported(const GltfObject& primitive, const GltfObject& attributes, Notes& notes) {
    if (attributes.has("COLOR_0")) {
        notes.add("vertex colours are not supported: left out");
    }
    if (attributes.has("JOINTS_0") && primitive.extension("KHR_draco_mesh_compression")) {
        notes.add("skinning of a Draco mesh is not supported: it is as it was bound");
    }
}

/// JOINTS_0 with WEIGHTS_0, JOINTS_1 with WEIGHTS_1 and so on.
std::vector<GltfInfluences> read_influences(GltfDocument& document, const GltfObject& attributes,
                                            std::uint64_t vertices) {
    std::vector<GltfInfluences> out;
    for (int set = 0;; ++set) {
        auto joints = attribute(document, attributes, fmt::format("JOINTS_{}", set).c_str());
        if (!joints) return out;
        auto weights = attribute(document, attributes, fmt::format("WEIGHTS_{}", set).c_str());
        if (!weights) throw attributes.error(fmt::format("WEIGHTS_{} is missing", set));
        joints->expect_components(4);
        weights->expect_components(4);
        if (joints->count() != vertices || weights->count() != vertices || joints->is_float()) {
            throw attributes.error(
                fmt::format("JOINTS_{0} and WEIGHTS_{0}: expected {1} elements, "
                            "as POSITION has, and whole numbers for joints",
                            set, vertices));
        }
        out.push_back({*std::move(joints), *std::move(weights)});
    }
}

std::vector<GltfTarget> read_targets(GltfDocument& document, const GltfObject& primitive,
                                     std::uint64_t vertices, bool quantised, Notes& notes) {
    std::vector<GltfTarget> out;
    for (const GltfObject& object : primitive.objects("targets")) {
        out.push_back(
            {attribute(document, object, "POSITION"), attribute(document, object, "NORMAL")});
        const auto& [position, normal] = out.back();
        if (position) check_attribute(*position, object, "POSITION", vertices, quantised, notes);
        if (normal) check_attribute(*normal, object, "NORMAL", vertices, quantised, notes);
    }
    return out;
}

void check_corner_count(const GltfPrimitive& primitive, Notes& notes) {
    const std::uint64_t corners = primitive.corners();
    if (corners < 3 || (primitive.mode == kTriangles && corners % 3 != 0)) {
        notes.add(
            "a primitive whose corners make no whole number of triangles: the rest is left out");
    }
}

std::optional<GltfPrimitive> read_primitive(GltfDocument& document, const GltfObject& object,
                                            bool quantised, Notes& notes) {
    const std::uint64_t mode = object.whole("mode", kTriangles);
    if (mode > kFan) {
        throw object.error(fmt::format("mode: expected 0 to 6, found {}", mode));
    }
    if (mode < kTriangles) {
        notes.add("lines and points are not supported: left out");
        return std::nullopt;
    }
    const auto attributes = object.object("attributes");
    if (!attributes || !attributes->has("POSITION")) {
        notes.add("a primitive without positions: left out");
        return std::nullopt;
    }
    note_unsupported(object, *attributes, notes);
    std::optional<GltfPrimitive> primitive;
    if (const auto draco = object.extension("KHR_draco_mesh_compression")) {
        GltfDracoMesh mesh = decode_draco(document, *draco);
        primitive = GltfPrimitive{
            object.place(),         mode, {}, std::move(mesh.position), std::move(mesh.normal),
            std::move(mesh.indices)};
    } else {
        primitive = GltfPrimitive{object.place(),
                                  mode,
                                  {},
                                  *attribute(document, *attributes, "POSITION"),
                                  attribute(document, *attributes, "NORMAL"),
                                  std::nullopt};
        if (const auto indices = object.whole("indices")) {
            primitive->indices.emplace(document, *indices, object);
            primitive->indices->expect_indices();
        }
    }
    primitive->material = object.whole("material");
    const std::uint64_t vertices = primitive->position.count();
    check_attribute(primitive->position, object, "POSITION", vertices, quantised, notes);
    if (primitive->normal) {
        check_attribute(*primitive->normal, object, "NORMAL", vertices, quantised, notes);
    }
    primitive->targets = read_targets(document, object, vertices, quantised, notes);
    if (!object.extension("KHR_draco_mesh_compression")) {
        primitive->influences = read_influences(document, *attributes, vertices);
    }
    check_corner_count(*primitive, notes);
    if (!primitive->position.has_data()) {
        notes.add("a primitive whose positions have no data: left out");
        return std::nullopt;
    }
    return primitive;
}

}  // namespace

std::uint64_t GltfPrimitive::triangles() const {
    if (mode == kTriangles) return corners() / 3;
    return corners() < 3 ? 0 : corners() - 2;
}

std::vector<GltfPrimitive> read_gltf_mesh(GltfDocument& document, const GltfObject& mesh,
                                          Notes& notes) {
    const bool quantised = document.uses("KHR_mesh_quantization");
    std::vector<GltfPrimitive> out;
    for (const GltfObject& object : mesh.objects("primitives")) {
        if (auto primitive = read_primitive(document, object, quantised, notes)) {
            out.push_back(*std::move(primitive));
        }
    }
    return out;
}

}  // namespace scotty::scenes
