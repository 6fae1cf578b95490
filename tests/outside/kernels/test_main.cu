#include <saxpy.h>
#include <scotty/kernels.h>

#include <cstdio>

int main() {
    std::vector<float> x(128, 2.0f), y(128, 1.0f);
    saxpy(FACTOR, x, y);
    if (y[0] != 7.0f || y[127] != 7.0f || scotty::kernels::take_findings() != "") return 1;
    saxpy(1.0f, x, y, false);
    const std::string found = scotty::kernels::take_findings();
    std::printf("%s", found.c_str());
    if (found.find("data race") == std::string::npos ||
        found.find("saxpy.cu:") == std::string::npos)
        return 2;
    return scotty::kernels::take_findings() == "" ? 0 : 3;
}
