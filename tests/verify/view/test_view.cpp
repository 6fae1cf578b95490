/// The parts of the live view; view_test.py and browser_test.py look at the whole.
#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "reference/contract/buffers.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/view/comparison.h"
#include "verify/view/features.h"
#include "verify/view/messages.h"
#include "verify/view/render_loop.h"
#include "verify/view/view_json.h"
#include "verify/view/view_library.h"
#include "verify/view/view_statistics.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;
using reference::Image;
using reference::StageKind;
using reference::Vec3;

Image gradient(std::uint32_t width, std::uint32_t height) {
    Image image{width, height, {}, {}};
    for (std::uint32_t p = 0; p < width * height; ++p) {
        const float value = std::exp2(static_cast<float>(p % 4096) / 128.0f - 24.0f);
        image.pixels.emplace_back(value, 2.0f * value, 0.5f * value);
    }
    return image;
}

}  // namespace

TEST_CASE("view: a camera message gives a camera that every scene accepts", "[view]") {
    const auto message = parse_message(
        R"({"type":"camera","id":5,"position":[3,4,5],"target":[0,1,0],"up":[0,1,0],"fov":60,"moving":true})");
    CHECK(message.id == 5);
    const auto& look = std::get<LookAt>(message.what);
    CHECK(look.moving);
    scotty::reference::Scene scene = scenes::load_scene("cornell");
    scene.camera = camera_of(look);
    CHECK_NOTHROW(validate_and_repair(scene));
    CHECK(scene.camera.tan_half_fov == Approx(std::tan(std::acos(-1.0) / 6.0)));
    // Far out, where squares of floats overflow.
    scene.camera = camera_of({{9e11f, -9e11f, 9e11f}, {0, 0, 0}, {0, 1, 0}, 0.5f, false});
    CHECK_NOTHROW(validate_and_repair(scene));
    CHECK_THROWS_WITH(camera_of({{0, 0, 0}, {0, 1, 0}, {0, 1, 0}, 0.5f, false}),
                      ContainsSubstring("no direction"));
}

TEST_CASE("view: what a message lacks or has too much of is said", "[view]") {
    CHECK_THROWS_WITH(parse_message("[]"), ContainsSubstring("JSON object"));
    CHECK_THROWS_WITH(parse_message(R"({"type":"fly"})"), ContainsSubstring("no such message"));
    CHECK_THROWS_WITH(parse_message(R"({"type":"pick","x":1})"), ContainsSubstring("\"y\""));
    CHECK_THROWS_WITH(parse_message(R"({"type":"show","what":"all"})"),
                      ContainsSubstring("distance"));
    CHECK_THROWS_WITH(parse_message(R"({"type":"show","exposure":65})"),
                      ContainsSubstring("-64 to 64"));
    const auto show = std::get<ShowAs>(parse_message(R"({"type":"show","tone":"filmic"})").what);
    CHECK(show.tone == ToneMap::filmic);
    CHECK_FALSE(show.exposure);
}

TEST_CASE("view: the table of a moving picture is at most a step from the curve", "[view]") {
    const Image image = gradient(64, 64);
    for (const ToneMap tone : {ToneMap::clamp, ToneMap::reinhard, ToneMap::filmic}) {
        const auto exact = to_srgb(image, 1.0f, tone, true).rgb;
        const auto quick = to_srgb(image, 1.0f, tone, false).rgb;
        for (std::size_t i = 0; i < exact.size(); ++i) {
            REQUIRE(std::abs(int{exact[i]} - int{quick[i]}) <= 1);
        }
    }
    Image odd{2, 1, {Vec3(std::nanf(""), -1.0f, INFINITY), Vec3(1.0f, 0.0f, -0.0f)}, {}};
    const std::vector<std::uint8_t> bytes{0, 0, 255, 255, 0, 0};
    CHECK(to_srgb(odd, 0.0f, ToneMap::clamp, true).rgb == bytes);
    CHECK(to_srgb(odd, 0.0f, ToneMap::clamp, false).rgb == bytes);
}

