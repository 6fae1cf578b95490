/// JSON objects of a glTF file that know their place in it, so that every fault can be named.
#pragma once

#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "reference/base/error.h"

namespace scotty::scenes {

/// An object of the JSON and its place ("a.gltf: meshes[2] ('Cube')"). It refers to the JSON, which
/// has to outlive it. A member of another type than asked for is an Error (bad_input) with the
/// place.
class GltfObject {
 public:
    /// Throws where `value` is no object. `place` is completed by the object's name, if it has one.
    GltfObject(const nlohmann::json& value, const std::string& place);

    const std::string& place() const { return place_; }
    reference::Error error(const std::string& what) const {
        return reference::Error::bad_input(place_, what);
    }

    bool has(const char* key) const { return value_->contains(key); }
    std::vector<std::string> keys() const;
    std::optional<GltfObject> object(const char* key) const;
    /// The extension's object on this one, nothing where it is not there.
    std::optional<GltfObject> extension(const char* name) const;
    /// The objects of an array; none where the array is missing.
    std::vector<GltfObject> objects(const char* key) const;
    std::size_t length(const char* key) const;
    /// One object of an array. `user` is who asks for it and is named where there are too few.
    GltfObject at(const char* key, std::uint64_t index, const GltfObject& user) const;

    /// A whole number of at most 2^48; -3, 0.5 and "7" are errors.
    std::optional<std::uint64_t> whole(const char* key) const;
    std::uint64_t whole(const char* key, std::uint64_t standard) const;
    std::uint64_t required_whole(const char* key) const;
    std::vector<std::uint64_t> wholes(const char* key) const;
    double number(const char* key, double standard) const;
    /// An array of any number of numbers; none where it is missing.
    std::vector<double> numbers(const char* key) const;
    std::string text(const char* key, const std::string& standard) const;
    std::vector<std::string> texts(const char* key) const;
    bool flag(const char* key, bool standard) const;

    /// An array of exactly N numbers.
    template <std::size_t N>
    std::array<double, N> numbers(const char* key, const std::array<double, N>& standard) const {
        const nlohmann::json* array = array_of(key);
        if (array == nullptr) return standard;
        if (array->size() != N) throw wrong_length(key, N, array->size());
        std::array<double, N> out{};
        for (std::size_t i = 0; i < N; ++i) out[i] = number_of(key, (*array)[i]);
        return out;
    }

 private:
    const nlohmann::json* find(const char* key) const;
    const nlohmann::json* array_of(const char* key) const;
    std::uint64_t whole_of(const char* key, const nlohmann::json& value) const;
    double number_of(const char* key, const nlohmann::json& value) const;
    reference::Error expected(const char* key, const char* what, const nlohmann::json& found) const;
    reference::Error wrong_length(const char* key, std::size_t wanted, std::size_t found) const;

    const nlohmann::json* value_;
    std::string place_;
};

}  // namespace scotty::scenes
