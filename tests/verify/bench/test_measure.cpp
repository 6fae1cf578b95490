#include <nlohmann/json.hpp>

#include "reference/base/error.h"
#include "scenes/scenes.h"
#include "tests/catch.h"
#include "tests/small_parameters.h"
#include "verify/backends/backend.h"
#include "verify/base/same_bits.h"
#include "verify/bench/measure.h"

namespace {

using namespace scotty;
using Catch::Matchers::ContainsSubstring;

verify::RenderSettings tiny(const std::string& backend) {
    verify::RenderSettings settings;
    settings.backend = backend;
    settings.parameters = scotty::test::small_picture(9, 5, 2);
    settings.threads = 1;
    settings.warm_ups = 1;
    settings.repeats = 3;
    return settings;
}

TEST_CASE("measure: the figures of a spread are measured ones", "[verify][bench]") {
    const verify::Spread one = verify::spread_of({2.0});
    CHECK(one.least == 2.0);
    CHECK(one.lower_quartile == 2.0);
    CHECK(one.median == 2.0);
    CHECK(one.upper_quartile == 2.0);
    CHECK(one.most == 2.0);
    const verify::Spread nine = verify::spread_of({9, 1, 8, 2, 7, 3, 6, 4, 5});
    CHECK(nine.least == 1.0);
    CHECK(nine.lower_quartile == 3.0);
    CHECK(nine.median == 5.0);
    CHECK(nine.upper_quartile == 7.0);
    CHECK(nine.most == 9.0);
    CHECK(nine.relative() == Approx(0.8));
    CHECK(verify::spread_of({4.0, 1.0, 3.0, 2.0}).median == 2.0);  // the lower of the two
    CHECK((one + nine).most == 11.0);
    CHECK(to_json(nine)["upper_quartile"] == 7.0);
    CHECK_THROWS_AS(verify::spread_of({}), reference::Error);
}

TEST_CASE("measure: every repeat counts, warm-ups do not, and the launches are one render's",
          "[verify][bench]") {
    const reference::Scene scene = scenes::load_scene("cornell");
    std::vector<verify::MeasuredRenders> all;
    for (const char* backend : {"emulator", "simt"}) {
        int said = 0;
        verify::RenderSettings settings = tiny(backend);
        settings.progress = [&](const std::string& what) {
            CHECK_THAT(what, ContainsSubstring(backend));
            ++said;
        };
        const verify::MeasuredRenders renders = measure_renders(scene, settings);
        CHECK(said == 1 + 3 + 1);
        CHECK(renders.backend == backend);
        REQUIRE(renders.all_seconds.size() == 3);
        CHECK(renders.seconds.median == verify::spread_of(renders.all_seconds).median);
        double sum = 0.0;
        std::size_t images = 0;
        for (const reference::LaunchRecord& launch : renders.launches) {
            sum += launch.seconds;
            images += launch.kind == reference::StageKind::reconstruct_image ? 1 : 0;
        }
        CHECK(images == 1);
        CHECK(sum > 0.0);
        CHECK(renders.launch_seconds.least <= sum);
        CHECK(sum <= renders.launch_seconds.most);
        CHECK(sum <= renders.seconds.median);
        CHECK(renders.device_bytes > 9u * 5 * 2 * 32);
        REQUIRE(renders.rays.size() == 3);
        CHECK(renders.rays[0].kind == "primary");
        CHECK(renders.rays[0].rays == 9u * 5 * 2);
        CHECK(renders.rays[1].kind == "shadow");
        CHECK(renders.rays[2].kind == "bounce 1");
        CHECK(renders.rays[2].rays <= renders.rays[0].rays);
        all.push_back(renders);
    }
    CHECK(verify::same_pixels(all[0].image, all[1].image));
    for (std::size_t i = 0; i < 3; ++i) CHECK(all[0].rays[i].rays == all[1].rays[i].rays);
}

TEST_CASE("measure: says which setting cannot be", "[verify][bench]") {
    const reference::Scene scene = scenes::load_scene("cornell");
    CHECK_THROWS_WITH(measure_renders(scene, tiny("abacus")),
                      ContainsSubstring("emulator, simt, cuda") && ContainsSubstring("abacus"));
    verify::RenderSettings never = tiny("emulator");
    never.repeats = 0;
    CHECK_THROWS_WITH(measure_renders(scene, never), ContainsSubstring("--repeats"));
    verify::RenderSettings fast = tiny("emulator");
    fast.parameters.arithmetic = reference::Arithmetic::fast;
    CHECK_THROWS_WITH(measure_renders(scene, fast), ContainsSubstring("--arithmetic"));
}

TEST_CASE("measure: a machine is described in one line and in JSON", "[verify][bench]") {
    const verify::MachineDescription machine = verify::machine_description();
    CHECK(machine.usable_threads >= 1);
    CHECK(machine.cores >= 1);
    CHECK(machine.cores <= machine.hardware_threads);
    CHECK(machine.memory_bytes > 1u << 28);
    const std::string line = one_line(machine);
    CHECK_THAT(line, ContainsSubstring(machine.cpu) && ContainsSubstring(machine.compiler) &&
                         !ContainsSubstring("\n"));
    const nlohmann::json json = to_json(machine);
    for (const char* key : {"cpu", "cores", "hardware_threads", "usable_threads", "memory_bytes",
                            "os", "build", "compiler", "vectors", "embree", "tbb", "cuda"}) {
        CHECK(json.contains(key));
    }
    CHECK(json["cuda"].is_null() == !machine.cuda.has_value());
    CHECK_THAT(json["build"].get<std::string>(), ContainsSubstring("-O"));
}

}  // namespace
