#include <OpenImageIO/imageio.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/temporary_folder.h"
#include "verify/images/image_file.h"

namespace {

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

std::ptrdiff_t files_in(const tests::TemporaryFolder& folder) {
    return std::distance(fs::directory_iterator(folder.path()), {});
}

reference::Image gradient() {
    reference::Image image{3, 2, {}};
    for (int i = 0; i < 6; ++i) {
        image.pixels.emplace_back(static_cast<float>(i) * 0.7f, 1e-7f, 65536.5f);
    }
    return image;
}

template <class T>
std::vector<T> read(const std::string& path, OIIO::TypeDesc type) {
    const auto input = OIIO::ImageInput::open(path);
    REQUIRE(input);
    CHECK(input->spec().width == 3);
    CHECK(input->spec().height == 2);
    std::vector<T> values(18);
    REQUIRE(input->read_image(0, 0, 0, 3, type, values.data()));
    return values;
}

TEST_CASE("image file: EXR holds the radiance bit for bit", "[verify][image]") {
    const tests::TemporaryFolder folder;
    const reference::Image image = gradient();
    verify::write_image(image, folder.file("a.exr"));
    const auto values = read<float>(folder.file("a.exr"), OIIO::TypeDesc::FLOAT);
    for (std::size_t i = 0; i < 6; ++i) {
        CHECK(values[3 * i] == image.pixels[i].x);
        CHECK(values[3 * i + 1] == image.pixels[i].y);
        CHECK(values[3 * i + 2] == image.pixels[i].z);
    }
    CHECK(files_in(folder) == 1);
}

TEST_CASE("image file: PNG holds sRGB of radiance times two to the exposure", "[verify][image]") {
    const tests::TemporaryFolder folder;
    reference::Image image{3, 2, std::vector<reference::Vec3>(6, reference::Vec3(0.215861f))};
    image.pixels[1] = reference::Vec3(7.0f, -1.0f, std::nanf(""));
    verify::write_image(image, folder.file("a.png"));
    auto values = read<unsigned char>(folder.file("a.png"), OIIO::TypeDesc::UINT8);
    CHECK(static_cast<int>(values[0]) == 128);  // the middle of sRGB
    CHECK(static_cast<int>(values[3]) == 255);
    CHECK(static_cast<int>(values[4]) == 0);
    CHECK(static_cast<int>(values[5]) == 0);
    verify::write_image(image, folder.file("a.png"), 8.0f);
    values = read<unsigned char>(folder.file("a.png"), OIIO::TypeDesc::UINT8);
    CHECK(static_cast<int>(values[0]) == 255);
    CHECK(files_in(folder) == 1);
}

TEST_CASE("image file: a name or folder that will not do is refused, nothing is left behind",
          "[verify][image]") {
    const tests::TemporaryFolder folder;
    CHECK_THROWS_WITH(verify::write_image(gradient(), folder.file("a.jpeg")),
                      ContainsSubstring("a.jpeg") && ContainsSubstring(".exr, .png or .npy"));
    CHECK_THROWS_WITH(verify::check_image_path(folder.file("no/such/a.png")),
                      ContainsSubstring("does not exist"));
    fs::create_directories(folder / "taken.png");
    std::ofstream(folder / "taken.png/inside") << "x";
    CHECK_THROWS_WITH(verify::write_image(gradient(), folder.file("taken.png")),
                      ContainsSubstring("taken.png"));
    CHECK(files_in(folder) == 1);
}

}  // namespace
