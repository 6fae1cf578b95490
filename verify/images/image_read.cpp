#include "verify/images/image_read.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "reference/base/error.h"
#include "verify/images/srgb.h"

namespace scotty::verify {
namespace {

namespace fs = std::filesystem;
using reference::Error;
using Channels = std::array<std::size_t, 3>;

/// 8192 x 8192: more is a mistake, or a header made to exhaust memory.
constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 26;

std::unique_ptr<OIIO::ImageInput> open(const std::string& path) {
    std::error_code ignored;
    if (!fs::exists(path, ignored)) throw Error::bad_input(path, "no such file");
    if (!fs::is_regular_file(path, ignored)) {
        throw Error::bad_input(path, "expected an image file, found a folder");
    }
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1);  // colours as they are, not times alpha
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

/// Where the three channels are; false where none of them is there, an error where only some are.
bool find_channels(const OIIO::ImageSpec& spec, const std::array<const char*, 3>& names,
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

Channels color_channels(const OIIO::ImageSpec& spec, const std::string& path) {
    Channels found{};
    if (find_channels(spec, {"R", "G", "B"}, path, found)) return found;
    const int grey = spec.channelindex("Y");
    if (grey < 0) {
        throw Error::bad_input(path, fmt::format("expected the channels R, G, B (or Y), found {}",
                                                 fmt::join(spec.channelnames, ", ")));
    }
    found.fill(static_cast<std::size_t>(grey));
    return found;
}

bool is_encoded(const OIIO::ImageSpec& spec) {
    return !spec.format.is_floating_point() &&
           spec.get_string_attribute("oiio:ColorSpace") != "Linear";
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
                           const Channels& which, bool encoded) {
    std::vector<Color> colors(values.size() / channels);
    for (std::size_t i = 0; i < colors.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const double value = values[i * channels + which[c]];
            colors[i][c] = encoded ? srgb_decode(value) : value;
        }
    }
    return colors;
}

}  // namespace

ReadImage read_image(const std::string& path) {
    const auto input = open(path);
    const OIIO::ImageSpec spec = input->spec();
    expect_whole_flat_image(spec, path);
    const Channels color = color_channels(spec, path);
    Channels variance{};
    const bool noisy =
        find_channels(spec, {"variance.R", "variance.G", "variance.B"}, path, variance);

    const auto channels = static_cast<std::size_t>(spec.nchannels);
    std::vector<float> values(static_cast<std::size_t>(spec.width) *
                              static_cast<std::size_t>(spec.height) * channels);
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data())) {
        throw Error::bad_input(path, "is damaged or cut short: " + input->geterror());
    }
    ReadImage read;
    read.encoding = spec.format.c_str();
    read.attributes = own_attributes(spec);
    read.image.width = static_cast<std::uint32_t>(spec.width);
    read.image.height = static_cast<std::uint32_t>(spec.height);
    read.image.mean = extract(values, channels, color, is_encoded(spec));
    if (noisy) read.image.variance = extract(values, channels, variance, false);
    read.image.samples = count_of(spec, "scotty:samples", 0, path);
    read.image.paths_per_sample = count_of(spec, "scotty:paths_per_sample", 1, path);
    return read;
}

bool is_image_path(const std::string& path) {
    std::string extension = fs::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char letter) {
        return static_cast<char>(letter >= 'A' && letter <= 'Z' ? letter - 'A' + 'a' : letter);
    });
    static constexpr std::array kExtensions{".exr", ".png",  ".hdr", ".pfm", ".tif", ".tiff",
                                            ".jpg", ".jpeg", ".bmp", ".ppm", ".tga", ".webp"};
    return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

}  // namespace scotty::verify
