#include "verify/images/image_read.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "verify/capture/capture.h"
#include "verify/capture/npy.h"
#include "verify/capture/picture_arrays.h"
#include "verify/images/image_library.h"
#include "verify/images/srgb.h"

namespace scotty::verify {

namespace buffers = reference::buffers;
namespace {

namespace fs = std::filesystem;
using reference::Error;
using Channels = std::array<std::size_t, 3>;

/// 8192 x 8192; more is a mistake, or a header made to exhaust memory.
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 26;

std::unique_ptr<ImageInput> open(const std::string& path) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw Error::bad_input(path, "no such file");
    if (!fs::is_regular_file(path, ignored)) {
        throw Error::bad_input(path, "expected an image file, found a folder");
    }
    std::string why;
    auto input = image_module().open(path, why);
    if (!input) throw Error::bad_input(path, why);
    return input;
}

void expect_whole_flat_image(const ImagePart& part, const std::string& path) {
    if (part.deep) throw Error::bad_input(path, "expected a flat image, found a deep one");
    if (part.depth > 1) throw Error::bad_input(path, "expected a flat image, found a volume");
    const PixelWindow& pixels = part.pixels;
    const PixelWindow& picture = part.picture;
    if (pixels != picture) {
        throw Error::bad_input(
            path, fmt::format("expected a whole picture, found pixels for {}x{} at ({}, {}) of "
                              "{}x{} at ({}, {}): write it without a crop",
                              pixels.width, pixels.height, pixels.x, pixels.y, picture.width,
                              picture.height, picture.x, picture.y));
    }
    const std::uint64_t count = std::uint64_t(pixels.width) * std::uint64_t(pixels.height);
    if (pixels.width <= 0 || pixels.height <= 0 || count > kMostPixels) {
        throw Error::bad_input(path, fmt::format("expected 1 to {} pixels, found {}x{}",
                                                 kMostPixels, pixels.width, pixels.height));
    }
}

std::optional<std::size_t> find_channel(const ImagePart& part, const std::string& name) {
    const auto at = std::find(part.channels.begin(), part.channels.end(), name);
    if (at == part.channels.end()) return std::nullopt;
    return static_cast<std::size_t>(at - part.channels.begin());
}

/// Finds the three channels; returns false if none is there, and throws if only some are.
bool find_channels(const ImagePart& part, const std::array<std::string, 3>& names,
                   const std::string& path, Channels& found) {
    std::size_t count = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const auto index = find_channel(part, names[c]);
        if (!index) continue;
        found[c] = *index;
        ++count;
    }
    if (count != 0 && count != 3) {
        throw Error::bad_input(
            path, fmt::format("expected all of the channels {}, found {}", fmt::join(names, ", "),
                              fmt::join(part.channels, ", ")));
    }
    return count == 3;
}

/// "diffuse" of "diffuse.R"; empty for a channel without a layer, as our variances are.
std::string layer_of(const std::string& channel) {
    const std::size_t dot = channel.rfind('.');
    std::string layer = dot == std::string::npos ? std::string() : channel.substr(0, dot);
    if (layer == "variance") return {};
    if (layer.ends_with(".variance")) layer.resize(layer.size() - sizeof "variance");
    return layer;
}

std::vector<std::string> layers_of(const ImagePart& part) {
    std::vector<std::string> layers;
    for (const std::string& channel : part.channels) {
        const std::string layer = layer_of(channel);
        const bool known = std::find(layers.begin(), layers.end(), layer) != layers.end();
        if (!layer.empty() && !known) layers.push_back(layer);
    }
    return layers;
}

Channels color_channels(const ImagePart& part, const std::string& prefix, const std::string& path) {
    Channels found{};
    if (find_channels(part, {prefix + "R", prefix + "G", prefix + "B"}, path, found)) return found;
    const auto grey = find_channel(part, prefix + "Y");
    if (!grey) {
        const std::vector<std::string> layers = layers_of(part);
        throw Error::bad_input(
            path,
            fmt::format("expected the channels {0}R, {0}G, {0}B (or {0}Y), found {1}{2}", prefix,
                        fmt::join(part.channels, ", "),
                        layers.empty() ? "" : "; choose a layer with --layer " + layers.front()));
    }
    found.fill(*grey);
    return found;
}

bool is_linear(std::string_view color_space) {
    const auto same = [&](std::string_view word) {
        return std::equal(
            color_space.begin(), color_space.end(), word.begin(), word.end(),
            [](unsigned char a, unsigned char b) { return std::tolower(a) == std::tolower(b); });
    };
    return same("linear") || same("scene_linear") || same("lin_srgb");
}

