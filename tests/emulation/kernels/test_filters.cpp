/// The image filters against plain reference loops.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "emulation/kernels/filter_image.h"
#include "tests/catch.h"
#include "tests/emulation/renders.h"

using namespace scotty::emulation;
using namespace scotty::emulation::test;
using scotty::reference::Filter;
using scotty::reference::Image;
using scotty::reference::Vec3;

namespace {

using Kernel = void (*)(std::uint32_t, const FilterView&);
template <Filter Kind>
void filter(std::uint32_t pixel, const FilterView& view) {
    filter_image(pixel, Kind, view);
}
constexpr Kernel filter_gaussian = filter<Filter::gaussian>;
constexpr Kernel filter_bilateral = filter<Filter::bilateral>;
constexpr Kernel filter_median = filter<Filter::median>;
constexpr std::array<Kernel, 3> kFilters{filter_gaussian, filter_bilateral, filter_median};

Image filtered(const Image& image, Kernel kernel) {
    Image result = image;
    const FilterView view{image.width, image.height, image.pixels.data(), result.pixels.data()};
    for (std::uint32_t i = 0; i < image.pixels.size(); ++i) kernel(i, view);
    return result;
}

Image constant(std::uint32_t width, std::uint32_t height, const Vec3& value) {
    return {width, height, std::vector<Vec3>(std::size_t{width} * height, value)};
}

Image noise(std::uint32_t width, std::uint32_t height, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> uniform(0.0f, 2.0f);
    Image image = constant(width, height, Vec3(0.0f));
    for (Vec3& pixel : image.pixels) pixel = {uniform(random), uniform(random), uniform(random)};
    return image;
}

/// The pixel there; beyond the border, the nearest one.
const Vec3& at(const Image& image, int x, int y) {
    x = std::clamp(x, 0, static_cast<int>(image.width) - 1);
    y = std::clamp(y, 0, static_cast<int>(image.height) - 1);
    return image.pixels[static_cast<std::size_t>(y) * image.width + static_cast<std::size_t>(x)];
}

const std::vector<std::array<std::uint32_t, 2>> kSizes{{1, 1}, {1, 7}, {7, 1},
                                                       {2, 2}, {3, 3}, {17, 5}};

/// The largest difference of a filter from the weighted mean over 5 x 5 in double, as a share of
/// it; `weight(dx, dy, value, centre)`.
template <class Weight>
double distance_from_mean(Kernel kernel, Weight&& weight) {
    double largest = 0.0;
    for (const auto& [width, height] : kSizes) {
        const Image image = noise(width, height, width);
        const Image got = filtered(image, kernel);
        for (int y = 0; y < static_cast<int>(height); ++y) {
            for (int x = 0; x < static_cast<int>(width); ++x) {
                std::array<double, 4> sums{};
                for (int dy = -2; dy <= 2; ++dy) {
                    for (int dx = -2; dx <= 2; ++dx) {
                        const Vec3& value = at(image, x + dx, y + dy);
                        const double w = weight(dx, dy, value, at(image, x, y));
                        for (int c = 0; c < 3; ++c)
                            sums[static_cast<std::size_t>(c)] += w * value[c];
                        sums[3] += w;
                    }
                }
                for (int c = 0; c < 3; ++c) {
                    const double expected = sums[static_cast<std::size_t>(c)] / sums[3];
                    largest = std::max(largest, std::abs(at(got, x, y)[c] - expected) / expected);
                }
            }
        }
    }
    return largest;
}
constexpr double kRounding = 2e-6;

double gaussian_weight(int dx, int dy, const Vec3&, const Vec3&) {
    return std::exp(-0.5 * (dx * dx + dy * dy));
}

/// A planted fault: every pixel takes its right neighbour's value.
template <Kernel Correct>
void off_by_one(std::uint32_t pixel, const FilterView& view) {
    Correct((pixel + 1) % (view.width * view.height), view);
    view.filtered[pixel] = view.filtered[(pixel + 1) % (view.width * view.height)];
}

}  // namespace

TEST_CASE("filter: a constant image stays constant, borders and corners included",
          "[emulation][filter]") {
    const Vec3 value(0.25f, 3.0f, 0.0f);
    for (const Kernel kernel : kFilters) {
        for (const auto& [width, height] : kSizes) {
            const Image image = filtered(constant(width, height, value), kernel);
            for (const Vec3& pixel : image.pixels) {
                for (int c = 0; c < 3; ++c) CHECK(pixel[c] == Approx(value[c]).epsilon(1e-6));
            }
        }
    }
}

