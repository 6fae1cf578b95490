/// The material libraries (MTL) of an OBJ file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "reference/contract/scene.h"
#include "scenes/notes.h"

namespace scotty::scenes {

/// A material as its library describes it; what is not said is missing or zero.
struct ObjMaterial {
    std::optional<reference::Vec3> diffuse;  ///< Kd
    reference::Vec3 specular{0.0f};          ///< Ks
    reference::Vec3 filter{0.0f};            ///< Tf
    reference::Vec3 emission{0.0f};          ///< Ke
    std::optional<float> refraction;         ///< Ni
    std::optional<float> opacity;            ///< d, or 1 - Tr
    std::optional<float> metallic;           ///< Pm
    std::optional<float> roughness;          ///< Pr
    int illumination = -1;                   ///< illum
    std::size_t textures = 0;                ///< statements that name an image
    std::size_t extensions = 0;              ///< of physically based shading: Ps, Pc, ...
};

/// Materials as they are rendered: illum 3 and 5 are mirrors, 4, 6 and 7 glass; else Pm and Pr
/// make it a rough metal (material_mapping.h), or it is diffuse; emission is kept. Notes what is
/// left out.
reference::Material from_obj(const ObjMaterial& source, Notes& notes);

class ObjMaterials {
 public:
    explicit ObjMaterials(Notes& notes) : notes_(notes) {}

    /// Reads the libraries that a mtllib statement names, each file once. Names may contain blanks,
    /// stand in quotes or have backslashes in them; they are relative to `folder`. Notes missing
    /// ones. Throws reference::Error (bad_input) naming file and line.
    void read_libraries(const std::filesystem::path& folder, std::string_view names);

    /// Null where no library has the material. Of two with one name the first counts.
    const ObjMaterial* find(std::string_view name) const;
    /// The name of a material that differs only in upper and lower case; empty where none does.
    std::string name_in_other_case(std::string_view name) const;

    /// Notes the libraries that were missing.
    void note_missing() const;

 private:
    bool read_if_found(const std::filesystem::path& folder, std::string_view name);
    void read(const std::string& path);

    Notes& notes_;
    std::map<std::string, ObjMaterial, std::less<>> materials_;
    /// For names with a comment behind them.
    std::map<std::string, std::string, std::less<>> by_plain_name_;
    std::set<std::string> files_read_;
    std::set<std::string> statements_read_;
    std::size_t searches_ = 0;
    std::set<std::string, std::less<>> missing_;
};

}  // namespace scotty::scenes
