/// The distributions that verdicts on noise are read from.
#pragma once

#include <cstdint>

namespace scotty::verify {

/// P(|Z| >= |z|) for a standard normal Z; 0 where z is infinite.
double normal_two_sided(double z);

/// P(|T| >= |t|) for Student's t; `degrees_of_freedom` > 0, infinite: normal.
double student_two_sided(double t, double degrees_of_freedom);

/// I_x(a, b), the regularised incomplete beta function; a, b > 0, x in [0, 1]. By its continued
/// fraction (Abramowitz and Stegun 26.5.8), about 1e-13 relative.
double incomplete_beta(double a, double b, double x);

/// Probability for each of `tests` such that all of them together keep `probability` (Sidak 1967:
/// exact for independent tests, safe for two-sided ones on correlated normal numbers).
double sidak(double probability, std::uint64_t tests);

}  // namespace scotty::verify
