#include "verify/images/planted_faults.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "reference/numerics/rng.h"

namespace scotty::verify {
namespace {

/// What a pixel sees.
struct Place {
    Color albedo{};
    double direct = 0.0;  ///< from one light sample that reaches the lamp, without the cosine
    double cosine = 1.0;
    double visibility = 1.0;  ///< the share of the lamp that it sees
    double indirect = 0.0;
};

constexpr std::uint32_t kOtherScene = 1;

/// `u`, `v` in [0, 1] across the image.
Place place_at(double u, double v, std::uint32_t scene) {
    Place place;
    if (v < 0.08) return place;  // the background is always black
    const double turn = scene == kOtherScene ? v : u;
    place.albedo = {0.3 + 0.5 * turn, 0.75 - 0.4 * u * v, 0.25 + 0.3 * (1.0 - turn)};
    place.cosine = 0.35 + 0.6 * (1.0 - std::abs(u - 0.4));
    place.direct = 0.8;
    place.visibility = std::clamp(4.0 * std::hypot(u - 0.65, v - 0.7) - 0.5, 0.0, 1.0);
    place.indirect = 0.1 + 0.15 * v;
    return place;
}

struct Estimator {
    const SyntheticSettings& settings;
    ImageFault fault;
    std::uint32_t scene;

    /// The radiance of one path, without the surface's colour.
    double path(const Place& place, std::uint32_t pixel, std::uint32_t sample) const {
        const reference::Random4 r = reference::random4(settings.seed, pixel, sample, scene, 0);
        const bool drops = fault == ImageFault::light_sample_dropped && pixel % 16 == 5;
        const double cosine = fault == ImageFault::cosine_forgotten ? 1.0 : place.cosine;
        const double seen =
            (r.a < place.visibility ? 0.5 : 0.0) + (!drops && r.b < place.visibility ? 0.5 : 0.0);
        // Mean 1, at most 10, mostly below 0.1, like the later bounces of a path tracer.
        const double c3 = double{r.c} * r.c * r.c;
        double indirect = place.indirect * 10.0 * c3 * c3 * c3;
        if (settings.fireflies && r.d < 1.0 / 20000.0) indirect += 1000.0 * place.indirect;
        return seen * place.direct * cosine + indirect;
    }

    void measure(std::uint32_t x, std::uint32_t y, Color& mean, Color& variance) const {
        const Place place =
            place_at((x + 0.5) / settings.width, (y + 0.5) / settings.height, scene);
        const std::uint32_t pixel = y * settings.width + x;
        double sum = 0.0;
        double squares = 0.0;
        if (place.albedo[0] > 0.0) {
            for (std::uint32_t s = 0; s < settings.samples; ++s) {
                const double value = path(place, pixel, s);
                sum += value;
                squares += value * value;
            }
        }
        const double n = settings.samples;
        const double average = sum / n;
        const double spread = std::max(0.0, squares / n - average * average) / (n - 1.0);
        for (std::size_t c = 0; c < 3; ++c) {
            mean[c] = static_cast<float>(place.albedo[c] * average);
            variance[c] = place.albedo[c] * place.albedo[c] * spread;
        }
    }
};

MeasuredImage render(const SyntheticSettings& settings, ImageFault fault, std::uint32_t scene) {
    const std::size_t pixels = std::size_t{settings.width} * settings.height;
    MeasuredImage image{settings.width,
                        settings.height,
                        std::vector<Color>(pixels),
                        std::vector<Color>(pixels),
                        settings.samples,
                        1};
    const Estimator estimator{settings, fault, scene};
    tbb::parallel_for(tbb::blocked_range<std::uint32_t>(0, settings.height), [&](const auto& rows) {
        for (std::uint32_t y = rows.begin(); y != rows.end(); ++y) {
            for (std::uint32_t x = 0; x < settings.width; ++x) {
                const std::size_t i = std::size_t{y} * settings.width + x;
                estimator.measure(x, y, image.mean[i], image.variance[i]);
            }
        }
    });
    return image;
}

void scale(Color& color, double factor) {
    for (double& value : color) value *= factor;
}

}  // namespace

const std::vector<ImageFault>& all_image_faults() {
    static const std::vector<ImageFault> faults{ImageFault::none,
                                                ImageFault::brighter,
                                                ImageFault::black_pixels,
                                                ImageFault::dark_tile,
                                                ImageFault::not_a_number,
                                                ImageFault::light_sample_dropped,
                                                ImageFault::cosine_forgotten,
                                                ImageFault::mirrored,
                                                ImageFault::wrong_golden};
    return faults;
}

std::string_view name(ImageFault fault) {
    switch (fault) {
        case ImageFault::none:
            return "none";
        case ImageFault::brighter:
            return "+1 % radiance";
        case ImageFault::black_pixels:
            return "10 black pixels";
        case ImageFault::dark_tile:
            return "one tile -5 %";
        case ImageFault::not_a_number:
            return "a NaN";
        case ImageFault::light_sample_dropped:
            return "a light sample dropped";
        case ImageFault::cosine_forgotten:
            return "cosine forgotten";
        case ImageFault::mirrored:
            return "mirrored";
        case ImageFault::wrong_golden:
            return "wrong golden";
    }
    return "?";
}

bool happens_while_rendering(ImageFault fault) {
    return fault == ImageFault::light_sample_dropped || fault == ImageFault::cosine_forgotten;
}

void plant(MeasuredImage& image, ImageFault fault) {
    const std::size_t pixels = image.mean.size();
    if (fault == ImageFault::brighter) {
        for (Color& color : image.mean) scale(color, 1.01);
        for (Color& color : image.variance) scale(color, 1.01 * 1.01);
    } else if (fault == ImageFault::black_pixels) {
        for (std::size_t k = 0; k < 10; ++k) {
            const std::size_t i = (pixels / 2 + k * 9973) % pixels;
            image.mean[i] = image.variance[i] = {};
        }
    } else if (fault == ImageFault::dark_tile) {
        // This tile is in full light, left of the middle; a small image has only one.
        const std::uint32_t x0 = image.width / 32 * 8;
        const std::uint32_t y0 = image.height / 16 * 8;
        for (std::uint32_t y = y0; y < std::min(y0 + 8, image.height); ++y) {
            for (std::uint32_t x = x0; x < std::min(x0 + 8, image.width); ++x) {
                scale(image.mean[std::size_t{y} * image.width + x], 0.95);
            }
        }
    } else if (fault == ImageFault::not_a_number) {
        image.mean[pixels / 2][1] = std::numeric_limits<double>::quiet_NaN();
    } else if (fault == ImageFault::mirrored) {
        for (auto* colors : {&image.mean, &image.variance}) {
            for (std::uint32_t y = 0; y < image.height; ++y) {
                const auto row = colors->begin() + std::ptrdiff_t{y} * image.width;
                std::reverse(row, row + image.width);
            }
        }
    }
}

MeasuredImage synthetic_render(const SyntheticSettings& settings, ImageFault fault) {
    MeasuredImage image = render(settings, fault, 0);
    plant(image, fault);
    return image;
}

MeasuredImage synthetic_golden(SyntheticSettings settings, std::uint32_t factor, ImageFault fault) {
    settings.samples *= factor;
    settings.seed += std::uint64_t{1} << 40;
    return render(settings, ImageFault::none, fault == ImageFault::wrong_golden ? kOtherScene : 0);
}

}  // namespace scotty::verify
