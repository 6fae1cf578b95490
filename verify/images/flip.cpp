#include "verify/images/flip.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/matrix.hpp>

namespace scotty::verify {
namespace {

using glm::dmat3;
using glm::dvec3;

/// One number per pixel.
struct Plane {
    std::ptrdiff_t width, height;
    std::vector<double> values;

    double clamped(std::ptrdiff_t x, std::ptrdiff_t y) const {
        x = std::clamp<std::ptrdiff_t>(x, 0, width - 1);
        y = std::clamp<std::ptrdiff_t>(y, 0, height - 1);
        return values[static_cast<std::size_t>(y * width + x)];
    }
};

/// Weights for offsets -radius to radius.
using Kernel = std::vector<double>;

template <class Weight>
Kernel kernel(std::ptrdiff_t radius, const Weight& weight) {
    Kernel weights;
    for (std::ptrdiff_t i = -radius; i <= radius; ++i) {
        weights.push_back(weight(static_cast<double>(i)));
    }
    return weights;
}

/// Scales all positive weights to a sum of 1, all negative ones to -1.
Kernel normalized(Kernel weights) {
    double positive = 0.0;
    double negative = 0.0;
    for (const double w : weights) (w > 0.0 ? positive : negative) += w;
    for (double& w : weights) w /= w > 0.0 ? positive : -negative;
    return weights;
}

template <class At>
Plane convolved(const Plane& in, const Kernel& weights, const At& at) {
    const auto radius = static_cast<std::ptrdiff_t>(weights.size() / 2);
    Plane out{in.width, in.height, {}};
    out.values.reserve(in.values.size());
    for (std::ptrdiff_t y = 0; y < in.height; ++y) {
        for (std::ptrdiff_t x = 0; x < in.width; ++x) {
            double sum = 0.0;
            for (std::ptrdiff_t i = -radius; i <= radius; ++i) {
                sum += weights[static_cast<std::size_t>(i + radius)] * at(x, y, i);
            }
            out.values.push_back(sum);
        }
    }
    return out;
}

Plane filtered(const Plane& in, const Kernel& across, const Kernel& down) {
    const Plane rows =
        convolved(in, across, [&](auto x, auto y, auto i) { return in.clamped(x + i, y); });
    return convolved(rows, down, [&](auto x, auto y, auto i) { return rows.clamped(x, y + i); });
}

/// Linear sRGB to CIE XYZ, from the primaries' and D65's chromaticities; by columns, as GLM has it.
const dmat3& xyz_of_rgb() {
    static const dmat3 matrix(
        10135552.0 / 24577794.0, 2613072.0 / 12288897.0, 1425312.0 / 73733382.0,
        8788810.0 / 24577794.0, 8788810.0 / 12288897.0, 8788810.0 / 73733382.0,
        4435075.0 / 24577794.0, 887015.0 / 12288897.0, 70074185.0 / 73733382.0);
    return matrix;
}

dvec3 relative_xyz(const dvec3& rgb) { return (xyz_of_rgb() * rgb) / (xyz_of_rgb() * dvec3(1.0)); }

dvec3 rgb_of_relative(const dvec3& xyz) {
    static const dmat3 inverse = glm::inverse(xyz_of_rgb());
    return inverse * (xyz * (xyz_of_rgb() * dvec3(1.0)));
}

/// YyCxCz: the linear opponent space in which the eye's contrast sensitivity is applied.
dvec3 opponent(const dvec3& rgb) {
    const dvec3 xyz = relative_xyz(rgb);
    return {116.0 * xyz.y - 16.0, 500.0 * (xyz.x - xyz.y), 200.0 * (xyz.y - xyz.z)};
}

dvec3 rgb_of_opponent(const dvec3& color) {
    const double y = (color.x + 16.0) / 116.0;
    return rgb_of_relative({y + color.y / 500.0, y, y - color.z / 200.0});
}

/// CIELAB with Hunt's adjustment: colours of dark pixels differ less.
dvec3 hunt_lab(const dvec3& rgb) {
    constexpr double kDelta = 6.0 / 29.0;
    dvec3 f = relative_xyz(rgb);
    for (int i = 0; i < 3; ++i) {
        f[i] = f[i] > kDelta * kDelta * kDelta ? std::cbrt(f[i])
                                               : f[i] / (3.0 * kDelta * kDelta) + 4.0 / 29.0;
    }
    const double lightness = 116.0 * f.y - 16.0;
    return {lightness, 0.01 * lightness * 500.0 * (f.x - f.y),
            0.01 * lightness * 200.0 * (f.y - f.z)};
}

/// HyAB of Abasi et al. (2020).
double hyab(const dvec3& a, const dvec3& b) {
    return std::abs(a.x - b.x) + std::hypot(a.y - b.y, a.z - b.z);
}

/// A term of a channel's contrast sensitivity as a filter in degrees: a sqrt(pi / b) e^(-pi^2 d^2 /
/// b).
struct Gaussian {
    double a, b;
};

Plane contrast_filtered(const Plane& in, const std::vector<Gaussian>& terms) {
    // One radius for all channels, three deviations of the widest.
    const auto radius = static_cast<std::ptrdiff_t>(
        std::ceil(3.0 * std::sqrt(0.04 / (2.0 * M_PI * M_PI)) * kFlipPixelsPerDegree));
    Plane sum{in.width, in.height, std::vector<double>(in.values.size())};
    double total = 0.0;
    for (const Gaussian& term : terms) {
        const Kernel line = kernel(radius, [&](double i) {
            const double degrees = i / kFlipPixelsPerDegree;
            return std::exp(-M_PI * M_PI * degrees * degrees / term.b);
        });
        const double scale = term.a * std::sqrt(M_PI / term.b);
        double weight = 0.0;
        for (const double w : line) weight += w;
        total += scale * weight * weight;
        const Plane part = filtered(in, line, line);
        for (std::size_t i = 0; i < sum.values.size(); ++i) {
            sum.values[i] += scale * part.values[i];
        }
    }
    for (double& value : sum.values) value /= total;
    return sum;
}

/// The colours and features that FLIP finds in one image.
struct Seen {
    std::vector<dvec3> color;                   ///< CIELAB after Hunt, as the eye resolves it
    std::vector<double> edge_size, point_size;  ///< of the luminance's features
};

std::vector<double> sizes(const Plane& luminance, const Kernel& feature, const Kernel& smooth) {
    const Plane across = filtered(luminance, feature, smooth);
    const Plane down = filtered(luminance, smooth, feature);
    std::vector<double> size(luminance.values.size());
    for (std::size_t i = 0; i < size.size(); ++i) {
        size[i] = std::hypot(across.values[i], down.values[i]);
    }
    return size;
}

void see_features(const Plane& luminance, Seen& seen) {
    const double deviation = 0.5 * 0.082 * kFlipPixelsPerDegree;  // features of 0.082 degrees
    const auto radius = static_cast<std::ptrdiff_t>(std::ceil(3.0 * deviation));
    const auto gauss = [&](double i) { return std::exp(-i * i / (2.0 * deviation * deviation)); };
    const Kernel smooth = normalized(kernel(radius, gauss));
    const Kernel edge = normalized(kernel(radius, [&](double i) { return -i * gauss(i); }));
    const Kernel point = normalized(kernel(
        radius, [&](double i) { return (i * i / (deviation * deviation) - 1.0) * gauss(i); }));
    seen.edge_size = sizes(luminance, edge, smooth);
    seen.point_size = sizes(luminance, point, smooth);
}

Seen see(const MeasuredImage& image) {
    std::array<Plane, 3> planes;
    for (Plane& plane : planes) plane = {image.width, image.height, {}};
    for (const Color& pixel : image.mean) {
        const dvec3 color = opponent(glm::clamp(dvec3(pixel[0], pixel[1], pixel[2]), 0.0, 1.0));
        for (int c = 0; c < 3; ++c) planes[static_cast<std::size_t>(c)].values.push_back(color[c]);
    }
    Plane luminance = planes[0];
    for (double& value : luminance.values) value = (value + 16.0) / 116.0;

    Seen seen;
    see_features(luminance, seen);
    const Plane y = contrast_filtered(planes[0], {{1.0, 0.0047}});
    const Plane red_green = contrast_filtered(planes[1], {{1.0, 0.0053}});
    const Plane blue_yellow = contrast_filtered(planes[2], {{34.1, 0.04}, {13.5, 0.025}});
    for (std::size_t i = 0; i < image.mean.size(); ++i) {
        const dvec3 rgb =
            rgb_of_opponent({y.values[i], red_green.values[i], blue_yellow.values[i]});
        seen.color.push_back(hunt_lab(glm::clamp(rgb, 0.0, 1.0)));
    }
    return seen;
}

/// Maps colour differences to [0, 1]; differences that are not huge get most of the range.
double redistributed(double difference) {
    static const double most =
        std::pow(hyab(hunt_lab({0.0, 1.0, 0.0}), hunt_lab({0.0, 0.0, 1.0})), 0.7);
    const double knee = 0.4 * most;
    const double power = std::pow(difference, 0.7);
    if (power < knee) return power * 0.95 / knee;
    return 0.95 + (power - knee) / (most - knee) * 0.05;
}

}  // namespace

std::vector<double> flip_map(const MeasuredImage& image, const MeasuredImage& golden) {
    const Seen a = see(image);
    const Seen b = see(golden);
    std::vector<double> map(image.mean.size());
    for (std::size_t i = 0; i < map.size(); ++i) {
        const double color = redistributed(hyab(a.color[i], b.color[i]));
        const double feature = std::max(std::abs(a.edge_size[i] - b.edge_size[i]),
                                        std::abs(a.point_size[i] - b.point_size[i]));
        map[i] = std::pow(color, 1.0 - std::sqrt(feature / std::sqrt(2.0)));
    }
    return map;
}

}  // namespace scotty::verify
