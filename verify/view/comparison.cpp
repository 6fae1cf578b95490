#include "verify/view/comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "reference/base/assert.h"
#include "reference/base/error.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

using reference::Image;
using reference::Vec3;

namespace {

constexpr float kGain = 8.0f;
constexpr std::array<std::uint8_t, 3> kOutline{255, 45, 61};
constexpr int kReach = 2;  // pixels of an outline from what it goes around

/// Pixels near one that differs, but for those themselves.
std::vector<std::uint8_t> outline_of(const std::vector<std::uint8_t>& differs, int width,
                                     int height) {
    std::vector<std::uint8_t> near(differs.size(), 0);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            if (differs[static_cast<std::size_t>(y) * width + x] == 0) continue;
            for (int row = std::max(0, y - kReach); row <= std::min(height - 1, y + kReach);
                 ++row) {
                for (int column = std::max(0, x - kReach);
                     column <= std::min(width - 1, x + kReach); ++column) {
                    near[static_cast<std::size_t>(row) * width + column] = 1;
                }
            }
        }
    }
    for (std::size_t p = 0; p < near.size(); ++p) near[p] = near[p] != 0 && differs[p] == 0;
    return near;
}

}  // namespace

PictureComparison compare_pictures(const Image& a, const Image& b, float exposure, ToneMap tone) {
    SCOTTY_ASSERT(a.width, ==, b.width);
    SCOTTY_ASSERT(a.height, ==, b.height);
    PictureComparison out;
    out.pixels = a.pixels.size();
    Image difference{a.width, a.height, {}, {}};
    difference.pixels.resize(a.pixels.size());
    std::vector<std::uint8_t> differs(a.pixels.size(), 0);
    for (std::size_t p = 0; p < a.pixels.size(); ++p) {
        const Vec3 apart = a.pixels[p] - b.pixels[p];
        difference.pixels[p] =
            Vec3(std::abs(apart.x), std::abs(apart.y), std::abs(apart.z)) * kGain;
        if (std::memcmp(&a.pixels[p], &b.pixels[p], sizeof(Vec3)) == 0) continue;
        differs[p] = 1;
        if (out.different++ == 0) {
            out.first_x = static_cast<std::uint32_t>(p % a.width);
            out.first_y = static_cast<std::uint32_t>(p / a.width);
        }
        out.largest = std::max(out.largest, static_cast<double>(reference::max_abs(apart)));
    }
    out.a = to_srgb(a, exposure, tone, true);
    out.b = to_srgb(b, exposure, tone, true);
    out.difference = to_srgb(difference, exposure, ToneMap::clamp, true);
    const auto outline = outline_of(differs, static_cast<int>(a.width), static_cast<int>(a.height));
    for (std::size_t p = 0; p < outline.size(); ++p) {
        if (outline[p] == 0) continue;
        for (ColorImage* image : {&out.a, &out.b, &out.difference}) {
            std::copy(kOutline.begin(), kOutline.end(), &image->rgb[3 * p]);
        }
    }
    return out;
}

Image read_radiance(const std::string& file) {
    const NpyArray array = read_npy(file);
    const bool is_picture = array.type == reference::ElementType::float32 &&
                            array.shape.size() == 3 && array.shape[2] == 3;
    if (!is_picture) {
        throw reference::Error::bad_input(
            file, "expected float32 [height, width, 3], found " + shape_text(array.shape));
    }
    Image image{static_cast<std::uint32_t>(array.shape[1]),
                static_cast<std::uint32_t>(array.shape[0]),
                {},
                {}};
    image.pixels.resize(array.shape[0] * array.shape[1]);
    std::memcpy(image.pixels.data(), array.bytes.data(), array.bytes.size());
    return image;
}

}  // namespace scotty::verify
