#include "verify/capture/pipeline_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <type_traits>
#include <vector>

#include "reference/base/error.h"
#include "reference/contract/scene_fields.h"
#include "verify/capture/layout.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

using nlohmann::json;
using nlohmann::ordered_json;
using reference::ElementType;
using reference::Error;
using reference::Light;
using reference::Material;
using reference::Scene;
using reference::Vec3;
using reference::WideBvh;
using reference::WideNode;
namespace fs = std::filesystem;

namespace {

constexpr const char* kInputFile = "input.json";

/// Columns of the tables; the kind (and a flag) is a float that holds a small whole number.
constexpr std::array kMaterialColumns{"kind",
                                      "reflectance.r",
                                      "reflectance.g",
                                      "reflectance.b",
                                      "transmittance.r",
                                      "transmittance.g",
                                      "transmittance.b",
                                      "ior",
                                      "emission.r",
                                      "emission.g",
                                      "emission.b",
                                      "emission_is_sampled"};
constexpr std::array kLightColumns{
    "kind",     "position.x", "position.y", "position.z", "edge_x.x", "edge_x.y",
    "edge_x.z", "edge_y.x",   "edge_y.y",   "edge_y.z",   "normal.x", "normal.y",
    "normal.z", "radiance.r", "radiance.g", "radiance.b", "area"};
constexpr std::array kCameraColumns{"position.x",   "position.y",    "position.z", "right.x",
                                    "right.y",      "right.z",       "up.x",       "up.y",
                                    "up.z",         "forward.x",     "forward.y",  "forward.z",
                                    "tan_half_fov", "tan_half_width"};

/// A row of floats, filled or read in order.
template <bool Reads>
class Row {
 public:
    using Float = std::conditional_t<Reads, const float, float>;
    explicit Row(Float* at) : at_(at) {}

    template <class T>
    void operator()(T& field) {
        if constexpr (std::is_same_v<std::remove_const_t<T>, Vec3>) {
            for (int axis = 0; axis < 3; ++axis) (*this)(field[axis]);
        } else if constexpr (!Reads) {
            *at_++ = static_cast<float>(field);
        } else if constexpr (std::is_same_v<T, float>) {
            field = *at_++;
        } else {
            field = static_cast<T>(static_cast<std::uint32_t>(*at_++));
        }
    }

 private:
    Float* at_;
};

/// Writes arrays of four-byte elements.
class ArrayWriter {
 public:
    explicit ArrayWriter(const fs::path& directory) : folder_(directory) {}

    template <class T>
    void add(const std::string& name, const std::vector<T>& data,
             const std::vector<std::size_t>& shape, const char* meaning) {
        static_assert(sizeof(T) % 4 == 0);
        constexpr bool kFloats = std::is_same_v<T, Vec3> || std::is_same_v<T, float>;
        folder_.add(name, kFloats ? capture::Type::float32 : capture::Type::uint32, shape,
                    data.data(), meaning);
    }
    void finish(const CaptureHeader& header) {
        const auto names = [](const auto& columns) {
            return std::vector<std::string>(columns.begin(), columns.end());
        };
        folder_.finish(layout_header(header), {{"material_columns", names(kMaterialColumns)},
                                               {"light_columns", names(kLightColumns)},
                                               {"camera_columns", names(kCameraColumns)}});
    }

 private:
    capture::InputFolder folder_;
};

/// Reads the arrays that input.json should name; file names are ours, never taken from it.
class ArrayReader {
 public:
    /// `list`: the member "arrays" of input.json, borrowed.
    ArrayReader(fs::path directory, const json& list)
        : directory_(std::move(directory)), list_(list) {}

