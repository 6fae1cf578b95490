/// The independent path tracer: closed forms, its noise, and that a run can be interrupted.
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "reference/base/error.h"
#include "reference/truth/path_tracer.h"
#include "tests/catch.h"
#include "tests/reference/meshes.h"
#include "tests/temporary_folder.h"

namespace scotty::reference::test {
namespace {

using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

void add_square(Scene& scene, const Vec3& corner, const Vec3& x, const Vec3& y,
                std::uint32_t material) {
    add_triangle(scene, corner, corner + x, corner + x + y);
    add_triangle(scene, corner, corner + x + y, corner + y);
    scene.material_of.end()[-1] = scene.material_of.end()[-2] = material;
}

Camera camera_at(const Vec3& position, float tan_half_fov) {
    Camera camera;  // looks along -z
    camera.position = position;
    camera.tan_half_fov = tan_half_fov;
    return camera;
}

PipelineParameters picture(std::uint32_t width, std::uint32_t height, std::uint32_t spp) {
    PipelineParameters p;
    p.image_width = width;
    p.image_height = height;
    p.spp = spp;
    p.seed = 5;
    return p;
}

/// A cube of side 2 seen from inside; all faces glow and reflect alike.
Scene glowing_box(float albedo, float emission) {
    Scene scene;
    scene.name = "box";
    Material wall;
    wall.reflectance = Vec3(albedo);
    wall.emission = Vec3(emission);
    scene.materials = {wall};
    add_square(scene, {-1, -1, 1}, {2, 0, 0}, {0, 0, -2}, 0);
    add_square(scene, {-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, 0);
    add_square(scene, {-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, 0);
    add_square(scene, {1, -1, 1}, {-2, 0, 0}, {0, 2, 0}, 0);
    add_square(scene, {-1, -1, 1}, {0, 0, -2}, {0, 2, 0}, 0);
    add_square(scene, {1, -1, -1}, {0, 0, 2}, {0, 2, 0}, 0);
    scene.camera = camera_at({0.1f, 0.2f, 0.3f}, 0.7f);
    return scene;
}

/// A wall at z = 0, seen from z = 1, lit by a square lamp behind the camera that faces it.
Scene lit_wall() {
    Scene scene;
    scene.name = "wall";
    Material white;
    white.reflectance = Vec3(0.8f, 0.5f, 0.25f);
    Material lamp;
    lamp.emission = Vec3(3.0f, 2.0f, 1.0f);
    lamp.emission_is_sampled = 1;
    scene.materials = {white, lamp};
    add_square(scene, {-20, -20, 0}, {40, 0, 0}, {0, 40, 0}, 0);
    Light light;
    light.kind = LightKind::parallelogram;
    light.position = Vec3(-1, -1, 2);
    light.edge_x = Vec3(0, 2, 0);
    light.edge_y = Vec3(2, 0, 0);
    light.normal = Vec3(0, 0, -1);
    light.radiance = lamp.emission;
    light.area = 4.0f;
    add_square(scene, light.position, light.edge_x, light.edge_y, 1);
    scene.lights = {light};
    scene.camera = camera_at({0, 0, 1}, 1e-4f);
    return scene;
}

/// Form factor of a differential patch that faces the middle of a square of half side `a` at
/// distance `h`: four times the corner rectangle's (Howell, configuration B-3).
double square_form_factor(double a, double h) {
    const double x = a / h;
    const double root = std::sqrt(1.0 + x * x);
    return 4.0 / (2.0 * 3.141592653589793) * 2.0 * (x / root) * std::atan(x / root);
}

bool same_bits(const SampleSums& a, const SampleSums& b) {
    const std::size_t bytes = a.sum.size() * sizeof(a.sum[0]);
    return a.samples == b.samples && a.sum.size() == b.sum.size() &&
           std::memcmp(a.sum.data(), b.sum.data(), bytes) == 0 &&
           std::memcmp(a.sum_of_squares.data(), b.sum_of_squares.data(), bytes) == 0;
}

std::string message_of(const Scene& scene, const PipelineParameters& p,
                       const PathTracerOptions& options) {
    try {
        trace_paths(scene, p, options);
    } catch (const Error& error) {
        CHECK(error.kind() == ErrorKind::bad_input);
        return error.what();
    }
    return "(no error)";
}

}  // namespace

TEST_CASE("path tracer: a closed box that glows evenly has the closed form's radiance",
          "[reference][path-tracer]") {
    const Scene box = glowing_box(0.75f, 0.5f);
    for (const std::uint32_t bounces : {0u, 1u, 4u}) {
        PipelineParameters p = picture(8, 8, 8);
        p.bounces = bounces;
        const SampleSums sums = trace_paths(box, p);
        const double expected = 0.5 * (1.0 - std::pow(0.75, bounces + 1.0)) / 0.25;
        for (std::size_t pixel = 0; pixel < sums.sum.size(); ++pixel) {
            CHECK(sums.mean(pixel)[1] == Approx(expected).epsilon(1e-12));
        }
    }
}

TEST_CASE("path tracer: a patch under a spot light gets its share by the angle",
          "[reference][path-tracer]") {
    Scene wall = lit_wall();
    wall.camera.tan_half_fov *= 0.01f;  // a patch over which the light's ramp is constant
    Light spot;
    spot.kind = LightKind::spot;
    spot.position = Vec3(0, 0, 1.5f);
    spot.radiance = Vec3(4.0f);
    set_spot_cone(spot, {0.9f, 0.5f});
    PipelineParameters p = picture(2, 2, 4);
    p.bounces = 0;
    for (const float cosine : {1.0f, 0.95f, 0.7f, 0.55f, 0.4f, -1.0f}) {
        const float sine = std::sqrt(1.0f - cosine * cosine);
        spot.normal = Vec3(sine, 0.0f, -cosine);
        wall.lights = {spot};
        const double ramp = std::clamp((cosine - 0.5) / (0.9 - 0.5), 0.0, 1.0);
        const double expected = 0.5 / 3.141592653589793 * 4.0 * ramp * ramp / 2.25;
        INFO("cosine " << cosine);
        CHECK(trace_paths(wall, p).mean(0)[1] == Approx(expected).margin(1e-3 * expected + 1e-9));
    }
}

TEST_CASE("path tracer: a patch under a square lamp gets the form factor's light",
          "[reference][path-tracer]") {
    const Scene wall = lit_wall();
    PipelineParameters p = picture(2, 2, 2000);
    p.bounces = 0;
    const double form_factor = square_form_factor(1.0, 2.0);
    // Whether paths sample lights or have to find them, it is the same light.
    for (const std::uint32_t light_samples : {1u, 0u}) {
        p.light_samples = light_samples;
        p.bounces = light_samples == 0 ? 1 : 0;
        const SampleSums sums = trace_paths(wall, p);
        double mean = 0.0;
        double variance = 0.0;
        for (std::size_t pixel = 0; pixel < 4; ++pixel) {
            mean += sums.mean(pixel)[0] / 4.0;
            variance += sums.variance_of_mean(pixel)[0] / 16.0;
        }
        CHECK(std::abs(mean - 3.0 * 0.8 * form_factor) < 4.5 * std::sqrt(variance));
        CHECK(variance > 0.0);
    }
}

TEST_CASE("path tracer: an interrupted run goes on to the same bits", "[reference][path-tracer]") {
    const tests::TemporaryFolder folder;
    const Scene wall = lit_wall();
    PipelineParameters p = picture(6, 4, 50);
    PathTracerOptions options;
    options.samples_a_round = 16;
    const SampleSums uninterrupted = trace_paths(wall, p, options);

    options.state = folder / "state";
    options.threads = 1;
    struct Interrupted {};
    options.progress = [](std::uint64_t done, std::uint64_t total) {
        CHECK(total == 50);
        if (done == 32) throw Interrupted();
    };
    CHECK_THROWS_AS(trace_paths(wall, p, options), Interrupted);
    REQUIRE(fs::exists(options.state));
    std::uint64_t first = 0;
    options.samples_a_round = 7;
    options.threads = 2;
    options.progress = [&](std::uint64_t done, std::uint64_t) {
        if (first == 0) first = done;
    };
    CHECK(same_bits(trace_paths(wall, p, options), uninterrupted));
    CHECK(first == 39);                                              // not from the start
    CHECK(same_bits(trace_paths(wall, p, options), uninterrupted));  // and when there is no more
}

TEST_CASE("path tracer: the state of another run or half a file is refused by name",
          "[reference][path-tracer]") {
    const tests::TemporaryFolder folder;
    const Scene wall = lit_wall();
    const PipelineParameters p = picture(3, 3, 4);
    PathTracerOptions options;
    options.state = folder / "state";
    trace_paths(wall, p, options);

    PipelineParameters other = p;
    other.bounces = 1;
    CHECK_THAT(message_of(wall, other, options),
               ContainsSubstring("state: expected 'bounces 1', found 'bounces 2'"));
    other = p;
    other.spp = 3;
    CHECK_THAT(message_of(wall, other, options), ContainsSubstring("holds 4 samples per pixel"));
    CHECK_THAT(message_of(glowing_box(0.5f, 1.0f), p, options),
               ContainsSubstring("expected 'scene "));
    const auto size = fs::file_size(options.state);
    std::fstream file(options.state, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(size / 2));
    file.put('!').flush();
    CHECK_THAT(message_of(wall, p, options), ContainsSubstring("is damaged"));
    fs::resize_file(options.state, size - 1);
    CHECK_THAT(message_of(wall, p, options), ContainsSubstring("cut short"));
    options.state = "/proc/no/state";
    CHECK_THAT(message_of(wall, p, options), ContainsSubstring("cannot be written"));
}

TEST_CASE("path tracer: the variance that it states is that between independent runs",
          "[reference][path-tracer]") {
    const Scene wall = lit_wall();
    PipelineParameters p = picture(4, 4, 32);
    constexpr int kRuns = 64;
    double stated = 0.0;
    double sum[16] = {};
    double squares[16] = {};
    for (int run = 0; run < kRuns; ++run) {
        p.seed = 100 + static_cast<std::uint64_t>(run);
        const SampleSums sums = trace_paths(wall, p);
        for (std::size_t pixel = 0; pixel < 16; ++pixel) {
            const double mean = sums.mean(pixel)[2];
            sum[pixel] += mean;
            squares[pixel] += mean * mean;
            stated += sums.variance_of_mean(pixel)[2] / (16.0 * kRuns);
        }
    }
    double between = 0.0;
    for (std::size_t pixel = 0; pixel < 16; ++pixel) {
        between += (squares[pixel] - sum[pixel] * sum[pixel] / kRuns) / (kRuns - 1) / 16.0;
    }
    // 1008 degrees of freedom: 4.5 % standard deviation.
    CHECK(between / stated == Approx(1.0).margin(0.2));
}

TEST_CASE("path tracer: other seeds give other pictures", "[reference][path-tracer]") {
    const Scene wall = lit_wall();
    PipelineParameters p = picture(4, 4, 8);
    const SampleSums a = trace_paths(wall, p);
    p.seed = 6;
    CHECK_FALSE(same_bits(a, trace_paths(wall, p)));
}

}  // namespace scotty::reference::test
