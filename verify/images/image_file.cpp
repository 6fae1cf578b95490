#include "verify/images/image_file.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "reference/base/assert.h"
#include "reference/base/error.h"
#include "verify/capture/picture_arrays.h"
#include "verify/images/image_library.h"
#include "verify/images/srgb.h"

namespace scotty::verify {

namespace fs = std::filesystem;
using reference::Error;

namespace {

bool is_array(const std::string& path) { return fs::path(path).extension() == ".npy"; }

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

ImageToWrite layout_of(std::uint32_t width, std::uint32_t height) {
    return {static_cast<int>(width),
            static_cast<int>(height),
            {"R", "G", "B"},
            nullptr,
            nullptr,
            {},
            {}};
}

/// Makes an EXR's bytes a function of its content.
void settle_exr(ImageToWrite& file) {
    file.attributes["compression"] = "zip";
    file.attributes["oiio:ColorSpace"] = "Linear";
    // Otherwise it is the time of writing.
    file.attributes["DateTime"] = "1970:01:01 00:00:00";
}

void write_file(const ImageToWrite& image, const std::string& path) {
    const fs::path target(path);
    // The extension stays last, because the library goes by it.
    const Unfinished unfinished{target.parent_path() / (target.stem().string() + ".unfinished" +
                                                        target.extension().string())};
    const std::string why = image_module().write(unfinished.path.string(), image);
    if (!why.empty()) throw Error::bad_input(path, "cannot be written: " + why);
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

reference::Image rounded(const MeasuredImage& image) {
    const auto to_floats = [](const std::vector<Color>& colors) {
        std::vector<reference::Vec3> floats;
        floats.reserve(colors.size());
        for (const Color& c : colors) {
            floats.emplace_back(static_cast<float>(c[0]), static_cast<float>(c[1]),
                                static_cast<float>(c[2]));
        }
        return floats;
    };
    return {image.width, image.height, to_floats(image.mean), to_floats(image.variance)};
}

/// The header's attributes as `scotty-gpu run --image` writes them: "scene" for "scotty:scene".
nlohmann::ordered_json about(const MeasuredImage& image, const ImageAttributes& attributes) {
    nlohmann::ordered_json out;
    for (const auto& [name, value] : attributes) {
        const std::string word = name.starts_with("scotty:") ? name.substr(7) : name;
        // Parameters are JSON themselves.
        auto inner = nlohmann::ordered_json::parse(value, nullptr, false);
        out[word] = inner.is_object() ? std::move(inner) : nlohmann::ordered_json(value);
    }
    if (image.samples != 0) out["samples"] = image.samples;
    if (image.paths_per_sample != 1) out["paths_per_sample"] = image.paths_per_sample;
    return out;
}

}  // namespace

void check_image_path(const std::string& path) {
    const std::string extension = fs::path(path).extension().string();
    if (extension != ".exr" && extension != ".png" && extension != ".npy") {
        throw Error::bad_input(
            path,
            "expected a file name that ends in .exr, .png or .npy, found '" + extension + "'");
    }
    const fs::path folder = fs::path(path).parent_path();
    if (!folder.empty() && !fs::is_directory(folder)) {
        throw Error::bad_input(path, "the folder " + folder.string() + " does not exist");
    }
    if (extension != ".npy") image_module();
}

void write_image(const reference::Image& image, const std::string& path, float exposure) {
    check_image_path(path);
    if (is_array(path)) {
        write_picture_arrays(path, image, nlohmann::ordered_json::object());
        return;
    }
    ImageToWrite file = layout_of(image.width, image.height);
    std::vector<std::uint8_t> bytes;
    if (fs::path(path).extension() == ".exr") {
        settle_exr(file);
        file.floats = &image.pixels.data()->x;
    } else {
        bytes = to_png_bytes(image, exposure);
        file.bytes = bytes.data();
    }
    write_file(file, path);
}

void write_measured_image(const MeasuredImage& image, const std::string& path,
                          const ImageAttributes& attributes) {
    check_image_path(path);
    if (fs::path(path).extension() == ".png") {
        throw Error::bad_input(path,
                               "expected a file name that ends in .exr or .npy: a .png has no room "
                               "for variances");
    }
    SCOTTY_ASSERT(image.mean.size(), ==, std::size_t{image.width} * image.height);
    if (is_array(path)) {
        write_picture_arrays(path, rounded(image), about(image, attributes));
        return;
    }
    ImageToWrite file = layout_of(image.width, image.height);
    if (!image.variance.empty()) {
        file.channels = {"R", "G", "B", "variance.R", "variance.G", "variance.B"};
    }
    file.attributes = attributes;
    settle_exr(file);
    if (image.samples != 0) {
        file.counts["scotty:samples"] = attribute_count(image.samples, "samples", path);
    }
    if (image.paths_per_sample != 1) {
        file.counts["scotty:paths_per_sample"] =
            attribute_count(image.paths_per_sample, "paths per sample", path);
    }
    const std::vector<float> values = interleaved(image);
    file.floats = values.data();
    write_file(file, path);
}

}  // namespace scotty::verify
