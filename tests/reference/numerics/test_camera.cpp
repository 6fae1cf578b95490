/// Camera rays against their closed form.
#include "tests/properties.h"

#include <cmath>
#include <set>

#include "reference/numerics/path.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"

using namespace scotty::reference;
using namespace scotty::reference::test;

namespace {

PathParameters image_of(std::uint32_t width, std::uint32_t height) {
    PathParameters parameters;
    parameters.image_width = width;
    parameters.image_height = height;
    return parameters;
}

/// Where a ray meets the image plane at distance 1: x to the right, y up.
Vec3 on_plane(const Camera& camera, const Ray& ray) {
    const float z = dot(ray.direction, camera.forward);
    return {dot(ray.direction, camera.right) / z, dot(ray.direction, camera.up) / z, z};
}

Camera random_camera(Random& random) {
    Camera camera;
    camera.position = uniform3(random, -10, 10);
    camera.forward = unit_vector(random);
    camera.right = normalize_or(cross(camera.forward, unit_vector(random)), Vec3(1, 0, 0));
    camera.up = cross(camera.right, camera.forward);
    camera.tan_half_fov = uniform(random, 0.05f, 3.0f);
    return camera;
}

}  // namespace

TEST_CASE("camera: every ray passes through its own pixel, with field of view and aspect",
          "[reference][camera]") {
    scotty::tests::check_property("closed form", [](std::uint32_t seed) {
        Random random(seed);
        const Camera camera = random_camera(random);
        const auto below = [&random](std::uint32_t end) {
            return static_cast<std::uint32_t>(random() % end);
        };
        const std::uint32_t width = 1 + below(300);
        const std::uint32_t height = 1 + below(300);
        PathParameters parameters = image_of(width, height);
        parameters.seed = seed;
        const std::uint32_t pixel = below(width * height);
        const Ray ray = primary_ray(camera, parameters, pixel, below(1000));
        RC_ASSERT(ray.origin == camera.position);
        RC_ASSERT((ray.t_min == 0.0f && ray.t_max == kInfinity));
        RC_ASSERT(std::abs(length(ray.direction) - 1.0f) < 1e-6f);
        // Undo the projection: columns run right, rows run down, both in [0, size).
        const Vec3 p = on_plane(camera, ray);
        const double aspect = static_cast<double>(width) / height;
        const double x = (p.x / (camera.tan_half_fov * aspect) + 1.0) / 2.0 * width;
        const double y = (1.0 - p.y / camera.tan_half_fov) / 2.0 * height;
        const double slack = 1e-3;  // float directions, up to 300 pixels
        RC_ASSERT(x > pixel % width - slack);
        RC_ASSERT(x < pixel % width + 1.0 + slack);
        const std::uint32_t row = pixel / width;
        RC_ASSERT(y > row - slack);
        RC_ASSERT(y < row + 1.0 + slack);
    });
}

TEST_CASE("camera: the corners of the image see the corners of the field of view",
          "[reference][camera]") {
    const Camera camera;  // at the origin, towards -z, tan 0.5
    const std::uint32_t width = 1000;
    const std::uint32_t height = 500;
    const PathParameters parameters = image_of(width, height);
    const auto plane = [&](std::uint32_t x, std::uint32_t y) {
        return on_plane(camera, primary_ray(camera, parameters, y * width + x, 0));
    };
    // A pixel is 0.002 wide and high at distance 1.
    CHECK(plane(0, 0).x == Approx(-1.0).margin(0.002));
    CHECK(plane(0, 0).y == Approx(0.5).margin(0.002));
    CHECK(plane(width - 1, 0).x == Approx(1.0).margin(0.002));
    CHECK(plane(0, height - 1).y == Approx(-0.5).margin(0.002));
    CHECK(plane(width - 1, height - 1).x == Approx(1.0).margin(0.002));
}

TEST_CASE("camera: the vertical field of view does not depend on the image's shape",
          "[reference][camera]") {
    Camera camera;
    camera.tan_half_fov = 0.75f;
    for (const std::uint32_t width : {1u, 100u, 1000u}) {
        const PathParameters parameters = image_of(width, 1000);
        const Ray top = primary_ray(camera, parameters, 0, 0);
        CHECK(on_plane(camera, top).y == Approx(0.75).margin(0.0015));
    }
}

TEST_CASE("camera: a horizontal field of view, where given, does not depend on the image's shape",
          "[reference][camera]") {
    Camera camera;
    camera.tan_half_width = 0.75f;
    for (const std::uint32_t height : {1u, 100u, 1000u}) {
        const PathParameters parameters = image_of(1000, height);
        const Vec3 corner = on_plane(camera, primary_ray(camera, parameters, 0, 0));
        CHECK(corner.x == Approx(-0.75).margin(0.0015));
        // Pixels stay square.
        CHECK(corner.y == Approx(0.75 * height / 1000.0).margin(0.0016));
    }
}

TEST_CASE("camera: jitter fills the pixel evenly and differs from sample to sample",
          "[reference][camera]") {
    const Camera camera;
    const PathParameters parameters = image_of(1, 1);
    double mean_x = 0.0;
    double mean_y = 0.0;
    std::set<float> distinct;
    constexpr std::uint32_t kSamples = 4096;
    for (std::uint32_t sample = 0; sample < kSamples; ++sample) {
        const Vec3 p = on_plane(camera, primary_ray(camera, parameters, 0, sample));
        mean_x += p.x / kSamples;
        mean_y += p.y / kSamples;
        distinct.insert(p.x);
    }
    // Uniform in [-0.5, 0.5]: standard deviation of the mean 0.2887 / 64 = 0.0045.
    CHECK(std::abs(mean_x) < 0.018);
    CHECK(std::abs(mean_y) < 0.018);
    CHECK(distinct.size() > kSamples - 10);
}
