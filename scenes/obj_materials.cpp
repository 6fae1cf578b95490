#include "scenes/obj_materials.h"

#include <algorithm>
#include <array>
#include <vector>

#include "reference/base/error.h"
#include "scenes/file_scene.h"
#include "scenes/material_mapping.h"
#include "scenes/obj_library_names.h"
#include "scenes/obj_lines.h"
#include "scenes/parse_number.h"

namespace scotty::scenes {

using reference::Material;
using reference::MaterialKind;
using reference::Vec3;

namespace {

/// Names that are listed in a warning before it only counts.
constexpr std::size_t kMaxMissingNamed = 8;
/// A mtllib statement of more words is not searched for names with blanks in them, which takes the
/// square of this number of steps.
constexpr std::size_t kMaxJoinedWords = 8;
/// Each name is a search in folders.
constexpr std::size_t kMaxLibraryNames = 1024;

bool is_one_of(std::string_view key, std::initializer_list<std::string_view> list) {
    return std::find(list.begin(), list.end(), key) != list.end();
}

/// The statements of one library.
class LibraryReader {
 public:
    LibraryReader(const std::string& path, Notes& notes) : lines_(path), notes_(notes) {}

    /// Calls `take(name, material)` for each material.
    template <class Take>
    void read(const Take& take) {
        while (lines_.next()) {
            if (lines_.key() == "newmtl") {
                if (is_in_material_) take(name_, material_);
                name_ = lines_.rest();
                material_ = {};
                is_in_material_ = true;
            } else if (is_in_material_) {
                read_statement(lines_.key());
            } else {
                notes_.add("a statement before the first newmtl of a library: left out");
            }
        }
        if (is_in_material_) take(name_, material_);
    }

 private:
    void read_statement(std::string_view key) {
        if (key == "kd") {
            if (const auto value = colour()) material_.diffuse = value;
        } else if (key == "ks") {
            material_.specular = colour().value_or(material_.specular);
        } else if (key == "ke") {
            material_.emission = colour().value_or(material_.emission);
        } else if (key == "tf") {
            material_.filter = colour().value_or(material_.filter);
        } else if (key == "ni") {
            material_.refraction = number();
        } else if (key == "d") {
            material_.opacity = number();
        } else if (key == "tr") {
            // Where both are given, exporters disagree on what Tr means.
            const float transparency = number();
            if (!material_.opacity) material_.opacity = 1.0f - transparency;
        } else if (key == "illum") {
            material_.illumination = illumination();
        } else if (key.substr(0, 4) == "map_" ||
                   is_one_of(key, {"bump", "disp", "decal", "refl", "norm"})) {
            ++material_.textures;
        } else if (key == "pm") {
            material_.metallic = share();
        } else if (key == "pr") {
            material_.roughness = share();
        } else if (is_one_of(key, {"ps", "pc", "pcr", "aniso", "anisor"})) {
            ++material_.extensions;
        } else if (!is_one_of(key, {"ka", "ns", "km", "sharpness"})) {
            notes_.add("a statement of a material library that is not known: left out");
        }
    }

    /// One value stands for all three. Nothing, and a note, where the colour is not red, green and
    /// blue.
    std::optional<Vec3> colour() {
        std::string_view text = lines_.numbers();
        std::array<float, 3> values{};
        std::size_t count = 0;
        for (std::string_view word = take_word(text); !word.empty(); word = take_word(text)) {
            if (count == 0 && is_one_of(word, {"xyz", "spectral"})) {
                notes_.add("a colour as 'xyz' or 'spectral' is not supported: left out");
                return std::nullopt;
            }
            const std::optional<float> value = parse_finite_float(word);
            if (!value) fail_colour(word);
            if (count < 3) values[count] = *value;
            ++count;
        }
        if (count == 1) return Vec3(values[0]);
        if (count < 3) fail_colour("");
        if (count > 3) notes_.add("a colour of more than three numbers: the first three are used");
        return Vec3(values[0], values[1], values[2]);
    }

    [[noreturn]] void fail_colour(std::string_view word) const {
        lines_.fail(fmt::format("{}: expected one or three finite numbers, found '{}'",
                                lines_.key(), shown(word.empty() ? lines_.rest() : word)));
    }

    float number() const {
        std::string_view text = lines_.numbers();
        std::string_view word = take_word(text);
        if (word == "-halo") word = take_word(text);
        const std::optional<float> value = parse_finite_float(word);
        if (value) return *value;
        lines_.fail(fmt::format("{}: expected a finite number, found '{}'", lines_.key(),
                                shown(lines_.rest())));
    }

    float share() const {
        const float value = number();
        if (value < 0.0f || value > 1.0f) notes_.add("Pm or Pr beyond 0 to 1: clamped");
        return std::clamp(value, 0.0f, 1.0f);
    }

    int illumination() const {
        const float value = number();
        for (int model = 0; model <= 10; ++model) {
            if (value == static_cast<float>(model)) return model;
        }
        notes_.add("an illumination model that is none of 0 to 10: diffuse");
        return -1;
    }

