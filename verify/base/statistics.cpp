#include "verify/base/statistics.h"

#include <cmath>
#include <limits>

#include "reference/base/assert.h"

namespace scotty::verify {
namespace {

/// Keeps Lentz's method off zero denominators.
double away_from_zero(double x) {
    constexpr double kTiny = 1e-300;
    return std::abs(x) < kTiny ? kTiny : x;
}

/// The continued fraction of I_x(a, b), by Lentz's method as modified by Thompson and Barnett.
double beta_fraction(double a, double b, double x) {
    double c = 1.0;
    double d = 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0));
    double product = d;
    const auto step = [&](double term) {
        d = 1.0 / away_from_zero(1.0 + term * d);
        c = away_from_zero(1.0 + term / c);
        product *= c * d;
        return std::abs(c * d - 1.0) < 4.0 * std::numeric_limits<double>::epsilon();
    };
    // It converges in about the square root of the larger parameter.
    const int most = 1000 + static_cast<int>(10.0 * std::sqrt(std::fmax(a, b)));
    for (int m = 1; m <= most; ++m) {
        const double twice = 2.0 * m;
        step(m * (b - m) * x / ((a + twice - 1.0) * (a + twice)));
        if (step(-(a + m) * (a + b + m) * x / ((a + twice) * (a + twice + 1.0)))) break;
    }
    return product;
}

}  // namespace

double normal_two_sided(double z) { return std::erfc(std::abs(z) / std::sqrt(2.0)); }

double incomplete_beta(double a, double b, double x) {
    SCOTTY_ASSERT(a, >, 0.0);
    SCOTTY_ASSERT(b, >, 0.0);
    if (x <= 0.0) return 0.0;
    if (x >= 1.0) return 1.0;
    const double front = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                  a * std::log(x) + b * std::log1p(-x));
    // On this side of the mean the fraction converges quickly.
    if (x < (a + 1.0) / (a + b + 2.0)) return front * beta_fraction(a, b, x) / a;
    return 1.0 - front * beta_fraction(b, a, 1.0 - x) / b;
}

double student_two_sided(double t, double degrees_of_freedom) {
    SCOTTY_ASSERT(degrees_of_freedom, >, 0.0);
    // From here on the normal distribution is within 1e-3 of it at a probability of 1e-12.
    if (degrees_of_freedom > 1e6) return normal_two_sided(t);
    const double t2 = t * t;
    if (!std::isfinite(t2)) return 0.0;
    return incomplete_beta(0.5 * degrees_of_freedom, 0.5,
                           degrees_of_freedom / (degrees_of_freedom + t2));
}

double sidak(double probability, std::uint64_t tests) {
    SCOTTY_ASSERT(tests, >, std::uint64_t{0});
    return -std::expm1(std::log1p(-probability) / static_cast<double>(tests));
}

}  // namespace scotty::verify
