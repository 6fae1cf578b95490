#include "verify/image_file.h"

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <system_error>
#include <vector>

#include "reference/error.h"

namespace scotty::verify {

namespace fs = std::filesystem;
using reference::Error;

namespace {

/// IEC 61966-2-1.
float srgb(float linear) {
    if (!(linear > 0.0f)) return 0.0f;  // NaN too: the verification finds those, not the picture
    if (linear >= 1.0f) return 1.0f;
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

std::vector<std::uint8_t> to_png_bytes(const reference::Image& image, float exposure) {
    const float scale = std::exp2(exposure);
    std::vector<std::uint8_t> bytes;
    bytes.reserve(image.pixels.size() * 3);
    for (const reference::Vec3& pixel : image.pixels) {
        for (const float value : {pixel.x, pixel.y, pixel.z}) {
            bytes.push_back(static_cast<std::uint8_t>(std::lround(srgb(value * scale) * 255.0f)));
        }
    }
    return bytes;
}

/// Removes what is there when writing fails half-way.
struct Unfinished {
    fs::path path;
    ~Unfinished() {
        std::error_code ignored;
        fs::remove(path, ignored);
    }
};

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
    const fs::path target(path);
    const bool exr = target.extension() == ".exr";
    // The extension stays last: OpenImageIO goes by it.
    Unfinished unfinished{target.parent_path() /
                          (target.stem().string() + ".unfinished" + target.extension().string())};
    const auto output = OIIO::ImageOutput::create(unfinished.path.string());
    if (!output) throw Error::bad_input(path, "cannot be written: " + OIIO::geterror());
    const OIIO::TypeDesc type = exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8;
    OIIO::ImageSpec spec(static_cast<int>(image.width), static_cast<int>(image.height), 3, type);
    if (exr) {
        spec.attribute("compression", "zip");
        spec.attribute("oiio:ColorSpace", "Linear");
        // Else it is the time of writing; the same picture is the same file.
        spec.attribute("DateTime", "1970:01:01 00:00:00");
    }
    const std::vector<std::uint8_t> bytes =
        exr ? std::vector<std::uint8_t>() : to_png_bytes(image, exposure);
    const void* data = exr ? static_cast<const void*>(image.pixels.data()) : bytes.data();
    if (!output->open(unfinished.path.string(), spec) || !output->write_image(type, data) ||
        !output->close()) {
        throw Error::bad_input(path, "cannot be written: " + output->geterror());
    }
    std::error_code error;
    fs::rename(unfinished.path, target, error);
    if (error) throw Error::bad_input(path, "cannot be written: " + error.message());
}

}  // namespace scotty::verify