    /// `row`: the shape without its first size; T is one row, or one element of it.
    template <class T>
    std::vector<T> read(const std::string& name, ElementType type,
                        const std::vector<std::size_t>& row) const {
        const fs::path file = directory_ / (name + ".npy");
        NpyArray array = read_npy(file);
        const bool fits = array.type == type && array.shape.size() == row.size() + 1 &&
                          std::equal(row.begin(), row.end(), array.shape.begin() + 1);
        if (!fits) {
            throw Error::bad_input(file.string(),
                                   fmt::format("expected {} [n{}{}], found {} {}", to_string(type),
                                               row.empty() ? "" : ", ", fmt::join(row, ", "),
                                               to_string(array.type), shape_text(array.shape)));
        }
        const std::string where = fmt::format("{}: arrays", (directory_ / kInputFile).string());
        const std::string hash =
            text_member(where + ": " + name, member(where, list_, name.c_str()), "hash");
        if (const std::string found = hash_text(array.bytes.data(), array.bytes.size());
            found != hash) {
            throw Error::bad_input(file.string(), fmt::format("expected bytes of hash {}, found "
                                                              "{}; the file has been changed",
                                                              hash, found));
        }
        std::vector<T> out(array.bytes.size() / sizeof(T));
        if (!array.bytes.empty()) std::memcpy(out.data(), array.bytes.data(), array.bytes.size());
        return out;
    }
    std::vector<std::uint32_t> words(const std::string& name) const {
        return read<std::uint32_t>(name, ElementType::uint32, {});
    }

