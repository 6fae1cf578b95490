/// Images from files: by channel name, in linear radiance, or refused with the file named.
#include <OpenImageIO/imageio.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/verify/image_tools.h"
#include "verify/images/image_file.h"
#include "verify/images/image_read.h"

namespace {

using namespace scotty;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
using verify::read_image;

verify::MeasuredImage noisy_image() {
    verify::MeasuredImage image = smooth_image(5, 3);
    for (const verify::Color& color : image.mean) {
        image.variance.push_back({color[0] * 0.5, color[1] * 0.25, color[2] * 0.125});
    }
    image.samples = 256;
    return image;
}

/// Any channels, any type; values count up from `first`.
void write_raw(const std::string& path, const std::vector<std::string>& channels,
               OIIO::TypeDesc type, float first = 0.25f, int crop = 0) {
    OIIO::ImageSpec spec(4, 2, static_cast<int>(channels.size()), type);
    spec.channelnames = channels;
    spec.full_width = 4 + crop;
    spec.attribute("oiio:UnassociatedAlpha", 1);  // else colours are divided by alpha
    std::vector<float> values(8 * channels.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
        values[i] = first + 0.01f * static_cast<float>(i);
    }
    const auto output = OIIO::ImageOutput::create(path);
    REQUIRE(output);
    REQUIRE(output->open(path, spec));
    REQUIRE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()));
    REQUIRE(output->close());
}

TEST_CASE("image reading: what was written with its noise comes back bit for bit",
          "[verify][image]") {
    const TemporaryFolder folder;
    verify::MeasuredImage image = noisy_image();
    image.mean[4] = {-0.0, 1e-42, 6.5e37};
    for (verify::Color& color : image.mean) {
        for (double& value : color) value = static_cast<float>(value);
    }
    verify::write_measured_image(
        image, folder.file("a.exr"),
        {{"scotty:scene", "coil"}, {"scotty:seed", "18446744073709551615"}});
    const verify::ReadImage read = read_image(folder.file("a.exr"));
    CHECK(read.image.width == 5);
    CHECK(read.image.height == 3);
    CHECK(read.image.samples == 256);
    CHECK(read.image.paths_per_sample == 1);
    CHECK(read.encoding == "float");
    CHECK(read.attributes.at("scotty:scene") == "coil");
    CHECK(read.attributes.at("scotty:seed") == "18446744073709551615");
    REQUIRE(read.image.mean.size() == image.mean.size());
    REQUIRE(read.image.variance.size() == image.mean.size());
    for (std::size_t i = 0; i < image.mean.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            CHECK(read.image.mean[i][c] == image.mean[i][c]);
            CHECK(read.image.variance[i][c] == static_cast<float>(image.variance[i][c]));
        }
    }
    CHECK(std::signbit(read.image.mean[4][0]));
}

TEST_CASE("image writing: the same image is the same file, and nothing is left beside it",
          "[verify][image]") {
    const TemporaryFolder folder;
    verify::MeasuredImage image = noisy_image();
    image.paths_per_sample = 16;
    verify::write_measured_image(image, folder.file("a.exr"), {{"scotty:scene", "coil"}});
    verify::write_measured_image(image, folder.file("b.exr"), {{"scotty:scene", "coil"}});
    CHECK(slurp(folder.file("a.exr")).size() > 300);
    CHECK(slurp(folder.file("a.exr")) == slurp(folder.file("b.exr")));
    CHECK(read_image(folder.file("a.exr")).image.paths_per_sample == 16);
    CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 2);
    CHECK_THROWS_WITH(verify::write_measured_image(image, folder.file("a.png")),
                      ContainsSubstring("a.png") && ContainsSubstring(".exr"));
}

TEST_CASE("image reading: an image without noise has none, and alpha is left", "[verify][image]") {
    const TemporaryFolder folder;
    write_raw(folder.file("a.exr"), {"R", "G", "B", "A"}, OIIO::TypeDesc::HALF);
    const verify::ReadImage read = read_image(folder.file("a.exr"));
    CHECK(read.encoding == "half");
    CHECK(read.image.variance.empty());
    CHECK(read.image.samples == 0);
    CHECK(read.image.mean[1][0] == Approx(0.29).margin(1e-3));
    CHECK(read.image.mean[1][2] == Approx(0.31).margin(1e-3));
}

TEST_CASE("image reading: channels go by name, whatever their order", "[verify][image]") {
    const TemporaryFolder folder;
    write_raw(folder.file("a.tif"), {"B", "G", "R"}, OIIO::TypeDesc::FLOAT);
    write_raw(folder.file("a.exr"), {"B", "variance.B", "G", "variance.R", "R", "variance.G"},
              OIIO::TypeDesc::FLOAT);
    const verify::MeasuredImage image = read_image(folder.file("a.exr")).image;
    CHECK(image.mean[0][0] == Approx(0.29));
    CHECK(image.mean[0][1] == Approx(0.27));
    CHECK(image.mean[0][2] == Approx(0.25));
    CHECK(image.variance[0][0] == Approx(0.28));
    CHECK(image.variance[0][1] == Approx(0.30));
    CHECK(image.variance[0][2] == Approx(0.26));
}

