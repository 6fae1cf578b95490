#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cstring>
#include <map>
#include <unordered_map>

#include "reference/base/error.h"
#include "scenes/affine.h"
#include "scenes/assimp_material.h"
#include "scenes/file_checks.h"
#include "scenes/file_scene.h"
#include "scenes/loaders.h"
#include "scenes/mesh.h"

namespace scotty::scenes {

using reference::Error;
using reference::Scene;

namespace {

enum class Format { obj, ply, gltf };

Format format_of(const std::string& path) {
    const char kind =
        static_cast<char>(std::tolower(static_cast<unsigned char>(path[path.rfind('.') + 1])));
    if (kind == 'o') return Format::obj;
    return kind == 'p' ? Format::ply : Format::gltf;
}

Affine from_assimp(const aiMatrix4x4& m) {
    Affine out;
    out.m = {{{m.a1, m.a2, m.a3, m.a4}, {m.b1, m.b2, m.b3, m.b4}, {m.c1, m.c2, m.c3, m.c4}}};
    return out;
}

/// Position and normal, bit for bit: vertices merge only where both are the same.
struct VertexBits {
    std::array<std::uint32_t, 6> bits;
    bool operator==(const VertexBits&) const = default;
};
struct VertexHash {
    std::size_t operator()(const VertexBits& vertex) const {
        std::size_t hash = 0;
        for (const std::uint32_t word : vertex.bits) {
            hash = (hash ^ word) * 0x9e3779b97f4a7c15ull;
            hash ^= hash >> 29;
        }
        return hash;
    }
};

class AssimpLoader {
 public:
    explicit AssimpLoader(std::string path) : path_(std::move(path)), format_(format_of(path_)) {}

    Scene load(CameraChoice choice) {
        if (format_ == Format::gltf) json_ = check_gltf(path_, notes_);
        source_ = importer_.ReadFile(path_, aiProcess_Triangulate | aiProcess_SortByPType);
        if (source_ == nullptr || source_->mRootNode == nullptr) {
            throw Error::bad_input(path_, importer_.GetErrorString());
        }
        if (format_ == Format::gltf) check_triangle_count();
        notes_.add("an animation is not supported: the scene stands still",
                   source_->mNumAnimations);
        walk(*source_->mRootNode, Affine{});
        if (scene_.triangles.empty()) {
            throw Error::bad_input(path_,
                                   notes_.explain("no triangles in the file, nothing to render"));
        }
        settle_emission(scene_, notes_);
        settle_camera(scene_, camera_, choice, notes_);
        notes_.write_to(scene_.warnings);
        return std::move(scene_);
    }

 private:
    /// assimp leaves faces with a bad index out of a glTF file without a word: count them.
    void check_triangle_count() const {
        std::uint64_t loaded = 0;
        for (unsigned i = 0; i < source_->mNumMeshes; ++i) {
            const aiMesh& mesh = *source_->mMeshes[i];
            if (mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) loaded += mesh.mNumFaces;
        }
        const std::uint64_t announced = gltf_triangles(json_);
        if (loaded >= announced) return;
        throw Error::bad_input(path_, fmt::format("meshes: {} of {} triangles have a vertex index "
                                                  "out of range",
                                                  announced - loaded, announced));
    }

    void walk(const aiNode& node, const Affine& above) {
        const Affine place = above * from_assimp(node.mTransformation);
        for (unsigned i = 0; i < node.mNumMeshes; ++i) {
            if (node.mMeshes[i] >= source_->mNumMeshes) continue;
            add_mesh(*source_->mMeshes[node.mMeshes[i]], node.mMeshes[i], place);
        }
        for (unsigned i = 0; i < source_->mNumLights; ++i) {
            if (source_->mLights[i]->mName == node.mName) add_light(*source_->mLights[i], place);
        }
        for (unsigned i = 0; i < source_->mNumCameras; ++i) {
            if (source_->mCameras[i]->mName == node.mName) take_camera(i, place);
        }
        for (unsigned i = 0; i < node.mNumChildren; ++i) walk(*node.mChildren[i], place);
    }

    void add_mesh(const aiMesh& mesh, unsigned number, const Affine& place) {
        if ((mesh.mPrimitiveTypes & aiPrimitiveType_TRIANGLE) == 0) {
            // Lines and points of an OBJ have been noted already.
            if (format_ != Format::obj) notes_.add("lines and points are not supported: left out");
            return;
        }
        if (mesh.HasBones()) notes_.add("skinning is not supported: the mesh is as it was bound");
        if (mesh.mNumAnimMeshes != 0) notes_.add("morph targets are not supported: left out");
        if (mesh.HasVertexColors(0)) notes_.add("vertex colours are not supported: left out");
        const std::vector<std::uint32_t> vertex_of = add_vertices(mesh, place);
        const bool mirrored = place.determinant() < 0.0;
        const std::uint32_t material = material_of(mesh);
        for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
            const aiFace& face = mesh.mFaces[i];
            if (face.mNumIndices != 3) {
                notes_.add("a face with fewer than 3 corners: left out");
                continue;
            }
            std::array<std::uint32_t, 3> corners{};
            for (unsigned k = 0; k < 3; ++k) {
                if (face.mIndices[k] >= mesh.mNumVertices) {
                    throw Error::bad_input(
                        fmt::format("{}: mesh {} ('{}'): triangle {}", path_, number,
                                    mesh.mName.C_Str(), i),
                        fmt::format("vertex index {} out of range, the mesh has {} vertices",
                                    face.mIndices[k], mesh.mNumVertices));
                }
                corners[k] = vertex_of[face.mIndices[k]];
            }
            if (mirrored) std::swap(corners[1], corners[2]);
            add_triangle(scene_, corners[0], corners[1], corners[2], material);
        }
    }

