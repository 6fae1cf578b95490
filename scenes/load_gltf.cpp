#include <fmt/format.h>

#include <map>

#include "scenes/file_scene.h"
#include "scenes/gltf_parts.h"
#include "scenes/gltf_primitive.h"
#include "scenes/loaders.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Error;
using reference::Scene;

namespace {

/// Walks the nodes of a glTF file and fills a Scene.
class GltfLoader {
 public:
    explicit GltfLoader(const std::string& path) : document_(path, notes_) {}

    Scene load(CameraChoice choice, std::vector<Viewpoint>& viewpoints) {
        const GltfObject root = document_.root();
        notes_.add("an animation is not supported: the scene stands still",
                   root.length("animations"));
        const GltfNodes nodes(document_, notes_);
        for (const auto& [index, place] : nodes.placed()) {
            visit(root.at("nodes", index, root), place, nodes);
        }
        reserve();
        for (const Instance& instance : instances_) add_triangles(instance);
        if (scene_.triangles.empty()) {
            throw root.error(notes_.explain("no triangles in the scene, nothing to render"));
        }
        scene_.file.meshes = meshes_.size();
        scene_.file.instances = instances_.size();
        scene_.file.lights = scene_.lights.size();
        settle_emission(scene_, notes_);
        settle_camera(scene_, viewpoints_, choice, notes_);
        viewpoints = std::move(viewpoints_);
        notes_.write_to(scene_.warnings);
        return std::move(scene_);
    }

 private:
    struct Instance {
        std::uint64_t mesh;
        GltfPose pose;
    };

    void visit(const GltfObject& node, const Affine& place, const GltfNodes& nodes) {
        const GltfObject root = document_.root();
        if (const auto mesh = node.whole("mesh")) add_instance(*mesh, node, place, nodes);
        if (const auto light = node.extension("KHR_lights_punctual")) {
            const auto lights = root.extension("KHR_lights_punctual");
            if (!lights) throw light->error("the file has no lights");
            const auto read = read_gltf_light(
                lights->at("lights", light->required_whole("light"), node), place, notes_);
            if (read) scene_.lights.push_back(*read);
        }
        if (const auto camera = node.whole("camera")) {
            ++scene_.file.cameras;
            const GltfObject element = root.at("cameras", *camera, node);
            const auto read = read_gltf_camera(element, place, notes_);
            const std::string name = element.text("name", node.text("name", ""));
            if (read) add_viewpoint(viewpoints_, name, *read);
        }
    }

    void add_instance(std::uint64_t mesh, const GltfObject& node, const Affine& place,
                      const GltfNodes& nodes) {
        read_mesh(mesh, node);
        GltfPose pose{place, {}, node.numbers("weights")};
        if (pose.weights.empty()) {
            pose.weights = document_.root().at("meshes", mesh, node).numbers("weights");
        }
        if (const auto skin = node.whole("skin")) {
            auto known = skins_.find(*skin);
            if (known == skins_.end()) {
                const GltfObject object = document_.root().at("skins", *skin, node);
                known = skins_.emplace(*skin, read_gltf_skin(document_, object, nodes)).first;
            }
            pose.joints = known->second;
        }
        instances_.push_back({mesh, std::move(pose)});
    }

    void read_mesh(std::uint64_t mesh, const GltfObject& user) {
        if (meshes_.contains(mesh)) return;
        const GltfObject object = document_.root().at("meshes", mesh, user);
        meshes_.emplace(mesh, read_gltf_mesh(document_, object, notes_));
    }

    /// Makes room at once for what all instances have, so that nothing has to be copied later.
    void reserve() {
        std::uint64_t triangles = 0;
        std::uint64_t vertices = 0;
        for (const Instance& instance : instances_) {
            for (const GltfPrimitive& primitive : meshes_.at(instance.mesh)) {
                triangles += primitive.triangles();
                vertices += std::min(primitive.position.count(), primitive.corners());
            }
            if (triangles > static_cast<std::uint64_t>(kMaxTriangles)) {
                throw Error::bad_input(
                    document_.path(),
                    fmt::format("more than {:.0f} triangles in all nodes together", kMaxTriangles));
            }
        }
        scene_.triangles.reserve(triangles);
        scene_.material_of.reserve(triangles);
        scene_.vertices.reserve(vertices);
        scene_.normals.reserve(vertices);
    }

    void add_triangles(const Instance& instance) {
        for (const GltfPrimitive& primitive : meshes_.at(instance.mesh)) {
            const auto material = material_of(primitive);
            if (material) add_gltf_primitive(scene_, primitive, instance.pose, *material);
        }
    }

    /// Nothing where the material makes the primitive invisible.
    std::optional<std::uint32_t> material_of(const GltfPrimitive& primitive) {
        const auto known = materials_.find(primitive.material);
        if (known != materials_.end()) return known->second;
        std::optional<std::uint32_t> index;
        if (!primitive.material) {
            notes_.add(kDefaultMaterialNote);
            index = add_default_material(scene_);
        } else {
            const GltfObject root = document_.root();
            if (*primitive.material >= root.length("materials")) {
                throw Error::bad_input(primitive.place,
                                       fmt::format("material {} out of range, the file has {}",
                                                   *primitive.material, root.length("materials")));
            }
            const GltfMaterial read =
                read_gltf_material(root.at("materials", *primitive.material, root), notes_);
            if (read.is_visible) index = add_material(scene_, read.material);
        }
        materials_.emplace(primitive.material, index);
        return index;
    }

    Notes notes_;
    GltfDocument document_;
    Scene scene_;
    std::vector<Viewpoint> viewpoints_;
    std::vector<Instance> instances_;
    std::map<std::uint64_t, std::vector<GltfPrimitive>> meshes_;
    std::map<std::uint64_t, std::vector<Affine>> skins_;
    std::map<std::optional<std::uint64_t>, std::optional<std::uint32_t>> materials_;
};

}  // namespace

Scene load_gltf(const std::string& path, CameraChoice camera, std::vector<Viewpoint>& viewpoints) {
    return GltfLoader(path).load(camera, viewpoints);
}

}  // namespace scotty::scenes
