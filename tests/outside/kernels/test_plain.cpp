// Compiled as everywhere: it calls what a file of CUDA text offers.
#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#include <catch2/catch.hpp>
#endif

#include <saxpy.h>
#include <scotty/kernels.h>

TEST_CASE("a plain file calls a function that launches") {
    std::vector<float> x(64, 1.0f), y(64, 1.0f);
    saxpy(1.0f, x, y);
    CHECK(y[63] == 2.0f);
    CHECK(scotty::kernels::take_findings() == "");
}
