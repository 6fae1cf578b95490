#include "verify/view/display.h"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "verify/images/srgb.h"

namespace scotty::verify {
namespace {

using reference::Image;
using reference::Vec3;

float tone_mapped(float radiance, ToneMap tone) {
    switch (tone) {
        case ToneMap::reinhard:
            return radiance > 0.0f ? radiance / (1.0f + radiance) : 0.0f;
        case ToneMap::filmic: {  // K. Narkowicz's fit of ACES, 2015
            const float x = std::clamp(radiance, 0.0f, 1.0e4f);
            return x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f);
        }
        case ToneMap::clamp:
            break;
    }
    return radiance;
}

std::uint8_t byte_of(float radiance, ToneMap tone) {
    return static_cast<std::uint8_t>(
        std::lround(srgb_encode(tone_mapped(radiance, tone)) * 255.0f));
}

/// By the upper half of a float's bits; the middle of what shares them stands for all.
std::array<std::uint8_t, 65536> make_table(ToneMap tone) {
    std::array<std::uint8_t, 65536> table{};
    for (std::uint32_t upper = 0; upper < table.size(); ++upper) {
        const auto radiance = std::bit_cast<float>(upper << 16 | 0x8000u);
        table[upper] = std::isnan(radiance) ? std::uint8_t{0} : byte_of(radiance, tone);
    }
    for (const float endless : {INFINITY, -INFINITY}) {  // whose lower half is no middle
        table[std::bit_cast<std::uint32_t>(endless) >> 16] = byte_of(endless, tone);
    }
    return table;
}
const std::array<std::uint8_t, 65536>& table_of(ToneMap tone) {
    static const std::array<std::array<std::uint8_t, 65536>, 3> tables{
        make_table(ToneMap::clamp), make_table(ToneMap::reinhard), make_table(ToneMap::filmic)};
    return tables[static_cast<std::size_t>(tone)];
}

/// Calls f(pixel) for all pixels, in parallel.
template <class F>
void for_each_pixel(std::size_t pixels, const F& f) {
    constexpr std::size_t kGrain = 8192;
    oneapi::tbb::parallel_for(oneapi::tbb::blocked_range<std::size_t>(0, pixels, kGrain),
                              [&](const oneapi::tbb::blocked_range<std::size_t>& range) {
                                  for (std::size_t p = range.begin(); p != range.end(); ++p) f(p);
                              });
}

using Rgb = std::array<std::uint8_t, 3>;

/// Five points of the colour map "viridis" (S. van der Walt and N. Smith, 2015), between which it
/// is linear.
Rgb scale_color(double position) {
    constexpr std::array<std::array<double, 3>, 5> kStops{
        {{68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}}};
    const double at = std::clamp(position, 0.0, 1.0) * (kStops.size() - 1);
    const auto below = std::min(static_cast<std::size_t>(at), kStops.size() - 2);
    const double share = at - static_cast<double>(below);
    Rgb color{};
    for (std::size_t c = 0; c < color.size(); ++c) {
        color[c] = static_cast<std::uint8_t>(
            std::lround(kStops[below][c] + share * (kStops[below + 1][c] - kStops[below][c])));
    }
    return color;
}

/// Of its own, and far from its neighbours' (Knuth's multiplicative hash).
Rgb number_color(float value) {
    const std::uint32_t mixed = (static_cast<std::uint32_t>(value) + 1u) * 2654435761u;
    return {static_cast<std::uint8_t>(64 + (mixed >> 24) % 192),
            static_cast<std::uint8_t>(64 + (mixed >> 16) % 192),
            static_cast<std::uint8_t>(64 + (mixed >> 8) % 192)};
}

ColorLegend legend_of(const FeatureImage& feature) {
    ColorLegend legend;
    std::vector<float> known;
    for (const float value : feature.values) {
        if (std::isfinite(value)) known.push_back(value);
    }
    if (known.empty()) return legend;
    const auto at = [&](double share) {
        const auto place = known.begin() + static_cast<std::ptrdiff_t>(
                                               share * static_cast<double>(known.size() - 1));
        std::nth_element(known.begin(), place, known.end());
        return static_cast<double>(*place);
    };
    switch (feature.subject) {
        case ViewSubject::distance:
            return {at(0.0), at(1.0), false, "m"};
        case ViewSubject::queues:
            return {at(0.0), at(1.0), false, "queues"};
        case ViewSubject::bounces:
            return {0.0, std::max(1.0, at(1.0)), false, "bounces"};
        case ViewSubject::variance:
            return {std::max(at(0.05), 1e-6), std::max(at(0.995), 1e-5), true,
                    "relative standard error"};
        default:
            return legend;
    }
}

double position_of(const ColorLegend& legend, double value) {
    if (legend.logarithmic) {
        value = std::log(std::max(value, legend.low)) - std::log(legend.low);
        const double range = std::log(legend.high) - std::log(legend.low);
        return range > 0.0 ? value / range : 0.0;
    }
    return legend.high > legend.low ? (value - legend.low) / (legend.high - legend.low) : 0.0;
}

}  // namespace

ColorImage to_srgb(const Image& image, float exposure, ToneMap tone, bool exact) {
    const float scale = std::exp2(exposure);
    ColorImage out{image.width, image.height, {}};
    out.rgb.resize(3 * image.pixels.size());
    const auto& table = table_of(tone);
    for_each_pixel(image.pixels.size(), [&](std::size_t p) {
        const Vec3& pixel = image.pixels[p];
        std::uint8_t* to = &out.rgb[3 * p];
        for (const float value : {pixel.x, pixel.y, pixel.z}) {
            const float radiance = value * scale;
            *to++ = exact ? byte_of(radiance, tone)
                          : table[std::bit_cast<std::uint32_t>(radiance) >> 16];
        }
    });
    return out;
}

ColorImage false_colors(const FeatureImage& feature, ColorLegend& legend) {
    legend = legend_of(feature);
    ColorImage out{feature.width, feature.height, {}};
    const std::size_t pixels = std::size_t{feature.width} * feature.height;
    out.rgb.resize(3 * pixels);
    for_each_pixel(pixels, [&](std::size_t p) {
        Rgb color{0, 0, 0};
        if (feature.subject == ViewSubject::normal) {
            const Vec3& n = feature.normals[p];
            if (!reference::is_zero(n)) {
                const auto half = [](float v) {
                    return static_cast<std::uint8_t>(std::lround((v * 0.5f + 0.5f) * 255.0f));
                };
                color = {half(n.x), half(n.y), half(n.z)};
            }
        } else if (const float value = feature.values[p]; std::isfinite(value)) {
            color = feature.subject == ViewSubject::primitive
                        ? number_color(value)
                        : scale_color(position_of(legend, static_cast<double>(value)));
        }
        std::copy(color.begin(), color.end(), &out.rgb[3 * p]);
    });
    return out;
}

}  // namespace scotty::verify
