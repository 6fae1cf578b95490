#include "verify/golden_image.h"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>
#include <vector>

#include "reference/assert.h"
#include "reference/error.h"

namespace scotty::verify {

namespace fs = std::filesystem;
using reference::Error;

namespace {

constexpr std::array<const char*, 3> kMeans{"R", "G", "B"};
constexpr std::array<const char*, 3> kVariances{"variance.R", "variance.G", "variance.B"};
constexpr const char* kPrefix = "scotty:";
constexpr const char* kSamples = "scotty:samples";

struct Unfinished {
    fs::path path;
    ~Unfinished() {
        std::error_code ignored;
        fs::remove(path, ignored);
    }
};

OIIO::ImageSpec spec_of(const MeasuredImage& image, const Provenance& provenance) {
    const int channels = image.variance.empty() ? 3 : 6;
    OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), channels,
                         OIIO::TypeDesc::FLOAT);
    spec.channelnames.assign(kMeans.begin(), kMeans.end());
    if (channels == 6) {
        spec.channelnames.insert(spec.channelnames.end(), kVariances.begin(), kVariances.end());
    }
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "Linear");
    spec.attribute("DateTime", "1970:01:01 00:00:00");  // else the time of writing
    for (const auto& [name, value] : provenance) spec.attribute(kPrefix + name, value);
    if (image.samples != 0) {
        spec.attribute(kSamples, static_cast<int>(image.samples));
    }
    return spec;
}

/// Where each of three channels lies; empty where one is missing.
std::vector<std::size_t> find_channels(const OIIO::ImageSpec& spec,
                                       const std::array<const char*, 3>& names) {
    std::vector<std::size_t> places;
    for (const char* name : names) {
        const auto found = std::find(spec.channelnames.begin(), spec.channelnames.end(), name);
        if (found == spec.channelnames.end()) return {};
        places.push_back(static_cast<std::size_t>(found - spec.channelnames.begin()));
    }
    return places;
}

std::vector<Color> pick(const std::vector<float>& values, std::size_t channels,
                        const std::vector<std::size_t>& places) {
    std::vector<Color> colors(places.empty() ? 0 : values.size() / channels);
    for (std::size_t pixel = 0; pixel < colors.size(); ++pixel) {
        for (std::size_t c = 0; c < 3; ++c) {
            colors[pixel][c] = values[pixel * channels + places[c]];
        }
    }
    return colors;
}

}  // namespace

void write_golden_image(const MeasuredImage& image, const Provenance& provenance,
                        const fs::path& file) {
    const std::size_t pixels = std::size_t{image.width} * image.height;
    SCOTTY_ASSERT(image.mean.size(), ==, pixels);
    std::vector<float> values;
    for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
        for (const double value : image.mean[pixel]) values.push_back(static_cast<float>(value));
        if (image.variance.empty()) continue;
        for (const double value : image.variance[pixel]) {
            values.push_back(static_cast<float>(value));
        }
    }
    // The extension stays last: OpenImageIO goes by it.
    const Unfinished unfinished{file.parent_path() / (file.stem().string() + ".unfinished.exr")};
    const auto output = OIIO::ImageOutput::create(unfinished.path.string());
    if (!output) throw Error::bad_input(file.string(), "cannot be written: " + OIIO::geterror());
    if (!output->open(unfinished.path.string(), spec_of(image, provenance)) ||
        !output->write_image(OIIO::TypeDesc::FLOAT, values.data()) || !output->close()) {
        throw Error::bad_input(file.string(), "cannot be written: " + output->geterror());
    }
    std::error_code error;
    fs::rename(unfinished.path, file, error);
    if (error) throw Error::bad_input(file.string(), "cannot be written: " + error.message());
}

GoldenImageFile read_golden_image(const fs::path& file) {
    const auto input = OIIO::ImageInput::open(file.string());
    if (!input) {
        throw Error::bad_input(file.string(), "cannot be read as an image: " + OIIO::geterror());
    }
    const OIIO::ImageSpec spec = input->spec();
    const auto channels = static_cast<std::size_t>(spec.nchannels);
    std::vector<float> values(static_cast<std::size_t>(spec.image_pixels()) * channels);
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data())) {
        throw Error::bad_input(file.string(), "cannot be read: " + input->geterror());
    }
    const std::vector<std::size_t> means = find_channels(spec, kMeans);
    if (means.empty()) {
        throw Error::bad_input(file.string(), fmt::format("expected channels R, G and B, found {}",
                                                          fmt::join(spec.channelnames, ", ")));
    }
    GoldenImageFile out;
    out.image.width = static_cast<std::uint32_t>(spec.width);
    out.image.height = static_cast<std::uint32_t>(spec.height);
    out.image.mean = pick(values, channels, means);
    out.image.variance = pick(values, channels, find_channels(spec, kVariances));
    for (const auto& attribute : spec.extra_attribs) {
        const std::string name = attribute.name().string();
        if (!name.starts_with(kPrefix) || name == kSamples) continue;
        out.provenance[name.substr(std::string(kPrefix).size())] = attribute.get_string();
    }
    out.image.samples = static_cast<std::uint64_t>(std::max(0, spec.get_int_attribute(kSamples)));
    return out;
}

}  // namespace scotty::verify
