#include "scenes/gltf_accessor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

namespace scotty::scenes {

/// Elements that differ from those of the view, or from zero.
struct GltfAccessor::Sparse {
    std::vector<std::uint32_t> indices;  ///< rising
    GltfAccessor values;
};

namespace {

constexpr std::uint64_t kMostElements = std::numeric_limits<std::uint32_t>::max();
/// Where no bytes of the file stand behind the count.
constexpr std::uint64_t kMostWithoutView = 16'000'000;

unsigned components_of(const GltfObject& object) {
    constexpr std::array<std::pair<const char*, unsigned>, 7> kTypes = {{{"SCALAR", 1},
                                                                         {"VEC2", 2},
                                                                         {"VEC3", 3},
                                                                         {"VEC4", 4},
                                                                         {"MAT2", 4},
                                                                         {"MAT3", 9},
                                                                         {"MAT4", 16}}};
    const std::string type = object.text("type", "");
    for (const auto& [name, components] : kTypes) {
        if (type == name) return components;
    }
    throw object.error(fmt::format(
        "type: expected SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4, found '{}'", type));
}

}  // namespace

void GltfAccessor::set_component(const GltfObject& object, std::uint64_t type) {
    constexpr std::array<unsigned, 7> kSizes = {1, 1, 2, 2, 0, 4, 4};  // from 5120 on
    component_type_ = type;
    component_size_ = type >= 5120 && type <= kFloat ? kSizes[type - 5120] : 0;
    if (component_size_ != 0) return;
    throw object.error(
        fmt::format("componentType: expected one of 5120 to 5123, 5125 and 5126, found {}", type));
}

void GltfAccessor::set_bytes(const GltfView& view, std::uint64_t offset) {
    const std::uint64_t size = std::uint64_t{component_size_} * components_;
    stride_ = view.stride == 0 ? size : view.stride;
    if (stride_ < size) {
        throw error(fmt::format("elements of {} bytes overlap: the view's byteStride is {}", size,
                                stride_));
    }
    const std::uint64_t end = offset + (count_ - 1) * stride_ + size;
    if (end > view.bytes.size()) {
        throw error(fmt::format("{} elements end at byte {}, the view has {}", count_, end,
                                view.bytes.size()));
    }
    bytes_ = view.bytes.part(offset, end - offset);
    has_view_ = true;
}

GltfAccessor::GltfAccessor(GltfDocument& document, std::uint64_t index, const GltfObject& user) {
    const GltfObject object = document.root().at("accessors", index, user);
    place_ = object.place();
    count_ = object.required_whole("count");
    if (count_ == 0 || count_ > kMostElements) {
        throw error(fmt::format("count: expected 1 to {}, found {}", kMostElements, count_));
    }
    set_component(object, object.required_whole("componentType"));
    components_ = components_of(object);
    is_normalised_ = object.flag("normalized", false);
    stride_ = std::uint64_t{component_size_} * components_;
    if (const auto view = object.whole("bufferView")) {
        set_bytes(document.view(*view, object), object.whole("byteOffset", 0));
    } else if (count_ > kMostWithoutView) {
        throw error(fmt::format("{} elements without a bufferView, at most {} are supported",
                                count_, kMostWithoutView));
    }
    if (object.has("sparse")) read_sparse(document, object);
}

GltfAccessor::GltfAccessor(std::string place, std::string bytes, unsigned float_components)
    : place_(std::move(place)), components_(std::max(1u, float_components)) {
    if (float_components == 0) component_type_ = 5125;
    count_ = bytes.size() / 4 / components_;
    set_bytes({GltfBytes::of_memory(std::move(bytes)), 0}, 0);
}

GltfAccessor::GltfAccessor(GltfDocument& document, const GltfObject& place, std::uint64_t count,
                           std::uint64_t component_type, unsigned components)
    : place_(place.place()), count_(count), components_(components) {
    set_component(place, component_type);
    set_bytes(document.view(place.required_whole("bufferView"), place),
              place.whole("byteOffset", 0));
}

void GltfAccessor::read_sparse(GltfDocument& document, const GltfObject& object) {
    const GltfObject sparse = *object.object("sparse");
    const std::uint64_t count = sparse.required_whole("count");
    const auto places = sparse.object("indices");
    const auto values = sparse.object("values");
    if (!places || !values || count == 0 || count > count_) {
        throw sparse.error(
            fmt::format("expected indices and values, 1 to {} of them, found {}", count_, count));
    }
    const GltfAccessor numbers(document, *places, count, places->required_whole("componentType"),
                               1);
    numbers.expect_indices();
    GltfAccessor replaced(document, *values, count, component_type_, components_);
    replaced.is_normalised_ = is_normalised_;
    // They are read one by one.
    replaced.bytes_ = GltfBytes::of_memory(replaced.bytes_.all());
    std::vector<std::uint32_t> indices(count);
    numbers.read(0, count, indices.data());
    for (std::size_t i = 0; i < count; ++i) {
        if (indices[i] < count_ && (i == 0 || indices[i] > indices[i - 1])) continue;
        throw places->error(fmt::format("index {}: expected rising numbers below {}, found {}", i,
                                        count_, indices[i]));
    }
    sparse_ = std::make_shared<const Sparse>(Sparse{std::move(indices), std::move(replaced)});
}

void GltfAccessor::expect_components(unsigned components) const {
    if (components_ == components) return;
    throw error(fmt::format("expected {} components, found {}", components, components_));
}

void GltfAccessor::expect_indices() const {
    const bool is_unsigned =
        component_type_ == 5121 || component_type_ == 5123 || component_type_ == 5125;
    if (is_unsigned && components_ == 1 && !is_normalised_ && stride_ == component_size_) return;
    throw error("no vertex indices: expected SCALAR unsigned whole numbers without a byteStride");
}

template <class From, class To>
void GltfAccessor::convert(const char* from, std::uint64_t count, To* to) const {
    constexpr auto kLargest = static_cast<float>(std::numeric_limits<From>::max());
    for (std::uint64_t i = 0; i < count; ++i, from += stride_) {
        for (unsigned k = 0; k < components_; ++k) {
            From value{};
            std::memcpy(&value, from + k * sizeof(From), sizeof(From));
            if constexpr (std::is_same_v<To, float> && !std::is_same_v<From, float>) {
                const auto number = static_cast<float>(value);
                *to++ = is_normalised_ ? std::max(number / kLargest, -1.0f) : number;
            } else if constexpr (std::is_integral_v<From>) {
                *to++ = static_cast<To>(static_cast<std::make_unsigned_t<From>>(value));
            } else {
                *to++ = static_cast<To>(value);
            }
        }
    }
}

template <class To>
void GltfAccessor::read_as(std::uint64_t first, std::uint64_t count, To* to) const {
    if (count == 0) return;
    if (!has_view_) {
        std::fill_n(to, count * components_, To{});
    } else {
        std::vector<char> raw((count - 1) * stride_ + std::uint64_t{component_size_} * components_);
        bytes_.read(first * stride_, raw.size(), raw.data());
        switch (component_type_) {
            case 5120:
                convert<std::int8_t>(raw.data(), count, to);
                break;
            case 5121:
                convert<std::uint8_t>(raw.data(), count, to);
                break;
            case 5122:
                convert<std::int16_t>(raw.data(), count, to);
                break;
            case 5123:
                convert<std::uint16_t>(raw.data(), count, to);
                break;
            case 5125:
                convert<std::uint32_t>(raw.data(), count, to);
                break;
            default:
                if constexpr (std::is_same_v<To, float>) convert<float>(raw.data(), count, to);
        }
    }
    if (!sparse_) return;
    const auto& indices = sparse_->indices;
    for (auto at = std::lower_bound(indices.begin(), indices.end(), first);
         at != indices.end() && *at < first + count; ++at) {
        sparse_->values.read(static_cast<std::uint64_t>(at - indices.begin()), 1,
                             to + (*at - first) * components_);
    }
}

void GltfAccessor::read(std::uint64_t first, std::uint64_t count, float* to) const {
    read_as(first, count, to);
}

void GltfAccessor::read(std::uint64_t first, std::uint64_t count, std::uint32_t* to) const {
    if (is_float()) throw error("expected whole numbers, found floats");
    read_as(first, count, to);
}

}  // namespace scotty::scenes