 private:
    fs::path directory_;
    const json& list_;
};

template <std::size_t Columns, class T, class Fill>
std::vector<float> table_of(const std::vector<T>& records, const Fill& fill) {
    std::vector<float> table(records.size() * Columns);
    for (std::size_t i = 0; i < records.size(); ++i) {
        fill(Row<false>(table.data() + i * Columns), records[i]);
    }
    return table;
}

template <class T, std::size_t Columns, class Fill>
std::vector<T> records_of(const ArrayReader& arrays, const char* name, const Fill& fill) {
    const auto table = arrays.read<float>(name, ElementType::float32, {Columns});
    std::vector<T> records(table.size() / Columns);
    for (std::size_t i = 0; i < records.size(); ++i) {
        fill(Row<true>(table.data() + i * Columns), records[i]);
    }
    return records;
}

// Wide nodes are taken apart by field: their padding is nobody's.
template <int Width>
void add_nodes(ArrayWriter& arrays, const std::vector<WideNode<Width>>& nodes) {
    std::vector<float> boxes, bounds;
    std::vector<std::uint32_t> children;
    for (const WideNode<Width>& node : nodes) {
        for (const auto* side :
             {&node.low_x, &node.low_y, &node.low_z, &node.high_x, &node.high_y, &node.high_z}) {
            boxes.insert(boxes.end(), std::begin(*side), std::end(*side));
        }
        children.insert(children.end(), std::begin(node.child), std::end(node.child));
        bounds.insert(bounds.end(), std::begin(node.low), std::end(node.low));
        bounds.insert(bounds.end(), std::begin(node.high), std::end(node.high));
    }
    constexpr auto kWidth = static_cast<std::size_t>(Width);
    arrays.add("bvh_boxes", boxes, {nodes.size(), 6, kWidth},
               "inner nodes' child boxes: low x, y, z, high x, y, z of each child");
    arrays.add("bvh_children", children, {nodes.size(), kWidth},
               "inner nodes' children: node id, 0xffffffff where there is none");
    arrays.add("bvh_bounds", bounds, {nodes.size(), 6}, "inner nodes' own boxes: low, high");
}

template <int Width>
std::vector<WideNode<Width>> read_nodes(const ArrayReader& arrays, const fs::path& directory) {
    constexpr auto kWidth = static_cast<std::size_t>(Width);
    const auto boxes = arrays.read<float>("bvh_boxes", ElementType::float32, {6, kWidth});
    const auto children = arrays.read<std::uint32_t>("bvh_children", ElementType::uint32, {kWidth});
    const auto bounds = arrays.read<float>("bvh_bounds", ElementType::float32, {6});
    const std::size_t count = children.size() / kWidth;
    if (boxes.size() != count * 6 * kWidth || bounds.size() != count * 6) {
        throw Error::bad_input((directory / "bvh_children.npy").string(),
                               fmt::format("{} nodes, but bvh_boxes has {} and bvh_bounds {}",
                                           count, boxes.size() / (6 * kWidth), bounds.size() / 6));
    }
    std::vector<WideNode<Width>> nodes(count);
    for (std::size_t i = 0; i < count; ++i) {
        WideNode<Width>& node = nodes[i];
        const float* box = boxes.data() + i * 6 * kWidth;
        for (auto* side :
             {&node.low_x, &node.low_y, &node.low_z, &node.high_x, &node.high_y, &node.high_z}) {
            std::copy_n(box, kWidth, std::begin(*side));
            box += kWidth;
        }
        std::copy_n(children.data() + i * kWidth, kWidth, std::begin(node.child));
        std::copy_n(bounds.data() + i * 6, 3, std::begin(node.low));
        std::copy_n(bounds.data() + i * 6 + 3, 3, std::begin(node.high));
    }
    return nodes;
}

void add_scene(ArrayWriter& arrays, const Scene& scene) {
    arrays.add("vertices", scene.vertices, {scene.vertices.size(), 3}, "positions, metres");
    arrays.add("normals", scene.normals, {scene.normals.size(), 3},
               "by vertex; no rows: all surfaces are flat");
    arrays.add("triangles", scene.triangles, {scene.triangles.size(), 3}, "vertex indices");
    arrays.add("material_of", scene.material_of, {scene.material_of.size()}, "by triangle");
    arrays.add(
        "materials",
        table_of<kMaterialColumns.size()>(
            scene.materials, [](auto row, const Material& m) { for_each_material_field(m, row); }),
        {scene.materials.size(), kMaterialColumns.size()}, "columns: see material_columns");
    arrays.add(
        "lights",
        table_of<kLightColumns.size()>(
            scene.lights, [](auto row, const Light& light) { for_each_light_field(light, row); }),
        {scene.lights.size(), kLightColumns.size()}, "columns: see light_columns");
    const std::vector<reference::Camera> camera{scene.camera};
    arrays.add(
        "camera",
        table_of<kCameraColumns.size()>(
            camera, [](auto row, const reference::Camera& c) { for_each_camera_field(c, row); }),
        {1, kCameraColumns.size()}, "columns: see camera_columns");
}

void add_bvh(ArrayWriter& arrays, const WideBvh& bvh) {
    std::visit([&](const auto& nodes) { add_nodes(arrays, nodes); }, bvh.inner);
    arrays.add("bvh_leaves", bvh.leaves, {bvh.leaves.size(), 2},
               "first and count into bvh_triangles");
    arrays.add("bvh_triangles", bvh.triangles, {bvh.triangles.size(), 10},
               "in leaf order: v0, v1, v2 as the bits of nine floats, primitive");
    arrays.add("bvh_node_refs", bvh.node_refs, {bvh.node_refs.size()},
               "by node id: 0x80000000 | leaf, or inner node");
    arrays.add("bvh_parents", bvh.parents, {bvh.parents.size()}, "by node id");
    arrays.add("bvh_level_begins", bvh.level_begins, {bvh.level_begins.size()},
               "level l is node ids [begins[l], begins[l + 1])");
}

Scene read_scene(const ArrayReader& arrays) {
    Scene scene;
    scene.vertices = arrays.read<Vec3>("vertices", ElementType::float32, {3});
    scene.normals = arrays.read<Vec3>("normals", ElementType::float32, {3});
    scene.triangles =
        arrays.read<std::array<std::uint32_t, 3>>("triangles", ElementType::uint32, {3});
    scene.material_of = arrays.words("material_of");
    scene.materials = records_of<Material, kMaterialColumns.size()>(
        arrays, "materials", [](auto row, Material& m) { for_each_material_field(m, row); });
    scene.lights = records_of<Light, kLightColumns.size()>(
        arrays, "lights", [](auto row, Light& light) { for_each_light_field(light, row); });
    const auto cameras = records_of<reference::Camera, kCameraColumns.size()>(
        arrays, "camera", [](auto row, reference::Camera& c) { for_each_camera_field(c, row); });
    if (!cameras.empty()) scene.camera = cameras.front();
    return scene;
}

WideBvh read_bvh(const ArrayReader& arrays, const fs::path& directory, int width) {
    WideBvh bvh;
    bvh.width = width;
    switch (width) {
        case 2:
            bvh.inner = read_nodes<2>(arrays, directory);
            break;
        case 4:
            bvh.inner = read_nodes<4>(arrays, directory);
            break;
        case 8:
            bvh.inner = read_nodes<8>(arrays, directory);
            break;
        default:  // parameters have been validated
            bvh.inner = read_nodes<16>(arrays, directory);
            break;
    }
    bvh.leaves = arrays.read<reference::Leaf>("bvh_leaves", ElementType::uint32, {2});
    bvh.triangles =
        arrays.read<reference::LeafTriangle>("bvh_triangles", ElementType::uint32, {10});
    bvh.node_refs = arrays.words("bvh_node_refs");
    bvh.parents = arrays.words("bvh_parents");
    bvh.level_begins = arrays.words("bvh_level_begins");
    return bvh;
}

/// Other programs do not know fingerprints; the hash of each array has been checked.
void expect_fingerprint(const fs::path& file, const char* what, std::optional<std::uint64_t> said,
                        std::uint64_t found) {
    if (!said || *said == found) return;
    throw Error::bad_input(file.string(),
                           fmt::format("expected a {} of fingerprint {}, found {}; an array beside "
                                       "it has been changed",
                                       what, hex_text(*said), hex_text(found)));
}

}  // namespace

