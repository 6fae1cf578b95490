#include <OpenImageIO/imageio.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/verify/capture_tools.h"
#include "verify/golden_image.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::Contains;

MeasuredImage noisy() {
    MeasuredImage image;
    image.width = 3;
    image.height = 2;
    image.samples = 4096;
    for (int i = 0; i < 6; ++i) {
        image.mean.push_back({0.5 * i, 1e-9, 65536.5});
        image.variance.push_back({1e-12, 0.0, 0.25 * i});
    }
    return image;
}

/// With channels in an order of their own.
void write_channels(const std::filesystem::path& file, const std::vector<std::string>& names) {
    OIIO::ImageSpec spec(1, 1, static_cast<int>(names.size()), OIIO::TypeDesc::FLOAT);
    spec.channelnames = names;
    std::vector<float> values(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) values[i] = static_cast<float>(i);
    const auto output = OIIO::ImageOutput::create(file.string());
    REQUIRE(output);
    REQUIRE(output->open(file.string(), spec));
    REQUIRE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()));
    REQUIRE(output->close());
}

}  // namespace

TEST_CASE("golden image: a file holds means, variances, samples and where it comes from",
          "[verify][golden]") {
    const TemporaryFolder folder;
    const Provenance provenance{{"scene", "coil"}, {"commit", "0123"}};
    write_golden_image(noisy(), provenance, folder / "a.exr");
    const GoldenImageFile read = read_golden_image(folder / "a.exr");
    CHECK(read.provenance == provenance);
    CHECK(read.image.samples == 4096);
    CHECK(read.image.width == 3);
    CHECK(read.image.height == 2);
    for (std::size_t pixel = 0; pixel < 6; ++pixel) {
        for (std::size_t c = 0; c < 3; ++c) {
            CHECK(read.image.mean[pixel][c] == static_cast<float>(noisy().mean[pixel][c]));
            CHECK(read.image.variance[pixel][c] == static_cast<float>(noisy().variance[pixel][c]));
        }
    }
    write_golden_image(noisy(), provenance, folder / "b.exr");
    CHECK(slurp(folder / "a.exr") == slurp(folder / "b.exr"));
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2);
}

TEST_CASE("golden image: channels are found by name, and none is taken for another",
          "[verify][golden]") {
    const TemporaryFolder folder;
    write_channels(folder / "a.exr",
                   {"variance.B", "B", "G", "variance.R", "A", "R", "variance.G"});
    const MeasuredImage image = read_golden_image(folder / "a.exr").image;
    CHECK(image.mean.front() == Color{5, 2, 1});
    CHECK(image.variance.front() == Color{3, 6, 0});
    CHECK(image.samples == 0);

    write_channels(folder / "b.exr", {"R", "G", "B", "variance.R"});
    CHECK(read_golden_image(folder / "b.exr").image.variance.empty());
    write_channels(folder / "c.exr", {"R", "G", "Y"});
    CHECK_THAT(error_of([&] { read_golden_image(folder / "c.exr"); }),
               Contains("c.exr") && Contains("expected channels R, G and B"));
    CHECK_THAT(error_of([&] { read_golden_image(folder / "none.exr"); }), Contains("none.exr"));
}

}  // namespace scotty::verify::test