TEST_CASE("view: one pixel that differs is counted and outlined", "[view]") {
    const Image a = gradient(16, 8);
    Image b = a;
    CHECK(compare_pictures(a, b, 0.0f, ToneMap::clamp).different == 0);
    b.pixels[3 * 16 + 5].y = std::nextafter(b.pixels[3 * 16 + 5].y, 1.0f);
    const PictureComparison found = compare_pictures(a, b, 0.0f, ToneMap::clamp);
    CHECK(found.different == 1);
    CHECK(found.first_x == 5);
    CHECK(found.first_y == 3);
    CHECK(found.largest > 0.0);
    CHECK(found.difference.rgb[3 * (3 * 16 + 6)] == 255);  // beside it
    CHECK(found.difference.rgb[3 * (3 * 16 + 9)] == 0);    // and no farther
}

TEST_CASE("view: launches are added up by stage, level and kind of ray", "[view]") {
    const std::vector<scotty::reference::LaunchRecord> launches{
        {StageKind::primary_rays, 0, 0xffffffffu, 0xffffffffu, 0xffffffffu, 1, 100, 0.5},
        {StageKind::intersect_root, 0, 0, 0xffffffffu, 0, 1, 100, 0.25},
        {StageKind::intersect, 0, 0, 0xffffffffu, 1, 1, 70, 0.25},
        {StageKind::intersect_root, 0, 0, 0, 0, 1, 200, 1.0},
        {StageKind::intersect_root, 0, 1, 0xffffffffu, 0, 1, 90, 1.0}};
    const auto found = launch_statistics(launches);
    CHECK(found["rays"]["primary"] == 100);
    CHECK(found["rays"]["shadow"] == 200);
    CHECK(found["rays"]["bounce"] == 90);
    CHECK(found["queues"][0] == std::vector<int>{100, 70});
    CHECK(found["levels"][0] == nlohmann::json{0, 2.25});
}

TEST_CASE("view: false colours and paths are what the stages gave", "[view]") {
    for (const char* name : {"emulator", "simt"}) {
        INFO(name);
        PipelineInput input;
        input.scene = scenes::load_scene("coil");
        input.parameters = small_parameters();
        input.parameters.spp = 1;
        input.parameters.batch_rays = 100;
        const std::uint32_t width = input.parameters.image_width;
        const std::uint32_t height = input.parameters.image_height;
        input.bvh = build_wide_bvh(input.scene, {input.parameters.width, 4, 0});
        const Backend backend = backend_named(name, 0);
        const auto feature = [&](ViewSubject subject) {
            FeatureObserver observer(input.scene, width, height, subject);
            const auto pipeline = backend.pipeline(input, &observer);
            pipeline->render();
            FeatureImage image = observer.take();
            if (subject == ViewSubject::queues) {
                // Each entry of each queue of the primary rays is somebody's.
                double entries = 0.0;
                for (const auto& launch : pipeline->launches()) {
                    const bool primary =
                        launch.bounce == 0 && launch.light == scotty::reference::kNotApplicable;
                    if (primary && is_level_kernel(launch.kind)) {
                        entries += static_cast<double>(launch.items);
                    }
                }
                double sum = 0.0;
                for (const float value : image.values) sum += static_cast<double>(value);
                // What a device does not tell without being asked, its records leave at 0.
                CHECK((sum == entries) == (backend.name == "emulator"));
                CHECK(sum >= entries);
            }
            return image;
        };
        feature(ViewSubject::queues);
        const FeatureImage distance = feature(ViewSubject::distance);
        const FeatureImage primitive = feature(ViewSubject::primitive);
        const FeatureImage normal = feature(ViewSubject::normal);
        const FeatureImage bounces = feature(ViewSubject::bounces);
        std::size_t hits = 0;
        for (std::uint32_t pixel = 0; pixel < width * height; ++pixel) {
            PathObserver observer(pixel);
            backend.render(input, &observer);
            const TracedPath& path = observer.path();
            CHECK(path.vertices.empty() == std::isnan(distance.values[pixel]));
            if (path.vertices.empty()) continue;
            ++hits;
            CHECK(path.vertices[0].distance == distance.values[pixel]);
            CHECK(static_cast<float>(path.vertices[0].primitive) == primitive.values[pixel]);
            CHECK(reference::length(normal.normals[pixel]) == Approx(1.0f));
            const auto scatterings = path.vertices.size() - (path.escaped ? 0 : 1);
            CHECK(bounces.values[pixel] <= static_cast<float>(path.vertices.size()));
            CHECK(bounces.values[pixel] >= static_cast<float>(scatterings));
            for (const PathVertex& vertex : path.vertices) {
                CHECK(vertex.lights.size() <= input.parameters.light_samples);
            }
        }
        CHECK(hits > width * height / 2);
    }
}

