#include <cstring>
#include <map>

#include "reference/base/error.h"
#include "scenes/collada_parts.h"
#include "scenes/file_scene.h"
#include "scenes/loaders.h"
#include "scenes/mesh.h"
#include "scenes/parse_number.h"

namespace scotty::scenes {

using reference::Scene;

namespace {

constexpr int kMaxDepth = 256;
/// Instances of instances multiply: no scene of use has this many nodes.
constexpr std::size_t kMaxNodes = 1'000'000;
constexpr const char* kDefaultMaterial = "";

/// Walks the node tree and fills a Scene.
class ColladaLoader {
 public:
    explicit ColladaLoader(const std::string& path) : document_(path) {}

    Scene load(CameraChoice choice, std::vector<Viewpoint>& viewpoints) {
        const pugi::xml_node root = document_.root();
        note_animations(root);
        metres_ = metres_of(root.child("asset").child("unit"));
        const Affine base = base_transform(root.child("asset"));
        const pugi::xml_node visual = visual_scene(root);
        for (const pugi::xml_node node : visual.children("node")) walk(node, base, 0);
        if (scene_.triangles.empty()) {
            throw document_.error(
                visual, notes_.explain("no triangles in any of its nodes, nothing to render"));
        }
        if (turned_ != 0) {
            notes_.add(
                "a triangle's winding and normals disagree: the winding says which side is "
                "the front",
                turned_);
        }
        scene_.file.meshes = meshes_.size();
        scene_.file.lights = scene_.lights.size();
        settle_emission(scene_, notes_);
        settle_camera(scene_, viewpoints_, settled(choice), notes_);
        viewpoints = std::move(viewpoints_);
        notes_.write_to(scene_.warnings);
        return std::move(scene_);
    }

 private:
    void note_animations(pugi::xml_node root) {
        for (const pugi::xml_node library : root.children("library_animations")) {
            const auto animations = library.children("animation");
            notes_.add(
                "an animation is not supported: the scene stands still",
                static_cast<std::size_t>(std::distance(animations.begin(), animations.end())));
        }
    }

    double metres_of(pugi::xml_node unit) const {
        const pugi::xml_attribute metres = unit.attribute("meter");
        if (!metres) return 1.0;
        const double scale = parse_finite(metres.value()).value_or(0.0);
        if (scale > 0.0) return scale;
        throw document_.error(
            unit, fmt::format("meter: expected more than 0, found '{}'", metres.value()));
    }

    /// To y up and metres. The axes change places exactly, so that no coordinate is rounded.
    Affine base_transform(pugi::xml_node asset) const {
        const std::string up = document_.word(asset.child("up_axis"), "Y_UP");
        const double scale = metres_;
        Affine out;
        if (up == "Z_UP") {
            out.m = {{{scale, 0, 0, 0}, {0, 0, scale, 0}, {0, -scale, 0, 0}}};
        } else if (up == "X_UP") {
            out.m = {{{0, -scale, 0, 0}, {scale, 0, 0, 0}, {0, 0, scale, 0}}};
        } else if (up == "Y_UP") {
            out.m = {{{scale, 0, 0, 0}, {0, scale, 0, 0}, {0, 0, scale, 0}}};
        } else {
            throw document_.error(asset.child("up_axis"),
                                  fmt::format("expected X_UP, Y_UP or Z_UP, found '{}'", up));
        }
        return out;
    }

    pugi::xml_node visual_scene(pugi::xml_node root) {
        if (const pugi::xml_node instance = root.child("scene").child("instance_visual_scene")) {
            return document_.target(instance, "url", "visual_scene");
        }
        const pugi::xml_node first = root.child("library_visual_scenes").child("visual_scene");
        if (!first) throw document_.error(root, "expected a <visual_scene>, found none");
        notes_.add("the file does not say which scene to show: the first <visual_scene> is used");
        return first;
    }

    void walk(pugi::xml_node node, const Affine& above, int depth) {
        if (depth > kMaxDepth) {
            throw document_.error(
                node, fmt::format("nodes more than {} deep, or in a circle", kMaxDepth));
        }
        if (++nodes_ > kMaxNodes) {
            throw document_.error(
                node, fmt::format("instances of instances make more than {} nodes", kMaxNodes));
        }
        const Affine place = above * read_transform(document_, node, notes_);
        for (const pugi::xml_node child : node.children()) {
            const std::string kind = child.name();
            if (kind == "node") {
                walk(child, place, depth + 1);
            } else if (kind == "instance_node") {
                walk(document_.target(child, "url", "node"), place, depth + 1);
            } else if (kind == "instance_geometry") {
                add_instance(child, document_.target(child, "url", "geometry"), place);
            } else if (kind == "instance_light") {
                const auto element = document_.target(child, "url", "light");
                const auto light = read_light(document_, element, place, metres_, notes_);
                if (light) scene_.lights.push_back(*light);
            } else if (kind == "instance_camera") {
                take_camera(node, child, place);
            } else if (kind == "instance_controller") {
                const pugi::xml_node controller = document_.target(child, "url", "controller");
                add_controlled(child, controller, place, depth);
            }
        }
    }