TEST_CASE("image reading: a PNG is decoded from sRGB, colours not times alpha", "[verify][image]") {
    const TemporaryFolder folder;
    write_raw(folder.file("a.png"), {"R", "G", "B"}, OIIO::TypeDesc::UINT8, 128.0f / 255.0f);
    CHECK(read_image(folder.file("a.png")).image.mean[0][0] == Approx(0.215861).epsilon(1e-5));
    write_raw(folder.file("b.png"), {"R", "G", "B", "A"}, OIIO::TypeDesc::UINT8, 128.0f / 255.0f);
    CHECK(read_image(folder.file("b.png")).image.mean[0][0] == Approx(0.215861).epsilon(0.02));
    write_raw(folder.file("grey.png"), {"Y"}, OIIO::TypeDesc::UINT8, 128.0f / 255.0f);
    const verify::ReadImage grey = read_image(folder.file("grey.png"));
    CHECK(grey.encoding == "uint8");
    for (const double value : grey.image.mean[0]) CHECK(value == Approx(0.215861).epsilon(1e-5));
}

TEST_CASE("image reading: integers that say they are linear are not decoded", "[verify][image]") {
    const TemporaryFolder folder;
    for (const bool by_gamma : {true, false}) {
        OIIO::ImageSpec spec(4, 2, 3, OIIO::TypeDesc::UINT8);
        if (by_gamma) spec.attribute("oiio:Gamma", 1.0f);
        spec.attribute("oiio:ColorSpace", by_gamma ? "GammaCorrected" : "linear");
        const std::vector<std::uint8_t> values(24, 128);
        const auto output = OIIO::ImageOutput::create(folder.file("a.png"));
        REQUIRE(output->open(folder.file("a.png"), spec));
        REQUIRE(output->write_image(OIIO::TypeDesc::UINT8, values.data()));
        REQUIRE(output->close());
        CHECK(read_image(folder.file("a.png")).image.mean[0][0] == Approx(128.0 / 255.0));
    }
}

TEST_CASE("image reading: a gamma of the file is undone, 2.2 stands for sRGB", "[verify][image]") {
    const TemporaryFolder folder;
    const auto decoded = [&](float gamma) {
        OIIO::ImageSpec spec(4, 2, 3, OIIO::TypeDesc::UINT8);
        spec.attribute("oiio:Gamma", gamma);
        spec.attribute("oiio:ColorSpace", "GammaCorrected");
        const std::vector<std::uint8_t> values(24, 128);
        const auto output = OIIO::ImageOutput::create(folder.file("a.png"));
        REQUIRE(output->open(folder.file("a.png"), spec));
        REQUIRE(output->write_image(OIIO::TypeDesc::UINT8, values.data()));
        REQUIRE(output->close());
        return read_image(folder.file("a.png")).image.mean[0][0];
    };
    CHECK(decoded(1.8f) == Approx(std::pow(128.0 / 255.0, 1.8)).epsilon(1e-4));
    CHECK(decoded(2.2f) == Approx(0.215861).epsilon(1e-5));
}

TEST_CASE("image reading: parts and layers are chosen by name, and the others are told",
          "[verify][image]") {
    const TemporaryFolder folder;
    const std::string path = folder.file("parts.exr");
    const std::vector<std::string> channels{"R", "G", "B", "diffuse.R", "diffuse.G", "diffuse.B"};
    std::vector<OIIO::ImageSpec> specs;
    for (const char* name : {"left", "right"}) {
        OIIO::ImageSpec spec(4, 2, 6, OIIO::TypeDesc::FLOAT);
        spec.channelnames = channels;
        spec.attribute("oiio:subimagename", name);
        specs.push_back(spec);
    }
    const auto output = OIIO::ImageOutput::create(path);
    REQUIRE(output->open(path, 2, specs.data()));
    for (int part = 0; part < 2; ++part) {
        if (part == 1) REQUIRE(output->open(path, specs[1], OIIO::ImageOutput::AppendSubimage));
        std::vector<float> values;
        for (int i = 0; i < 8; ++i) {
            for (int c = 0; c < 6; ++c) values.push_back(static_cast<float>(10 * part + c));
        }
        REQUIRE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()));
    }
    REQUIRE(output->close());
    const verify::ReadImage first = read_image(path);
    CHECK(first.image.mean[0] == verify::Color{0.0, 1.0, 2.0});
    CHECK(first.not_read == std::vector<std::string>{"part 'right'", "layer 'diffuse'"});
    CHECK(read_image(path, {"right", ""}).image.mean[0] == verify::Color{10.0, 11.0, 12.0});
    CHECK(read_image(path, {"1", "diffuse"}).image.mean[0] == verify::Color{13.0, 14.0, 15.0});
    CHECK(read_image(path, {"right", ""}).not_read.front() == "part 'left'");
    CHECK_THROWS_WITH(read_image(path, {"middle", ""}),
                      ContainsSubstring("no part 'middle'") && ContainsSubstring("left, right"));
    CHECK_THROWS_WITH(read_image(path, {"", "glossy"}), ContainsSubstring("glossy.R"));
}