TEST_CASE("view: a camera goes behind any scene", "[view]") {
    CHECK(seen_from("coil", "") == "coil");
    CHECK(seen_from("coil", "a.camera") == "coil#camera=a.camera");
    CHECK(seen_from("x.obj#lights=none", "a.camera") == "x.obj#lights=none,camera=a.camera");
    CHECK(seen_from("coil#camera=b.camera", "a.camera") == "coil#camera=a.camera");
    CHECK(shell_line({"a", "b c", "it's"}) == "a 'b c' 'it'\\''s'");
}

TEST_CASE("view: requests are judged by token, host and origin", "[view]") {
    const ViewServerOptions own{"127.0.0.1", 0, "secret"};
    const auto judge = [&](const std::string& text) {
        return view_module().judge_request(text, own);
    };
    const std::string rest = " HTTP/1.1\r\nHost: localhost:1\r\n\r\n";
    CHECK(judge("GET /secret/" + rest) == 200);
    CHECK(judge("GET /secret/camera?x" + rest) == 200);
    CHECK(judge("GET /secre/" + rest) == 404);
    CHECK(judge("GET /" + rest) == 404);
    CHECK(judge("POST /secret/" + rest) == 405);
    CHECK(judge("GET /secret/ HTTP/1.1\r\nHost: example.org\r\n\r\n") == 403);
    CHECK(judge("GET /secret/ HTTP/1.1\r\n\r\n") == 403);
    CHECK(judge("GET /secret/ HTTP/1.1\r\nHost: localhost\r\nOrigin: http://a\r\n\r\n") == 403);
    // Numbers, where it listens beyond the loopback; names never.
    const ViewServerOptions open{"0.0.0.0", 0, "secret"};
    const auto judge_open = [&](const std::string& host) {
        return view_module().judge_request("GET /secret/ HTTP/1.1\r\nHost: " + host + "\r\n\r\n",
                                           open);
    };
    CHECK(judge_open("192.168.0.7:80") == 200);
    CHECK(judge_open("[fe80::1]:80") == 200);
    CHECK(judge_open("example.org") == 403);
}

TEST_CASE("view: the newest of many requests is what is rendered", "[view]") {
    ViewState first;
    first.backend = "emulator";
    first.parameters.image_width = 48;
    first.parameters.image_height = 36;
    first.parameters.spp = 3;
    std::mutex mutex;
    std::vector<std::uint64_t> states;
    std::uint32_t samples = 0;
    std::condition_variable wake;
    RenderLoopEvents events;
    events.shown = [&](ShownPicture&& picture) {
        const std::lock_guard lock(mutex);
        states.push_back(picture.state);
        samples = picture.at_rest ? picture.samples : 0;
        wake.notify_all();
    };
    events.changed = [](const ChangeEffect&) {};
    events.failed = [](const std::string& why) { FAIL(why); };
    events.picked = [](std::uint64_t, const Pick&, const TracedPath&) {};
    RenderLoop loop(scenes::load_scene("cornell"), first, {}, events);
    loop.set_viewers(1);
    std::uint64_t last = 0;
    for (int i = 0; i < 500; ++i) {
        LookAt look{{0.0f, 1.0f, 3.0f + 0.001f * static_cast<float>(i)}, {0, 1, 0}, {0, 1, 0}};
        last = loop.look(camera_of(look), true);
    }
    std::unique_lock lock(mutex);
    wake.wait(lock, [&] { return !states.empty() && states.back() == last && samples == 3; });
    CHECK(std::is_sorted(states.begin(), states.end()));
    CHECK(states.size() < 100);
}

}  // namespace scotty::verify::test
