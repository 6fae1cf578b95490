// Compiled as everywhere: it calls what a file of CUDA text offers.
#include <catch2/catch.hpp>

#include <saxpy.h>
#include <scotty/kernels.h>

TEST_CASE("a plain file calls a function that launches") {
    std::vector<float> x(64, 1.0f), y(64, 1.0f);
    saxpy(1.0f, x, y);
    CHECK(y[63] == 2.0f);
    CHECK(scotty::kernels::take_findings() == "");
}