void write_pipeline_input(const fs::path& directory, const Scene& scene, const WideBvh& bvh,
                          const reference::PipelineParameters& parameters) {
    as_bad_input([&] {
        ArrayWriter arrays(directory);
        add_scene(arrays, scene);
        add_bvh(arrays, bvh);
        arrays.finish(header_of("none", scene, bvh, parameters));
    });
}

PipelineInput read_pipeline_input(const fs::path& given) {
    const fs::path directory =
        fs::exists(given / kInputFolder / kInputFile) ? given / kInputFolder : given;
    const fs::path file = directory / kInputFile;
    if (!fs::exists(file)) {
        throw Error::bad_input(given.string(),
                               fmt::format("expected a pipeline input, but there is no {} (make "
                                           "one with: scotty capture SCENE -o DIR --input-only)",
                                           kInputFile));
    }
    const json object = read_json(file);
    expect_format(file, object, kInputFormat);
    const std::string where = file.string();
    PipelineInput input;
    const json& scene = member(where, object, "scene");
    const auto scene_said = fingerprint_member(where + ": scene", scene);
    const auto bvh_said = fingerprint_member(where + ": bvh", member(where, object, "bvh"));
    input.parameters =
        parse_parameters(where + ": parameters", member(where, object, "parameters"), !scene_said);
    const ArrayReader arrays(directory, member(where, object, "arrays"));
    input.scene = read_scene(arrays);
    input.scene.name = text_member(where + ": scene", scene, "name");
    input.scene.source = text_member(where + ": scene", scene, "source");
    expect_fingerprint(file, "scene", scene_said, fingerprint(input.scene));
    input.bvh = read_bvh(arrays, directory, input.parameters.width);
    expect_fingerprint(file, "BVH", bvh_said, fingerprint(input.bvh));
    return input;
}

CaptureHeader header_of(const std::string& backend, const Scene& scene, const WideBvh& bvh,
                        const reference::PipelineParameters& parameters) {
    CaptureHeader header;
    header.backend = backend;
    header.parameters = parameters;
    header.scene_name = scene.name;
    header.scene_source = scene.source;
    header.scene_fingerprint = fingerprint(scene);
    header.bvh_fingerprint = fingerprint(bvh);
    header.bvh_width = bvh.width;
    header.bvh_levels = bvh.level_count();
    return header;
}

}  // namespace scotty::verify