TEST_CASE("image reading: other channels, crops and folders are refused", "[verify][image]") {
    const TemporaryFolder folder;
    write_raw(folder.file("depth.exr"), {"Z", "beauty.R"}, OIIO::TypeDesc::FLOAT);
    CHECK_THROWS_WITH(read_image(folder.file("depth.exr")), ContainsSubstring("depth.exr") &&
                                                                ContainsSubstring("R, G, B") &&
                                                                ContainsSubstring("beauty.R"));
    write_raw(folder.file("two.exr"), {"R", "G"}, OIIO::TypeDesc::FLOAT);
    CHECK_THROWS_WITH(read_image(folder.file("two.exr")), ContainsSubstring("expected all"));
    write_raw(folder.file("half.exr"), {"R", "G", "B", "variance.R"}, OIIO::TypeDesc::FLOAT);
    CHECK_THROWS_WITH(read_image(folder.file("half.exr")), ContainsSubstring("variance.G"));
    write_raw(folder.file("crop.exr"), {"R", "G", "B"}, OIIO::TypeDesc::FLOAT, 0.25f, 3);
    CHECK_THROWS_WITH(read_image(folder.file("crop.exr")),
                      ContainsSubstring("4x2") && ContainsSubstring("7x2"));
    CHECK_THROWS_WITH(read_image(folder.path().string()), ContainsSubstring("found a folder"));
}

TEST_CASE("image reading: a missing, foreign, empty or half-written file is refused by name",
          "[verify][image]") {
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(read_image(folder.file("none.exr")),
                      ContainsSubstring("none.exr") && ContainsSubstring("no such file"));
    for (const char* name : {"text.exr", "text.png"}) {
        std::ofstream(folder.file(name)) << "not an image";
        CHECK_THROWS_WITH(read_image(folder.file(name)), ContainsSubstring(name));
    }
    std::ofstream(folder.file("empty.exr")).flush();
    CHECK_THROWS_WITH(read_image(folder.file("empty.exr")), ContainsSubstring("empty.exr"));

    const verify::MeasuredImage image = smooth_image(61, 47);
    verify::write_measured_image(image, folder.file("whole.exr"));
    reference::Image picture{61, 47, {}};
    for (const verify::Color& c : image.mean) {
        picture.pixels.emplace_back(static_cast<float>(c[0]), static_cast<float>(c[1]),
                                    static_cast<float>(c[2]));
    }
    verify::write_image(picture, folder.file("whole.png"));
    for (const std::string extension : {".exr", ".png"}) {
        const std::string whole = slurp(folder.file(("whole" + extension).c_str()));
        for (const double share : {0.02, 0.3, 0.6, 0.9}) {
            const std::string cut = folder.file(("cut" + extension).c_str());
            const auto size = static_cast<std::size_t>(share * static_cast<double>(whole.size()));
            std::ofstream(cut, std::ios::binary) << whole.substr(0, size);
            INFO(cut << ", " << share << " of it");
            CHECK_THROWS_AS(read_image(cut), reference::Error);
        }
    }
}

TEST_CASE("image reading: an array comes back with the noise and the facts beside it",
          "[verify][image]") {
    const TemporaryFolder folder;
    verify::MeasuredImage image = noisy_image();
    for (std::vector<verify::Color>* colors : {&image.mean, &image.variance}) {
        for (verify::Color& color : *colors) {
            for (double& value : color) value = static_cast<float>(value);
        }
    }
    const std::string file = folder.file("a.npy");
    verify::write_measured_image(
        image, file, {{"scotty:scene", "coil"}, {"scotty:parameters", R"({"seed": 7})"}});
    const verify::ReadImage read = read_image(file);
    CHECK(read.image.mean == image.mean);
    CHECK(read.image.variance == image.variance);
    CHECK(read.image.samples == 256);
    CHECK(read.attributes.at("scotty:scene") == "coil");
    CHECK(read.attributes.at("scotty:parameters") == R"({"seed":7})");

    image.variance.clear();  // what was there before is not this picture's
    verify::write_measured_image(image, file);
    CHECK(read_image(file).image.variance.empty());
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
        CHECK(entry.path().extension() != ".unfinished");
    }
}

TEST_CASE("image reading: a bit flipped in the pixels of an EXR is noticed", "[verify][image]") {
    const TemporaryFolder folder;
    verify::write_measured_image(smooth_image(61, 47), folder.file("a.exr"));
    std::string bytes = slurp(folder.file("a.exr"));
    bytes[bytes.size() * 2 / 3] = static_cast<char>(bytes[bytes.size() * 2 / 3] ^ 0x10);
    std::ofstream(folder.file("a.exr"), std::ios::binary) << bytes;
    CHECK_THROWS_WITH(read_image(folder.file("a.exr")), ContainsSubstring("a.exr"));
}

}  // namespace
