#include "verify/images/image_read.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "verify/capture/capture.h"
#include "verify/capture/npy.h"
#include "verify/images/srgb.h"

namespace scotty::verify {
namespace {

namespace fs = std::filesystem;
using reference::Error;
using Channels = std::array<std::size_t, 3>;

/// 8192 x 8192; more is a mistake, or a header made to exhaust memory.
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 26;

std::unique_ptr<OIIO::ImageInput> open(const std::string& path) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw Error::bad_input(path, "no such file");
    if (!fs::is_regular_file(path, ignored)) {
        throw Error::bad_input(path, "expected an image file, found a folder");
    }
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1);  // colours not multiplied by alpha
    auto input = OIIO::ImageInput::open(path, &wishes);
    if (!input) throw Error::bad_input(path, "cannot be read as an image: " + OIIO::geterror());
    return input;
}

void expect_whole_flat_image(const OIIO::ImageSpec& spec, const std::string& path) {
    if (spec.deep) throw Error::bad_input(path, "expected a flat image, found a deep one");
    if (spec.depth > 1) throw Error::bad_input(path, "expected a flat image, found a volume");
    const bool whole = spec.x == spec.full_x && spec.y == spec.full_y &&
                       spec.width == spec.full_width && spec.height == spec.full_height;
    if (!whole) {
        throw Error::bad_input(
            path, fmt::format("expected a whole picture, found pixels for {}x{} at ({}, {}) of "
                              "{}x{} at ({}, {}): write it without a crop",
                              spec.width, spec.height, spec.x, spec.y, spec.full_width,
                              spec.full_height, spec.full_x, spec.full_y));
    }
    const std::uint64_t pixels = std::uint64_t(spec.width) * std::uint64_t(spec.height);
    if (spec.width <= 0 || spec.height <= 0 || pixels > kMostPixels) {
        throw Error::bad_input(path, fmt::format("expected 1 to {} pixels, found {}x{}",
                                                 kMostPixels, spec.width, spec.height));
    }
}

