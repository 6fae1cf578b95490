#include "scenes/gltf_object.h"

#include <fmt/format.h>

#include <cmath>

namespace scotty::scenes {

using nlohmann::json;
using reference::Error;

namespace {

constexpr double kLargestWhole = 281474976710656.0;  // 2^48: sums and products with strides fit

/// A value as the file has it, shortened, for messages.
std::string json_text(const json& value) {
    std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
    if (text.size() > 40) text = text.substr(0, 37) + "...";
    return text;
}

}  // namespace

GltfObject::GltfObject(const json& value, const std::string& place) : value_(&value) {
    if (!value.is_object()) {
        throw Error::bad_input(
            place,
            fmt::format("not glTF as specified: expected an object, found {}", json_text(value)));
    }
    const auto name = value.find("name");
    const bool named =
        name != value.end() && name->is_string() && !name->get_ref<const std::string&>().empty();
    place_ = named ? fmt::format("{} ('{}')", place, name->get_ref<const std::string&>()) : place;
}

Error GltfObject::expected(const char* key, const char* what, const json& found) const {
    return error(fmt::format("not glTF as specified: {}: expected {}, found {}", key, what,
                             json_text(found)));
}

Error GltfObject::wrong_length(const char* key, std::size_t wanted, std::size_t found) const {
    return error(fmt::format("not glTF as specified: {}: expected {} numbers, found {}", key,
                             wanted, found));
}

const json* GltfObject::find(const char* key) const {
    const auto found = value_->find(key);
    return found == value_->end() ? nullptr : &*found;
}

const json* GltfObject::array_of(const char* key) const {
    const json* found = find(key);
    if (found != nullptr && !found->is_array()) throw expected(key, "an array", *found);
    return found;
}

std::vector<std::string> GltfObject::keys() const {
    std::vector<std::string> out;
    for (const auto& member : value_->items()) out.push_back(member.key());
    return out;
}

std::optional<GltfObject> GltfObject::object(const char* key) const {
    const json* found = find(key);
    if (found == nullptr) return std::nullopt;
    return GltfObject(*found, fmt::format("{}: {}", place_, key));
}

std::optional<GltfObject> GltfObject::extension(const char* name) const {
    const auto extensions = object("extensions");
    return extensions ? extensions->object(name) : std::nullopt;
}

std::size_t GltfObject::length(const char* key) const {
    const json* array = array_of(key);
    return array == nullptr ? 0 : array->size();
}

std::vector<GltfObject> GltfObject::objects(const char* key) const {
    std::vector<GltfObject> out;
    const std::size_t count = length(key);
    for (std::size_t i = 0; i < count; ++i) out.push_back(at(key, i, *this));
    return out;
}

GltfObject GltfObject::at(const char* key, std::uint64_t index, const GltfObject& user) const {
    const json* array = array_of(key);
    const std::size_t count = array == nullptr ? 0 : array->size();
    if (index >= count) {
        throw user.error(
            fmt::format("{}[{}] is out of range, the file has {} of them", key, index, count));
    }
    return {(*array)[index], fmt::format("{}: {}[{}]", place_, key, index)};
}

std::uint64_t GltfObject::whole_of(const char* key, const json& value) const {
    // Some exporters write 3.0 for 3.
    const double number = value.is_number() ? value.get<double>() : -1.0;
    if (!(number >= 0.0 && number <= kLargestWhole) || number != std::floor(number)) {
        throw expected(key, "a whole number", value);
    }
    return static_cast<std::uint64_t>(number);
}

double GltfObject::number_of(const char* key, const json& value) const {
    if (!value.is_number()) throw expected(key, "a number", value);
    return value.get<double>();
}

std::optional<std::uint64_t> GltfObject::whole(const char* key) const {
    const json* found = find(key);
    return found == nullptr ? std::nullopt : std::optional(whole_of(key, *found));
}

std::uint64_t GltfObject::whole(const char* key, std::uint64_t standard) const {
    return whole(key).value_or(standard);
}

std::uint64_t GltfObject::required_whole(const char* key) const {
    const auto value = whole(key);
    if (!value) throw error(fmt::format("not glTF as specified: {} is missing", key));
    return *value;
}

std::vector<std::uint64_t> GltfObject::wholes(const char* key) const {
    std::vector<std::uint64_t> out;
    if (const json* array = array_of(key)) {
        for (const json& value : *array) out.push_back(whole_of(key, value));
    }
    return out;
}

double GltfObject::number(const char* key, double standard) const {
    const json* found = find(key);
    return found == nullptr ? standard : number_of(key, *found);
}

std::vector<double> GltfObject::numbers(const char* key) const {
    std::vector<double> out;
    if (const json* array = array_of(key)) {
        for (const json& value : *array) out.push_back(number_of(key, value));
    }
    return out;
}

std::string GltfObject::text(const char* key, const std::string& standard) const {
    const json* found = find(key);
    if (found == nullptr) return standard;
    if (!found->is_string()) throw expected(key, "text", *found);
    return found->get<std::string>();
}

std::vector<std::string> GltfObject::texts(const char* key) const {
    std::vector<std::string> out;
    if (const json* array = array_of(key)) {
        for (const json& value : *array) {
            if (!value.is_string()) throw expected(key, "texts", value);
            out.push_back(value.get<std::string>());
        }
    }
    return out;
}

bool GltfObject::flag(const char* key, bool standard) const {
    const json* found = find(key);
    if (found == nullptr) return standard;
    if (!found->is_boolean()) throw expected(key, "true or false", *found);
    return found->get<bool>();
}

}  // namespace scotty::scenes