TEST_CASE("filter: median equals a sorted reference, borders included", "[emulation][filter]") {
    for (const auto& [width, height] : kSizes) {
        const Image image = noise(width, height, 5);
        const Image got = filtered(image, filter_median);
        for (int y = 0; y < static_cast<int>(height); ++y) {
            for (int x = 0; x < static_cast<int>(width); ++x) {
                for (int c = 0; c < 3; ++c) {
                    std::array<float, 9> values{};
                    for (int i = 0; i < 9; ++i) {
                        values[static_cast<std::size_t>(i)] =
                            at(image, x + i % 3 - 1, y + i / 3 - 1)[c];
                    }
                    std::sort(values.begin(), values.end());
                    CHECK(at(got, x, y)[c] == values[4]);
                }
            }
        }
    }
}

TEST_CASE("filter: median of nine for every order of few distinct values", "[emulation][filter]") {
    for (int code = 0; code < 19683; ++code) {  // 3^9
        float values[9];
        for (int i = 0, rest = code; i < 9; ++i, rest /= 3) {
            values[i] = static_cast<float>(rest % 3);
        }
        std::array<float, 9> sorted{};
        std::copy(values, values + 9, sorted.begin());
        std::sort(sorted.begin(), sorted.end());
        REQUIRE(scotty::reference::median_of_nine(values) == sorted[4]);
    }
}

TEST_CASE("filter: Gaussian equals a normalised reference in double", "[emulation][filter]") {
    CHECK(distance_from_mean(filter_gaussian, gaussian_weight) < kRounding);
}

TEST_CASE("filter: a filter off by one, and weights a percent too wide, are seen",
          "[emulation][filter]") {
    CHECK(distance_from_mean(off_by_one<filter_gaussian>, gaussian_weight) > 0.05);
    CHECK(distance_from_mean(filter_gaussian, [](int dx, int dy, const Vec3&, const Vec3&) {
              return std::exp(-0.5 * (dx * dx + dy * dy) / (1.01 * 1.01));
          }) > 100 * kRounding);
    const Image image = noise(17, 5, 5);
    CHECK(filtered(image, off_by_one<filter_median>).pixels !=
          filtered(image, filter_median).pixels);
}

TEST_CASE("filter: Gaussian is centred and keeps the sum of an inner pixel",
          "[emulation][filter]") {
    Image image = constant(9, 9, Vec3(0.0f));
    image.pixels[4 * 9 + 4] = Vec3(1.0f);
    const Image got = filtered(image, filter_gaussian);
    double sum = 0.0;
    for (int y = 0; y < 9; ++y) {
        for (int x = 0; x < 9; ++x) {
            sum += at(got, x, y).x;
            CHECK(at(got, x, y).x == at(got, 8 - x, y).x);
            CHECK(at(got, x, y).x == at(got, y, x).x);
        }
    }
    CHECK(sum == Approx(1.0).epsilon(1e-5));
}

TEST_CASE("filter: bilateral equals a reference in double", "[emulation][filter]") {
    const auto weight = [](double sharper) {
        return [sharper](int dx, int dy, const Vec3& value, const Vec3& centre) {
            double range = 0.0;
            for (int c = 0; c < 3; ++c) range += std::pow(double{value[c]} - centre[c], 2);
            const double sigma = 0.25 * std::max({centre.x, centre.y, centre.z}) + 0.02;
            return std::exp(-0.5 * (dx * dx + dy * dy + sharper * range / (sigma * sigma)));
        };
    };
    CHECK(distance_from_mean(filter_bilateral, weight(1.0)) < kRounding);
    CHECK(distance_from_mean(filter_bilateral, weight(1.02)) > 100 * kRounding);
    CHECK(distance_from_mean(off_by_one<filter_bilateral>, weight(1.0)) > 0.05);
}

TEST_CASE("filter: bilateral keeps an edge that Gaussian blurs", "[emulation][filter]") {
    Image image = constant(12, 6, Vec3(0.1f));
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
        if (i % 12 >= 6) image.pixels[i] = Vec3(5.0f);
    }
    const Image kept = filtered(image, filter_bilateral);
    const Image blurred = filtered(image, filter_gaussian);
    CHECK(at(kept, 5, 3).x == Approx(0.1f).epsilon(1e-3));
    CHECK(at(blurred, 5, 3).x > 1.0f);
}

TEST_CASE("filter: renders are filtered below the threshold of samples only",
          "[emulation][filter]") {
    auto p = tiny(12, 10);
    const Image plain = render("cornell", p);
    constexpr std::array<Filter, 3> kinds{Filter::gaussian, Filter::bilateral, Filter::median};
    for (std::size_t i = 0; i < kinds.size(); ++i) {
        p.filter = kinds[i];
        p.filter_threshold = p.spp + 1;
        CHECK(differing_pixels(render("cornell", p), filtered(plain, kFilters[i])) == 0);
        p.filter_threshold = p.spp;
        CHECK(differing_pixels(render("cornell", p), plain) == 0);
    }
}