/// The power that values are raised to; kSrgb stands for the curve of sRGB.
constexpr double kSrgb = 0.0;
constexpr double kLinear = 1.0;

/// OpenImageIO spells the colour space differently from format to format, and gives a gamma where
/// the file has one. Programs that mean sRGB write a gamma of 2.2, too.
double decoding_power(const ImagePart& part) {
    if (part.floating_point || is_linear(part.color_space)) return kLinear;
    const auto gamma = static_cast<double>(part.gamma);
    const bool is_a_power = gamma > 0.0 && std::isfinite(gamma) && std::abs(gamma - 2.2) > 0.01;
    return is_a_power ? gamma : kSrgb;
}

std::uint64_t count_of(const ImagePart& part, const char* name, int otherwise,
                       const std::string& path) {
    const auto found = part.counts.find(name);
    const int count = found == part.counts.end() ? otherwise : found->second;
    if (count < otherwise) {
        throw Error::bad_input(path, fmt::format("attribute {}: expected {} or more, found {}",
                                                 name, otherwise, count));
    }
    return static_cast<std::uint64_t>(count);
}

std::vector<Color> extract(const std::vector<float>& values, std::size_t channels,
                           const Channels& which, double power) {
    std::vector<Color> colors(values.size() / channels);
    for (std::size_t i = 0; i < colors.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const double value = values[i * channels + which[c]];
            colors[i][c] = power == kSrgb     ? srgb_decode(value)
                           : power == kLinear ? value
                                              : std::pow(value, power);
        }
    }
    return colors;
}

/// A truth value is no power.
std::vector<Color> extract(const std::vector<float>&, std::size_t, const Channels&, bool) = delete;

/// Moves `input` to the chosen part, and notes the others' names.
ImagePart choose_part(ImageInput& input, const ImageChoice& choice, const std::string& path,
                      std::vector<std::string>& not_read) {
    std::vector<std::string> names;
    int chosen = choice.part.empty() ? 0 : -1;
    for (int i = 0; const auto part = input.part(i); ++i) {
        names.push_back(part->name.empty() ? std::to_string(i) : part->name);
        if (chosen < 0 && (names.back() == choice.part || std::to_string(i) == choice.part)) {
            chosen = i;
        }
    }
    if (chosen < 0) {
        throw Error::bad_input(path, fmt::format("has no part '{}'; its parts are {}", choice.part,
                                                 fmt::join(names, ", ")));
    }
    std::optional<ImagePart> part = input.part(chosen);
    if (!part) throw Error::bad_input(path, "is damaged or cut short");
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (static_cast<int>(i) != chosen) not_read.push_back("part '" + names[i] + "'");
    }
    return *part;
}

ReadImage read_file(const std::string& path, const ImageChoice& choice) {
    ReadImage read;
    const auto input = open(path);
    const ImagePart part = choose_part(*input, choice, path, read.not_read);
    expect_whole_flat_image(part, path);
    for (const std::string& layer : layers_of(part)) {
        if (layer != choice.layer) read.not_read.push_back("layer '" + layer + "'");
    }
    const std::string prefix = choice.layer.empty() ? std::string() : choice.layer + ".";
    const Channels color = color_channels(part, prefix, path);
    Channels variance{};
    const bool noisy =
        find_channels(part, {prefix + "variance.R", prefix + "variance.G", prefix + "variance.B"},
                      path, variance);

    const std::size_t channels = part.channels.size();
    std::vector<float> values;
    const std::string why = input->read(values);
    if (!why.empty()) throw Error::bad_input(path, why);
    read.encoding = part.encoding;
    read.attributes = part.attributes;
    read.image.width = static_cast<std::uint32_t>(part.pixels.width);
    read.image.height = static_cast<std::uint32_t>(part.pixels.height);
    read.image.mean = extract(values, channels, color, decoding_power(part));
    if (noisy) read.image.variance = extract(values, channels, variance, kLinear);
    read.image.samples = count_of(part, "scotty:samples", 0, path);
    read.image.paths_per_sample = count_of(part, "scotty:paths_per_sample", 1, path);
    return read;
}

