#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
#else
#include <catch2/catch.hpp>
#endif

#include <saxpy.h>
#include <scotty/kernels.h>

__global__ void beyond(int* data) { data[threadIdx.x] = 1; }

TEST_CASE("saxpy adds, under every order") {
    for (const char* order : {"linear", "reversed", "shuffle:7"}) {
        REQUIRE(scotty::kernels::use_schedule(order));
        std::vector<float> x(256, 2.0f), y(256, 1.0f);
        saxpy(2.0f, x, y);
        CHECK(y == std::vector<float>(256, 5.0f));
        CHECK(scotty::kernels::take_findings() == "");
    }
    CHECK_FALSE(scotty::kernels::use_schedule("sideways"));
}

TEST_CASE("what is out of bounds is found, and the next kernel runs") {
    int* data = nullptr;
    cudaMalloc(&data, 32 * sizeof(int));
    beyond<<<1, 64>>>(data);
    CHECK(scotty::kernels::take_findings().find("out of bounds") == 0);
    beyond<<<1, 32>>>(data);
    CHECK(scotty::kernels::take_findings() == "");
    CHECK(cudaGetLastError() == cudaSuccess);
    cudaFree(data);
}