    ObjLines lines_;
    Notes& notes_;
    std::string name_;
    ObjMaterial material_;
    bool is_in_material_ = false;
};

Vec3 positive(const Vec3& value) {
    Vec3 out;
    for (int k = 0; k < 3; ++k) out[k] = std::max(value[k], 0.0f);
    return out;
}

Vec3 reflected_share(const Vec3& value, Notes& notes) {
    Vec3 clamped;
    for (int k = 0; k < 3; ++k) clamped[k] = std::clamp(value[k], 0.0f, 1.0f);
    if (clamped != value) notes.add("a reflectance or transmittance beyond 0 to 1: clamped");
    return clamped;
}

Vec3 white_where_black(const Vec3& value) { return reference::is_zero(value) ? Vec3(1.0f) : value; }

float index_of_refraction(const ObjMaterial& source, Notes& notes) {
    const float ior = source.refraction.value_or(1.5f);
    if (ior >= 0.01f && ior <= 100.0f) return ior;
    notes.add("an index of refraction out of range: 1.5 is used");
    return 1.5f;
}

void note_losses_of_diffuse(const ObjMaterial& source, Notes& notes) {
    const int model = source.illumination;
    if (model > 7) notes.add("illumination models 8 to 10 are not supported: diffuse");
    // Models 0 and 1 have no highlights, whatever Ks says.
    if (!reference::is_zero(source.specular) && model != 0 && model != 1) {
        notes.add("specular highlights are not supported: diffuse part only");
    }
    if (source.opacity.value_or(1.0f) < 1.0f) {
        notes.add("partial opacity is not supported: opaque");
    }
}

}  // namespace

Material from_obj(const ObjMaterial& source, Notes& notes) {
    notes.add("a texture is not supported: the plain colour is used", source.textures);
    notes.add("physically based extensions of MTL (Ps, Pc, ...) are not supported: left out",
              source.extensions);
    Material material;
    material.emission = positive(source.emission);
    const int model = source.illumination;
    if (model == 4 || model == 6 || model == 7) {
        material.kind = MaterialKind::glass;
        material.ior = index_of_refraction(source, notes);
        material.reflectance = reflected_share(white_where_black(source.specular), notes);
        material.transmittance = reflected_share(white_where_black(source.filter), notes);
    } else if (model == 3 || model == 5) {
        material.kind = MaterialKind::mirror;
        material.reflectance = reflected_share(white_where_black(source.specular), notes);
    } else {
        if (!source.diffuse) notes.add("a material without Kd: grey 0.5");
        const Vec3 colour =
            reflected_share(source.diffuse.value_or(Vec3(kDefaultReflectance)), notes);
        material = material_from_metallic_roughness(colour, source.metallic.value_or(0.0f),
                                                    source.roughness.value_or(1.0f), notes);
        material.emission = positive(source.emission);
        note_losses_of_diffuse(source, notes);
    }
    return material;
}

void ObjMaterials::read_libraries(const std::filesystem::path& folder, std::string_view names) {
    if (!statements_read_.emplace(names).second) return;
    if (read_if_found(folder, names)) return;
    names = without_comment(names);
    if (read_if_found(folder, names)) return;
    std::vector<std::string_view> words;
    for (std::string_view text = names, word; !(word = take_word(text)).empty();) {
        words.push_back(word);
    }
    const auto run = [&](std::size_t first, std::size_t last) {
        const char* begin = words[first].data();
        return std::string_view(begin, static_cast<std::size_t>(words[last - 1].data() +
                                                                words[last - 1].size() - begin));
    };
    // The longest run of words that names a file is taken first.
    std::size_t missing_from = 0;
    for (std::size_t first = 0; first < words.size();) {
        std::size_t last = words.size() <= kMaxJoinedWords ? words.size() : first + 1;
        while (last > first && !read_if_found(folder, run(first, last))) --last;
        if (last == first) {
            ++first;
            continue;
        }
        if (missing_from < first) missing_.emplace(run(missing_from, first));
        first = missing_from = last;
    }
    if (missing_from < words.size()) missing_.emplace(run(missing_from, words.size()));
}

bool ObjMaterials::read_if_found(const std::filesystem::path& folder, std::string_view name) {
    if (++searches_ > kMaxLibraryNames) {
        throw reference::Error::bad_input(
            folder.string(), fmt::format("more than {} names of material libraries in one OBJ "
                                         "file: leave out those that are not needed",
                                         kMaxLibraryNames));
    }
    const std::filesystem::path path = find_library(folder, name);
    if (path.empty()) return false;
    if (files_read_.insert(path.lexically_normal().string()).second) read(path.string());
    return true;
}

void ObjMaterials::read(const std::string& path) {
    LibraryReader(path, notes_).read([&](const std::string& name, const ObjMaterial& material) {
        if (!materials_.emplace(name, material).second) {
            notes_.add("a material that is defined twice: the first definition is used");
        }
        const std::string_view plain = without_comment(name);
        if (plain != name) by_plain_name_.emplace(plain, name);
    });
}

const ObjMaterial* ObjMaterials::find(std::string_view name) const {
    for (const std::string_view spelling : {name, without_comment(name)}) {
        const auto known = materials_.find(spelling);
        if (known != materials_.end()) return &known->second;
        const auto longer = by_plain_name_.find(spelling);
        if (longer != by_plain_name_.end()) return &materials_.find(longer->second)->second;
    }
    return nullptr;
}

std::string ObjMaterials::name_in_other_case(std::string_view name) const {
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
    for (const auto& [known, material] : materials_) {
        if (std::equal(known.begin(), known.end(), name.begin(), name.end(),
                       [&](char a, char b) { return lower(a) == lower(b); })) {
            return known;
        }
    }
    return {};
}

void ObjMaterials::note_missing() const {
    std::size_t named = 0;
    for (const std::string& name : missing_) {
        if (named++ == kMaxMissingNamed) {
            notes_.add(fmt::format("{} further material libraries are missing",
                                   missing_.size() - kMaxMissingNamed));
            return;
        }
        notes_.add(
            fmt::format("the material library '{}' is missing: default material", shown(name)));
    }
}

}  // namespace scotty::scenes