/// Radiance from an array of numbers.
ReadImage from_array(std::span<const float> values, std::size_t width, std::size_t height) {
    ReadImage read;
    read.encoding = "float";
    read.image.width = static_cast<std::uint32_t>(width);
    read.image.height = static_cast<std::uint32_t>(height);
    read.image.mean = extract({values.begin(), values.end()}, 3, {0, 1, 2}, kLinear);
    return read;
}

/// What write_picture_arrays() puts beside it.
void read_noise_beside(const std::string& path, ReadImage& read) {
    const fs::path variance = variance_file(path);
    const fs::path about = about_file(path);
    std::error_code ignored;
    if (!fs::exists(variance, ignored) || !fs::exists(about, ignored)) return;
    const NpyArray array = read_npy(variance);
    const std::vector<std::size_t> shape{read.image.height, read.image.width, 3};
    if (array.type != reference::ElementType::float32 || array.shape != shape) {
        throw Error::bad_input(
            variance.string(),
            fmt::format("expected float32 {}, as the image beside it, found {} {}",
                        shape_text(shape), verify::to_string(array.type), shape_text(array.shape)));
    }
    const auto values = array.get<float>();
    read.image.variance = extract({values.begin(), values.end()}, 3, {0, 1, 2}, kLinear);
    const nlohmann::json facts = read_json(about);
    read.image.samples = unsigned_member(about.string(), facts, "samples", 1u << 20);
    for (const auto& [name, value] : facts.items()) {
        read.attributes["scotty:" + name] =
            value.is_string() ? value.get<std::string>() : value.dump();
    }
}

ReadImage read_array(const std::string& path) {
    const NpyArray array = read_npy(path);
    const bool is_picture = array.type == reference::ElementType::float32 &&
                            array.shape.size() == 3 && array.shape[2] == 3 && array.shape[0] > 0 &&
                            array.shape[1] > 0 && array.shape[0] * array.shape[1] <= kMostPixels;
    if (!is_picture) {
        throw Error::bad_input(path,
                               fmt::format("expected float32 [height, width, 3], found {} {}",
                                           verify::to_string(array.type), shape_text(array.shape)));
    }
    ReadImage read = from_array(array.get<float>(), array.shape[1], array.shape[0]);
    read_noise_beside(path, read);
    return read;
}

/// The image that a captured run ended with.
ReadImage read_capture(const std::string& path) {
    const Capture capture = Capture::open(path);
    const reference::PipelineParameters& p = capture.header().parameters;
    for (auto stage = capture.stages().rbegin(); stage != capture.stages().rend(); ++stage) {
        const BufferRecord* image = stage->output(buffers::filtered.name);
        if (image == nullptr) image = stage->output(buffers::image.name);
        if (image == nullptr) continue;
        const reference::OwnedBuffer buffer = capture.load(*stage, *image);
        const auto* first = reinterpret_cast<const float*>(buffer.bytes.data());
        ReadImage read =
            from_array({first, buffer.bytes.size() / sizeof(float)}, p.image_width, p.image_height);
        read.image.samples = p.spp;
        const BufferRecord* variance = stage->output(buffers::variance.name);
        if (variance == nullptr || p.spp == 1) return read;
        const reference::OwnedBuffer of_mean = capture.load(*stage, *variance);
        const auto* of_first = reinterpret_cast<const float*>(of_mean.bytes.data());
        read.image.variance = extract({of_first, of_first + of_mean.bytes.size() / sizeof(float)},
                                      3, {0, 1, 2}, kLinear);
        return read;
    }
    throw Error::bad_input(path, "this capture has no image: capture reconstruct_image too");
}

}  // namespace

ReadImage read_image(const std::string& path, const ImageChoice& choice) {
    const bool chooses = !choice.part.empty() || !choice.layer.empty();
    const bool array = fs::path(path).extension() == ".npy";
    std::error_code ignored;
    const bool folder = fs::exists(fs::path(path) / "index.json", ignored);
    if (chooses && (array || folder)) {
        throw Error::bad_input(path, "has no parts and layers to choose from");
    }
    if (array) return read_array(path);
    return folder ? read_capture(path) : read_file(path, choice);
}

bool is_image_path(const std::string& path) {
    std::string extension = fs::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char letter) {
        return static_cast<char>(letter >= 'A' && letter <= 'Z' ? letter - 'A' + 'a' : letter);
    });
    static constexpr std::array kExtensions{".exr", ".npy",  ".png", ".hdr",  ".pfm",
                                            ".tif", ".tiff", ".jpg", ".jpeg", ".bmp",
                                            ".ppm", ".tga",  ".webp"};
    return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

}  // namespace scotty::verify