    /// assimp makes materials up that nothing uses: only those of meshes are looked at.
    std::uint32_t material_of(const aiMesh& mesh) {
        const unsigned number = mesh.mMaterialIndex;
        const auto known = materials_.find(number);
        if (known != materials_.end()) return known->second;
        std::uint32_t index = 0;
        if (format_ == Format::ply || number >= source_->mNumMaterials) {
            notes_.add(kDefaultMaterialNote);
            index = add_default_material(scene_);
        } else {
            index = add_material(scene_, scenes::from_assimp(*source_->mMaterials[number], notes_));
        }
        materials_.emplace(number, index);
        return index;
    }

    std::vector<std::uint32_t> add_vertices(const aiMesh& mesh, const Affine& place) {
        std::unordered_map<VertexBits, std::uint32_t, VertexHash> known;
        known.reserve(mesh.mNumVertices);
        std::vector<std::uint32_t> vertex_of(mesh.mNumVertices);
        for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
            const aiVector3D& p = mesh.mVertices[i];
            const Vec3 position = rounded(place.point({p.x, p.y, p.z}));
            Vec3 normal(0.0f, 0.0f, 0.0f);
            if (mesh.HasNormals()) {
                const aiVector3D& n = mesh.mNormals[i];
                normal = rounded(place.normal({n.x, n.y, n.z}));
            }
            VertexBits key{};
            std::memcpy(key.bits.data(), &position, sizeof position);
            std::memcpy(key.bits.data() + 3, &normal, sizeof normal);
            const auto next = static_cast<std::uint32_t>(scene_.vertices.size());
            const auto [entry, is_new] = known.emplace(key, next);
            if (is_new) add_vertex(scene_, position, normal);
            vertex_of[i] = entry->second;
        }
        return vertex_of;
    }

    void add_light(const aiLight& light, const Affine& place) {
        const aiColor3D& c = light.mColorDiffuse;
        const Vec3 radiance(c.r, c.g, c.b);
        if (light.mType == aiLightSource_DIRECTIONAL) {
            scene_.lights.push_back(directional_light(rounded(place.vector({0, 0, -1})), radiance));
        } else if (light.mType == aiLightSource_POINT || light.mType == aiLightSource_SPOT) {
            if (light.mType == aiLightSource_SPOT) {
                notes_.add("a spot light's cone is not supported: a point light");
            }
            scene_.lights.push_back(point_light(rounded(place.point({0, 0, 0})), radiance));
        } else {
            notes_.add("a light of no known kind: left out");
        }
    }

    /// A camera looks along its node's -z. Its angle comes from the JSON: assimp's horizontal one
    /// is computed in different ways by different versions.
    void take_camera(unsigned number, const Affine& place) {
        if (camera_) {
            notes_.add("a further camera: the first one is used");
            return;
        }
        const auto pointer =
            nlohmann::json::json_pointer(fmt::format("/cameras/{}/perspective/yfov", number));
        const nlohmann::json angle = json_.contains(pointer) ? json_.at(pointer) : nullptr;
        if (!angle.is_number() || !(angle.get<double>() > 0.0 && angle.get<double>() < 3.14159)) {
            notes_.add("a camera that is not a perspective one: left out");
            return;
        }
        const Vec3 forward = rounded(unit(place.vector({0, 0, -1})));
        const Vec3 up = rounded(unit(place.vector({0, 1, 0})));
        if (reference::length(reference::cross(forward, up)) < 1e-4f) {
            notes_.add("a camera whose transform leaves it no direction: left out");
            return;
        }
        camera_ = look_at(Vec3(0.0f, 0.0f, 0.0f), forward, up,
                          static_cast<float>(std::tan(0.5 * angle.get<double>())));
        camera_->position = rounded(place.point({0, 0, 0}));
    }

    std::string path_;
    Format format_;
    nlohmann::json json_;
    Assimp::Importer importer_;
    const aiScene* source_ = nullptr;
    Scene scene_;
    Notes notes_;
    std::optional<reference::Camera> camera_;
    std::map<unsigned, std::uint32_t> materials_;
};

}  // namespace

Scene load_with_assimp(const std::string& path, CameraChoice camera) {
    return AssimpLoader(path).load(camera);
}

}  // namespace scotty::scenes