    /// A skin or morph: the mesh that it controls, as it was when it was bound.
    void add_controlled(pugi::xml_node instance, pugi::xml_node controller, const Affine& place,
                        int depth) {
        if (depth > kMaxDepth) throw document_.error(controller, "controllers in a circle");
        const pugi::xml_node skin = controller.child("skin");
        const pugi::xml_node morph = controller.child("morph");
        if (!skin && !morph)
            throw document_.error(controller, "expected a <skin> or <morph> inside");
        notes_.add(skin ? "a skin is not supported: the mesh is in the pose that it was bound in"
                        : "a morph is not supported: the mesh is in its basic form");
        Affine bound = place;
        if (const pugi::xml_node matrix = skin.child("bind_shape_matrix")) {
            bound = place * read_matrix(document_, matrix);
        }
        const pugi::xml_node user = skin ? skin : morph;
        if (document_.points_to(user, "source", "controller")) {
            add_controlled(instance, document_.target(user, "source", "controller"), bound,
                           depth + 1);
        } else {
            add_instance(instance, document_.target(user, "source", "geometry"), bound);
        }
    }

    /// Scotty3D keeps a file's camera direction and places the camera itself; files made for it
    /// rely on that (their own positions look out from floor height).
    CameraChoice settled(CameraChoice choice) {
        if (choice != CameraChoice::automatic) return choice;
        if (viewpoints_.empty() || !document_.made_for_scotty3d()) return choice;
        notes_.add(
            "the camera frames the scene, as Scotty3D does with such files: "
            "#camera=file takes the file's own position");
        return CameraChoice::fit;
    }

    void take_camera(pugi::xml_node node, pugi::xml_node instance, const Affine& place) {
        ++scene_.file.cameras;
        try {
            const pugi::xml_node element = document_.target(instance, "url", "camera");
            const auto camera = read_camera(document_, element, place, notes_);
            const std::string name = node.attribute("name").as_string();
            if (camera) {
                add_viewpoint(viewpoints_,
                              name.empty() ? element.attribute("name").as_string() : name, *camera);
            }
        } catch (const reference::Error& error) {
            if (viewpoints_.empty()) throw;  // the scene's own
            notes_.add(fmt::format("a further camera: left out ({})", error.what()));
        }
    }

    /// Material index for a part's symbol, by the bindings of its instance.
    std::uint32_t bound_material(pugi::xml_node instance, const std::string& symbol) {
        const pugi::xml_node bindings = instance.child("bind_material").child("technique_common");
        pugi::xml_node binding =
            bindings.find_child_by_attribute("instance_material", "symbol", symbol.c_str());
        // Analytic spheres and some meshes name no symbol: the first binding is meant.
        if (!binding && symbol.empty()) binding = bindings.child("instance_material");
        if (!binding) {
            notes_.add(kDefaultMaterialNote);
            return material(kDefaultMaterial, {});
        }
        const pugi::xml_node element = document_.target(binding, "target", "material");
        return material(element.attribute("id").value(), element);
    }

    std::uint32_t material(const std::string& id, pugi::xml_node element) {
        const auto known = materials_.find(id);
        if (known != materials_.end()) return known->second;
        const std::uint32_t index =
            element ? add_material(scene_, read_material(document_, element, notes_))
                    : add_default_material(scene_);
        materials_.emplace(id, index);
        return index;
    }

    const ColladaMesh& mesh(pugi::xml_node geometry) {
        const std::string id = geometry.attribute("id").value();
        const auto known = meshes_.find(id);
        if (known != meshes_.end()) return known->second;
        return meshes_.emplace(id, read_geometry(document_, geometry, notes_)).first->second;
    }

    void add_instance(pugi::xml_node instance, pugi::xml_node geometry, const Affine& place) {
        const ColladaMesh& shape = mesh(geometry);
        ++scene_.file.instances;
        const auto base = static_cast<std::uint32_t>(scene_.vertices.size());
        if (scene_.vertices.size() + shape.positions.size() >= reference::kNone) {
            throw document_.error(instance, "more vertices than 32 bits can number");
        }
        if (static_cast<double>(scene_.triangles.size()) > kMaxTriangles) {
            throw document_.error(instance, fmt::format("more than {} triangles", kMaxTriangles));
        }
        for (std::size_t i = 0; i < shape.positions.size(); ++i) {
            add_vertex(scene_, rounded(place.point(shape.positions[i])),
                       rounded(place.normal(shape.normals[i])));
        }
        // A mirroring transform turns triangles over: back again, so that fronts stay fronts.
        const bool mirrored = place.determinant() < 0.0;
        for (const ColladaMesh::Part& part : shape.parts) {
            const std::uint32_t index = bound_material(instance, part.symbol);
            for (auto [a, b, c] : part.triangles) {
                if (mirrored) std::swap(b, c);
                add_triangle(scene_, base + a, base + b, base + c, index);
                turned_ += disagrees(scene_.triangles.back()) ? 1u : 0u;
            }
        }
    }

    bool disagrees(const std::array<std::uint32_t, 3>& triangle) const {
        const auto& [a, b, c] = triangle;
        const Vec3& corner = scene_.vertices[a];
        const Vec3 front =
            reference::cross(scene_.vertices[b] - corner, scene_.vertices[c] - corner);
        const Vec3 normal = scene_.normals[a] + scene_.normals[b] + scene_.normals[c];
        return reference::dot(front, normal) < 0.0f;
    }

    ColladaDocument document_;
    Scene scene_;
    Notes notes_;
    std::vector<Viewpoint> viewpoints_;
    std::map<std::string, std::uint32_t> materials_;
    std::map<std::string, ColladaMesh> meshes_;
    double metres_ = 1.0;
    std::size_t nodes_ = 0;
    std::size_t turned_ = 0;
};

}  // namespace

Scene load_collada(const std::string& path, CameraChoice camera,
                   std::vector<Viewpoint>& viewpoints) {
    return ColladaLoader(path).load(camera, viewpoints);
}

}  // namespace scotty::scenes
