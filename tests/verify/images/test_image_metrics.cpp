/// Distances on cases that can be worked out, or that the FLIP authors' own program has worked out.
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/catch.h"
#include "tests/verify/image_tools.h"
#include "verify/base/statistics.h"
#include "verify/images/flip.h"
#include "verify/images/image_metrics.h"

namespace {

using namespace scotty::verify;
using namespace scotty::verify::test;

MeasuredImage constant(double r, double g, double b) {
    MeasuredImage image{24, 16, {}, {}, 0, 1};
    image.mean.assign(24 * 16, {r, g, b});
    return image;
}

template <class At>
MeasuredImage picture(const At& at) {
    MeasuredImage image{24, 16, {}, {}, 0, 1};
    for (int y = 0; y < 16; ++y) {
        for (int x = 0; x < 24; ++x) image.mean.push_back(at(x, y, (x + 0.5) / 24, (y + 0.5) / 16));
    }
    return image;
}

double flip_of(const MeasuredImage& a, const MeasuredImage& b) { return image_metrics(a, b).flip; }

TEST_CASE("flip: equal images are 0 everywhere", "[verify][image][metrics]") {
    for (const double value : flip_map(smooth_image(24, 16), smooth_image(24, 16))) {
        CHECK(value == 0.0);
    }
}

// Expected values in the next two cases: flip-evaluator 1.7, the authors' program, on linear input
// with its default 67.02 pixels per degree. It computes in float.
TEST_CASE("flip: constant images have the authors' values, and order does not matter",
          "[verify][image][metrics]") {
    CHECK(flip_of(constant(0, 0, 0), constant(1, 1, 1)) == Approx(0.967387).margin(1e-4));
    CHECK(flip_of(constant(1, 1, 1), constant(0, 0, 0)) == Approx(0.967387).margin(1e-4));
    CHECK(flip_of(constant(0, 1, 0), constant(0, 0, 1)) == Approx(1.0).margin(1e-4));
    CHECK(flip_of(constant(1, 0, 0), constant(0, 1, 0)) == Approx(0.986664).margin(1e-4));
    CHECK(flip_of(constant(0.2, 0.2, 0.2), constant(0.25, 0.25, 0.25)) ==
          Approx(0.183436).margin(1e-4));
    // Beyond a screen's range there is nothing to see.
    CHECK(flip_of(constant(7, 1, 1), constant(1, 1, 30)) == 0.0);
}

TEST_CASE("flip: pictures with colours, edges and dots have the authors' values",
          "[verify][image][metrics]") {
    const auto smooth = [](int, int, double u, double v) {
        return Color{u, v, 0.5 * (1.0 - u) + 0.25 * v};
    };
    const MeasuredImage base = picture(smooth);
    const MeasuredImage other = picture([&](int, int, double u, double v) {
        return Color{0.9 * u + 0.05, v * v, 0.5 * (1.0 - u) + 0.25 * v};
    });
    const MeasuredImage patch = picture([&](int x, int y, double u, double v) {
        const bool inside = x >= 8 && x < 12 && y >= 5 && y < 9;
        return inside ? Color{0.9, 0.1, 0.1} : smooth(x, y, u, v);
    });
    const auto board = [](int phase) {
        return picture([phase](int x, int y, double, double) {
            const double value = (x + y + phase) % 2;
            return Color{value, value, value};
        });
    };
    struct Expected {
        const MeasuredImage a, b;
        double mean, inside, corner;
    };
    const std::vector<Expected> table{{base, other, 0.613672, 0.752327, 0.433278},
                                      {base, patch, 0.0799320, 0.865007, 0.000871543},
                                      {board(0), board(1), 0.0149261, 0.00168025, 0.398270},
                                      {base, board(0), 0.825728, 0.486549, 0.969334}};
    for (std::size_t i = 0; i < table.size(); ++i) {
        INFO("pair " << i);
        const std::vector<double> map = flip_map(table[i].a, table[i].b);
        CHECK(flip_of(table[i].a, table[i].b) == Approx(table[i].mean).epsilon(1e-3));
        CHECK(map[7 * 24 + 9] == Approx(table[i].inside).epsilon(2e-3).margin(1e-5));
        CHECK(map[0] == Approx(table[i].corner).epsilon(2e-3));
    }
}

TEST_CASE("metrics: relative squared error and PSNR of a constant offset are by hand",
          "[verify][image][metrics]") {
    const ImageMetrics m = image_metrics(constant(0.6, 0.5, 0.5), constant(0.5, 0.5, 0.5));
    CHECK(m.rel_mse == Approx(0.01 / (0.25 + 0.01) / 3.0));
    // sRGB of 0.5 is 0.7353570, of 0.6 is 0.7977377.
    CHECK(m.psnr ==
          Approx(-10.0 * std::log10(std::pow(0.7977377 - 0.7353570, 2) / 3.0)).epsilon(1e-4));
    CHECK(m.max_ulps == ulps_between(0.6, 0.5));
    const ImageMetrics equal = image_metrics(constant(0.5, 1, 9), constant(0.5, 1, 9));
    CHECK(equal.rel_mse == 0.0);
    CHECK(std::isinf(equal.psnr));
    CHECK(equal.max_ulps == 0.0);
}

TEST_CASE("metrics: units in the last place count floats, across zero and to infinity",
          "[verify][image][metrics]") {
    const float inf = std::numeric_limits<float>::infinity();
    CHECK(ulps_between(1.0, std::nextafter(1.0f, 2.0f)) == 1.0);
    CHECK(ulps_between(1.0, 2.0) == 8388608.0);
    CHECK(ulps_between(0.0, -0.0) == 0.0);
    CHECK(ulps_between(1.4e-45, -1.4e-45) == 2.0);
    CHECK(ulps_between(std::numeric_limits<float>::max(), inf) == 1.0);
    CHECK(ulps_between(std::nan(""), std::nan("")) == 0.0);
    CHECK(std::isinf(ulps_between(std::nan(""), 1.0)));
    CHECK(std::isinf(ulps_between(0.0, std::nan(""))));
}

TEST_CASE("metrics: a NaN is seen: no metric has a number for it", "[verify][image][metrics]") {
    MeasuredImage image = constant(0.5, 0.5, 0.5);
    image.mean[70][2] = std::nan("");
    const ImageMetrics m = image_metrics(image, constant(0.5, 0.5, 0.5));
    CHECK(std::isnan(m.flip));
    CHECK(std::isnan(m.rel_mse));
    CHECK(std::isnan(m.psnr));
    CHECK(std::isinf(m.max_ulps));
}

TEST_CASE("heat map: from black to white, and NaN stands out", "[verify][image][metrics]") {
    const auto map = heat_map({0.0, 8.0, 1e9, std::nan(""), 2.0, 6.0}, 3, 2, 8.0);
    using scotty::reference::Vec3;
    CHECK(map.pixels[0] == Vec3(0.0f));
    CHECK(map.pixels[1] == Vec3(1.0f));
    CHECK(map.pixels[2] == Vec3(1.0f));
    CHECK(map.pixels[3] == Vec3(1.0f, 0.0f, 1.0f));
    CHECK(map.pixels[4].z > map.pixels[4].x);  // blue
    CHECK(map.pixels[5].x > map.pixels[5].z);  // yellow
}

// Expected values: scipy 1.x, betainc and the survival functions of t and norm.
TEST_CASE("statistics: the incomplete beta function has its tabulated values",
          "[verify][statistics]") {
    CHECK(incomplete_beta(1, 1, 0.25) == Approx(0.25).epsilon(1e-13));
    CHECK(incomplete_beta(2, 3, 0.4) == Approx(0.5248).epsilon(1e-13));
    CHECK(incomplete_beta(0.5, 0.5, 0.3) == Approx(0.36901011956554536).epsilon(1e-12));
    CHECK(incomplete_beta(10, 0.5, 0.9) == Approx(0.15164090963470994).epsilon(1e-12));
    CHECK(incomplete_beta(127.5, 0.5, 0.85) == Approx(1.2647654008373113e-10).epsilon(1e-10));
    CHECK(incomplete_beta(50000, 0.5, 0.9995) == Approx(1.5278881037481254e-12).epsilon(1e-8));
    CHECK(incomplete_beta(3, 4, 0.0) == 0.0);
    CHECK(incomplete_beta(3, 4, 1.0) == 1.0);
    for (const double x : {0.01, 0.3, 0.5, 0.8, 0.99}) {
        CHECK(incomplete_beta(7, 2.5, x) ==
              Approx(1.0 - incomplete_beta(2.5, 7, 1.0 - x)).margin(1e-14));
    }
}

TEST_CASE("statistics: Student's t has its tabulated values, and becomes the normal",
          "[verify][statistics]") {
    CHECK(student_two_sided(12.706204736, 1) == Approx(0.05).epsilon(1e-9));
    CHECK(student_two_sided(2.228138852, 10) == Approx(0.05).epsilon(1e-9));
    CHECK(student_two_sided(-3.169272667, 10) == Approx(0.01).epsilon(1e-7));
    CHECK(student_two_sided(2.0, 30) == Approx(0.054625044962983094).epsilon(1e-11));
    CHECK(student_two_sided(5.2, 255) == Approx(4.0922195347999975e-07).epsilon(1e-10));
    CHECK(student_two_sided(8.0, 15) == Approx(8.610930382707626e-07).epsilon(1e-11));
    CHECK(student_two_sided(40.0, 15) == Approx(1.1690661240866386e-16).epsilon(1e-10));
    CHECK(student_two_sided(6.0, 1e5) == Approx(1.9799294556017718e-09).epsilon(1e-7));
    const double inf = std::numeric_limits<double>::infinity();
    CHECK(student_two_sided(6.0, inf) == normal_two_sided(6.0));
    CHECK(student_two_sided(6.0, 9.9e5) == Approx(student_two_sided(6.0, 1.01e6)).epsilon(1e-3));
    CHECK(student_two_sided(inf, 3) == 0.0);
    CHECK(student_two_sided(0.0, 3) == 1.0);
}

TEST_CASE("statistics: the normal distribution and Sidak's share", "[verify][statistics]") {
    CHECK(normal_two_sided(1.959963985) == Approx(0.05).epsilon(1e-8));
    CHECK(normal_two_sided(-6.0) == Approx(1.973175290075389e-09).epsilon(1e-12));
    CHECK(normal_two_sided(10.0) == Approx(1.523970604832094e-23).epsilon(1e-11));
    CHECK(normal_two_sided(std::numeric_limits<double>::infinity()) == 0.0);
    CHECK(sidak(0.05, 1) == Approx(0.05));
    CHECK(sidak(0.05, 10) == Approx(0.005116196891823743).epsilon(1e-12));
    CHECK(sidak(1e-12, 1000000) == Approx(1e-18).epsilon(1e-6));
}

}  // namespace
