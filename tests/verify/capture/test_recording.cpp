/// Two recordings of one picture are compared in all that they hold.

#include "tests/catch.h"
#include "verify/capture/recording.h"

namespace {

using scotty::reference::Image;
using scotty::reference::Vec3;
using scotty::verify::compare_images;

Image picture() { return {2, 1, {Vec3(1.0f), Vec3(2.0f)}, {Vec3(0.5f), Vec3(0.25f)}}; }

TEST_CASE("recording: images are compared pixel by pixel, their variances too",
          "[verify][recording]") {
    CHECK_FALSE(compare_images(picture(), picture(), 4));
    for (const std::size_t pixel : {0u, 1u}) {
        Image other = picture();
        other.pixels[pixel].z = 3.0f;
        auto failure = compare_images(picture(), other, 4);
        REQUIRE(failure);
        CHECK(failure->field == "image[" + std::to_string(pixel) + "]");
        CHECK(failure->ray == pixel * 4);

        other = picture();
        other.variance[pixel].y = -0.5f;
        failure = compare_images(picture(), other, 4);
        REQUIRE(failure);
        CHECK(failure->field == "variance[" + std::to_string(pixel) + "]");
    }
    Image none = picture();
    none.variance.clear();
    const auto failure = compare_images(picture(), none, 4);
    REQUIRE(failure);
    CHECK(failure->expected == "2 pixels");
    CHECK(failure->found == "0 pixels");
}

}  // namespace