/// Finds the three channels; returns false if none is there, and throws if only some are.
bool find_channels(const OIIO::ImageSpec& spec, const std::array<std::string, 3>& names,
                   const std::string& path, Channels& found) {
    std::size_t count = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const int index = spec.channelindex(names[c]);
        if (index < 0) continue;
        found[c] = static_cast<std::size_t>(index);
        ++count;
    }
    if (count != 0 && count != 3) {
        throw Error::bad_input(
            path, fmt::format("expected all of the channels {}, found {}", fmt::join(names, ", "),
                              fmt::join(spec.channelnames, ", ")));
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

std::vector<std::string> layers_of(const OIIO::ImageSpec& spec) {
    std::vector<std::string> layers;
    for (const std::string& channel : spec.channelnames) {
        const std::string layer = layer_of(channel);
        const bool known = std::find(layers.begin(), layers.end(), layer) != layers.end();
        if (!layer.empty() && !known) layers.push_back(layer);
    }
    return layers;
}

Channels color_channels(const OIIO::ImageSpec& spec, const std::string& prefix,
                        const std::string& path) {
    Channels found{};
    if (find_channels(spec, {prefix + "R", prefix + "G", prefix + "B"}, path, found)) return found;
    const int grey = spec.channelindex(prefix + "Y");
    if (grey < 0) {
        const std::vector<std::string> layers = layers_of(spec);
        throw Error::bad_input(
            path,
            fmt::format("expected the channels {0}R, {0}G, {0}B (or {0}Y), found {1}{2}", prefix,
                        fmt::join(spec.channelnames, ", "),
                        layers.empty() ? "" : "; choose a layer with --layer " + layers.front()));
    }
    found.fill(static_cast<std::size_t>(grey));
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
double decoding_power(const OIIO::ImageSpec& spec) {
    if (spec.format.is_floating_point()) return kLinear;
    if (is_linear(spec.get_string_attribute("oiio:ColorSpace"))) return kLinear;
    const auto gamma = static_cast<double>(spec.get_float_attribute("oiio:Gamma"));
    const bool is_a_power = gamma > 0.0 && std::isfinite(gamma) && std::abs(gamma - 2.2) > 0.01;
    return is_a_power ? gamma : kSrgb;
}

ImageAttributes own_attributes(const OIIO::ImageSpec& spec) {
    ImageAttributes attributes;
    for (const OIIO::ParamValue& value : spec.extra_attribs) {
        const std::string name = value.name().string();
        if (name.rfind("scotty:", 0) == 0) attributes[name] = value.get_string();
    }
    return attributes;
}

std::uint64_t count_of(const OIIO::ImageSpec& spec, const char* name, int otherwise,
                       const std::string& path) {
    const int count = spec.get_int_attribute(name, otherwise);
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

std::string part_name(const OIIO::ImageSpec& spec, int index) {
    const std::string name = spec.get_string_attribute("oiio:subimagename");
    return name.empty() ? std::to_string(index) : name;
}

/// Moves `input` to the chosen part, and notes the others' names.
void choose_part(OIIO::ImageInput& input, const ImageChoice& choice, const std::string& path,
                 std::vector<std::string>& not_read) {
    std::vector<std::string> names;
    int chosen = choice.part.empty() ? 0 : -1;
    for (int i = 0; input.seek_subimage(i, 0); ++i) {
        names.push_back(part_name(input.spec(), i));
        if (chosen < 0 && (names.back() == choice.part || std::to_string(i) == choice.part)) {
            chosen = i;
        }
    }
    (void)input.geterror();  // clears it: having no further part is no error
    if (chosen < 0) {
        throw Error::bad_input(path, fmt::format("has no part '{}'; its parts are {}", choice.part,
                                                 fmt::join(names, ", ")));
    }
    if (!input.seek_subimage(chosen, 0)) {
        throw Error::bad_input(path, "is damaged or cut short: " + input.geterror());
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (static_cast<int>(i) != chosen) not_read.push_back("part '" + names[i] + "'");
    }
}

ReadImage read_file(const std::string& path, const ImageChoice& choice) {
    ReadImage read;
    const auto input = open(path);
    choose_part(*input, choice, path, read.not_read);
    const OIIO::ImageSpec spec = input->spec();
    expect_whole_flat_image(spec, path);
    for (const std::string& layer : layers_of(spec)) {
        if (layer != choice.layer) read.not_read.push_back("layer '" + layer + "'");
    }
    const std::string prefix = choice.layer.empty() ? std::string() : choice.layer + ".";
    const Channels color = color_channels(spec, prefix, path);
    Channels variance{};
    const bool noisy =
        find_channels(spec, {prefix + "variance.R", prefix + "variance.G", prefix + "variance.B"},
                      path, variance);

    const auto channels = static_cast<std::size_t>(spec.nchannels);
    std::vector<float> values(static_cast<std::size_t>(spec.width) *
                              static_cast<std::size_t>(spec.height) * channels);
    if (!input->read_image(input->current_subimage(), 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT,
                           values.data())) {
        throw Error::bad_input(path, "is damaged or cut short: " + input->geterror());
    }
    read.encoding = spec.format.c_str();
    read.attributes = own_attributes(spec);
    read.image.width = static_cast<std::uint32_t>(spec.width);
    read.image.height = static_cast<std::uint32_t>(spec.height);
    read.image.mean = extract(values, channels, color, decoding_power(spec));
    if (noisy) read.image.variance = extract(values, channels, variance, kLinear);
    read.image.samples = count_of(spec, "scotty:samples", 0, path);
    read.image.paths_per_sample = count_of(spec, "scotty:paths_per_sample", 1, path);
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

/// What `scotty-gpu run --image X.npy` writes beside it: X.variance.npy, and the samples in X.json.
void read_noise_beside(const std::string& path, ReadImage& read) {
    const fs::path variance = fs::path(path).replace_extension(".variance.npy");
    const fs::path about = fs::path(path).replace_extension(".json");
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
    read.image.samples = unsigned_member(about.string(), read_json(about), "samples", 1u << 20);
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
        const BufferRecord* image = stage->output("filtered");
        if (image == nullptr) image = stage->output("image");
        if (image == nullptr) continue;
        const reference::OwnedBuffer buffer = capture.load(*stage, *image);
        const auto* first = reinterpret_cast<const float*>(buffer.bytes.data());
        ReadImage read =
            from_array({first, buffer.bytes.size() / sizeof(float)}, p.image_width, p.image_height);
        read.image.samples = p.spp;
        const BufferRecord* variance = stage->output("variance");
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
