/// exp_minus against the double-precision exponential.
#include <cmath>
#include <limits>

#include "reference/numerics/exponential.h"
#include "tests/catch.h"

using scotty::reference::exp_minus;

TEST_CASE("exponential: relative error stays below the bound that is promised",
          "[reference][exponential]") {
    double worst = 0.0;
    for (int i = 0; i < 870000; ++i) {
        const float x = static_cast<float>(i) * 1.0e-4f;
        const double exact = std::exp(-static_cast<double>(x));
        if (x < 87.0f) worst = std::max(worst, std::abs(exp_minus(x) - exact) / exact);
    }
    INFO("largest relative error " << worst);
    CHECK(worst < 5.0e-7);
    CHECK(worst > 1.0e-9);  // something was measured
}

TEST_CASE("exponential: one at zero, zero far out, and for NaN", "[reference][exponential]") {
    CHECK(exp_minus(0.0f) == 1.0f);
    CHECK(exp_minus(std::numeric_limits<float>::denorm_min()) == 1.0f);
    CHECK(exp_minus(86.99f) > 0.0f);
    CHECK(exp_minus(86.99f) >= std::numeric_limits<float>::min());  // never subnormal
    CHECK(exp_minus(87.0f) == 0.0f);
    CHECK(exp_minus(std::numeric_limits<float>::infinity()) == 0.0f);
    CHECK(exp_minus(std::numeric_limits<float>::quiet_NaN()) == 0.0f);
}

TEST_CASE("exponential: never grows with x by more than rounding", "[reference][exponential]") {
    float before = 1.0f;
    for (int i = 1; i < 87000; ++i) {
        const float here = exp_minus(static_cast<float>(i) * 1.0e-3f);
        REQUIRE(here < before);
        before = here;
    }
}
