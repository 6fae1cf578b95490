#include "verify/images/image_file.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "reference/base/assert.h"
#include "reference/base/error.h"
#include "verify/images/srgb.h"

namespace scotty::verify {

namespace fs = std::filesystem;
using reference::Error;

namespace {

std::vector<std::uint8_t> to_png_bytes(const reference::Image& image, float exposure) {
    const float scale = std::exp2(exposure);
    std::vector<std::uint8_t> bytes;
    bytes.reserve(image.pixels.size() * 3);
    for (const reference::Vec3& pixel : image.pixels) {
        for (const float value : {pixel.x, pixel.y, pixel.z}) {
            bytes.push_back(
                static_cast<std::uint8_t>(std::lround(srgb_encode(value * scale) * 255.0f)));
        }
    }
    return bytes;
}

/// Removes the file when writing fails half-way.
struct Unfinished {
    fs::path path;
    ~Unfinished() {
        std::error_code ignored;
        fs::remove(path, ignored);
    }
};

/// Makes an EXR's bytes a function of its content.
void settle_exr(OIIO::ImageSpec& spec) {
    spec.attribute("compression", "zip");
    spec.attribute("oiio:ColorSpace", "Linear");
    // Otherwise it is the time of writing.
    spec.attribute("DateTime", "1970:01:01 00:00:00");
}

void write_pixels(const OIIO::ImageSpec& spec, const void* data, const std::string& path) {
    const fs::path target(path);
    // The extension stays last, because OpenImageIO goes by it.
    const Unfinished unfinished{target.parent_path() / (target.stem().string() + ".unfinished" +
                                                        target.extension().string())};
    const auto output = OIIO::ImageOutput::create(unfinished.path.string());
    if (!output) throw Error::bad_input(path, "cannot be written: " + OIIO::geterror());
    if (!output->open(unfinished.path.string(), spec) || !output->write_image(spec.format, data) ||
        !output->close()) {
        throw Error::bad_input(path, "cannot be written: " + output->geterror());
    }
    std::error_code error;
    fs::rename(unfinished.path, target, error);
    if (error) throw Error::bad_input(path, "cannot be written: " + error.message());
}

int attribute_count(std::uint64_t count, const char* what, const std::string& path) {
    if (count > static_cast<std::uint64_t>(std::numeric_limits<int>::max())) {
        throw Error::bad_input(path, std::string("an image file holds at most 2^31 - 1 ") + what +
                                         ", found " + std::to_string(count));
    }
    return static_cast<int>(count);
}

/// Interleaves R, G, B and, if they are known, the variances.
std::vector<float> interleaved(const MeasuredImage& image) {
    std::vector<float> values;
    values.reserve(image.mean.size() * (image.variance.empty() ? 3 : 6));
    for (std::size_t i = 0; i < image.mean.size(); ++i) {
        for (const double value : image.mean[i]) values.push_back(static_cast<float>(value));
        if (image.variance.empty()) continue;
        for (const double value : image.variance[i]) values.push_back(static_cast<float>(value));
    }
    return values;
}

}  // namespace

void check_image_path(const std::string& path) {
    const std::string extension = fs::path(path).extension().string();
    if (extension != ".exr" && extension != ".png") {
        throw Error::bad_input(
            path, "expected a file name that ends in .exr or .png, found '" + extension + "'");
    }
    const fs::path folder = fs::path(path).parent_path();
    if (!folder.empty() && !fs::is_directory(folder)) {
        throw Error::bad_input(path, "the folder " + folder.string() + " does not exist");
    }
}

void write_image(const reference::Image& image, const std::string& path, float exposure) {
    check_image_path(path);
    const bool exr = fs::path(path).extension() == ".exr";
    const OIIO::TypeDesc type = exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8;
    OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), 3, type);
    if (exr) settle_exr(spec);
    const std::vector<std::uint8_t> bytes =
        exr ? std::vector<std::uint8_t>() : to_png_bytes(image, exposure);
    write_pixels(spec, exr ? static_cast<const void*>(image.pixels.data()) : bytes.data(), path);
}

void write_measured_image(const MeasuredImage& image, const std::string& path,
                          const ImageAttributes& attributes) {
    check_image_path(path);
    if (fs::path(path).extension() != ".exr") {
        throw Error::bad_input(path,
                               "expected a file name that ends in .exr: a .png has no room "
                               "for variances");
    }
    SCOTTY_ASSERT(image.mean.size(), ==, std::size_t{image.width} * image.height);
    const bool noisy = !image.variance.empty();
    OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height),
                         noisy ? 6 : 3, OIIO::TypeDesc::FLOAT);
    if (noisy) spec.channelnames = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};
    settle_exr(spec);
    for (const auto& [name, value] : attributes) spec.attribute(name, value);
    if (image.samples != 0) {
        spec.attribute("scotty:samples", attribute_count(image.samples, "samples", path));
    }
    if (image.paths_per_sample != 1) {
        spec.attribute("scotty:paths_per_sample",
                       attribute_count(image.paths_per_sample, "paths per sample", path));
    }
    write_pixels(spec, interleaved(image).data(), path);
}

}  // namespace scotty::verify
