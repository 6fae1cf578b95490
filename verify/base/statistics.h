/// The distributions behind verdicts on noise.
#pragma once

#include <cstdint>

namespace scotty::verify {

/// P(|Z| >= |z|) for a standard normal Z; 0 if z is infinite.
double normal_two_sided(double z);

/// P(|T| >= |t|) for Student's t; `degrees_of_freedom` > 0; infinite means normal.
double student_two_sided(double t, double degrees_of_freedom);

/// I_x(a, b), the regularised incomplete beta function; a, b > 0, x in [0, 1]. By its continued
/// fraction (Abramowitz and Stegun 26.5.8), about 1e-13 relative.
double incomplete_beta(double a, double b, double x);

/// The probability for each of `tests` with which all together keep `probability` (Sidak 1967:
/// exact for independent tests, safe for two-sided ones on correlated normal numbers).
double sidak(double probability, std::uint64_t tests);

}  // namespace scotty::verify
