// The page of the queue debugger: its data held to the buffers, and the page to itself in a
// browser.
#include <zlib.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "reference/base/write_file.h"
#include "tests/verify/browser_tools.h"
#include "tests/verify/command_tools.h"
#include "tests/verify/queue_pages.h"
#include "verify/queues/queues_json.h"
#include "verify/queues/queues_page.h"
#include "verify/report/report.h"

using namespace scotty::verify;
using namespace scotty::verify::test;
using nlohmann::json;

namespace {

constexpr const char* kFaulty = "bounce0/level1/intersect";

std::string base64_bytes(const std::string& text) {
    const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    std::uint32_t bits = 0;
    std::size_t have = 0;
    for (const char c : text) {
        if (c == '=') break;
        bits = bits << 6 | static_cast<std::uint32_t>(letters.find(c));
        have += 6;
        if (have < 8) continue;
        have -= 8;
        out += static_cast<char>(bits >> have & 0xffu);
    }
    return out;
}

const PipelineInput& input_of(std::uint32_t size, const char* scene = "spheres") {
    static std::map<std::pair<std::uint32_t, std::string>, PipelineInput> made;
    PipelineInput& input = made[{size, scene}];
    if (input.bvh.node_refs.empty()) {
        input.scene = scotty::scenes::load_scene(scene);
        input.parameters.image_width = input.parameters.image_height = size;
        input.parameters.spp = 1;
        input.parameters.bounces = size < 64 ? 1 : 2;
        input.parameters.light_samples = size < 64 ? 1 : 2;
        input.bvh = build_wide_bvh(input.scene, {8, 4, 0});
    }
    return input;
}

/// A run, and the same with a ray lost on its way to level 2.
struct Runs {
    TemporaryFolder folder;
    LostRay lost;
    Capture a, b;
    Queues of_a{a}, of_b{b};
    explicit Runs(const PipelineInput& input)
        : a(make_faulty_capture(folder / "A", input, "", {})),
          b(make_faulty_capture(folder / "B", input, kFaulty,
                                [&](const auto& stage) { lose_a_ray(stage, lost); })) {}
};
const Runs& small_runs() {
    static const Runs runs(input_of(24));
    return runs;
}

/// An array of the page as the page reads it.
template <class T>
std::vector<T> array_of(const json& page, const json& number) {
    const json& array = page["pool"]["arrays"][number.get<std::size_t>()];
    const std::string packed = base64_bytes(page["pool"]["blobs"][array[0].get<std::size_t>()]);
    std::vector<unsigned char> bytes(std::size_t{1} << 22);
    uLongf size = bytes.size();
    REQUIRE(uncompress(bytes.data(), &size, reinterpret_cast<const Bytef*>(packed.data()),
                       packed.size()) == Z_OK);
    const std::string type = array[1];
    const std::size_t width = type == "u8" ? 1 : type == "u16" ? 2 : 4;
    std::vector<T> out(array[3].get<std::size_t>());
    for (std::size_t i = 0; i < out.size(); ++i) {
        std::memcpy(&out[i], bytes.data() + array[2].get<std::size_t>() + i * width, width);
    }
    return out;
}

json launch_of(const json& page, const std::string& name) {
    for (const json& launch : page["launches"]) {
        if (launch["name"] == name) return launch;
    }
    FAIL("no launch " << name);
    return {};
}

TEST_CASE("queues page: counts, queues and rays are those of the buffers", "[queues][page]") {
    const Runs& runs = small_runs();
    const json page = queues_page_data(runs.of_a, nullptr, {});
    CHECK(page["divergences"].empty());
    CHECK(page["launches"].size() == runs.a.stages().size());
    const json launch = launch_of(page, kFaulty);
    const LoadedStage stage = runs.a.load(*runs.a.find(kFaulty));
    const auto counts = stage.view.get<std::uint32_t>("node_counts");
    const auto offsets = stage.view.get<std::uint32_t>("queue_offsets");
    const auto queue = stage.view.get<std::uint32_t>("queue");
    CHECK(array_of<std::uint32_t>(page, launch["counts"]) ==
          std::vector<std::uint32_t>(counts.begin(), counts.end()));
    std::vector<std::uint32_t> entries;
    for (std::size_t node = 0; node < counts.size(); ++node) {
        entries.insert(entries.end(), queue.begin() + offsets[node],
                       queue.begin() + offsets[node] + counts[node]);
    }
    CHECK(array_of<std::uint32_t>(page, launch["arrays"]["queue"]) == entries);
    const auto rays = stage.view.get<float>("rays");
    CHECK(array_of<float>(page, launch["arrays"]["rays"]) ==
          std::vector<float>(rays.begin(), rays.end()));
    CHECK(array_of<std::uint32_t>(page, launch["arrays"]["did"]).size() == entries.size());
}

TEST_CASE("queues page: it opens at the launch, node and ray that diverge first",
          "[queues][page]") {
    const Runs& runs = small_runs();
    const std::uint32_t node = runs.of_a.bvh().level_begins[2] + runs.lost.child;
    const json page = queues_page_data(runs.of_a, &runs.of_b, {});
    const auto at = page["first"]["launch"].get<std::size_t>();
    CHECK(page["launches"][at]["name"] == kFaulty);
    CHECK(page["first"]["node"] == node);
    CHECK(page["launches"][at]["verdict"] == "differs");
    for (std::size_t i = 0; i < at; ++i) CHECK(page["launches"][i]["verdict"] == "identical");

    // The invariants of B say who was lost and who is there twice; those of A hold.
    std::map<std::string, json> broken;
    for (const json& failure : page["launches"][at]["invariants"]["b"]) {
        broken[failure["name"]] = failure["ray"];
    }
    CHECK(broken.at("required-present") == runs.lost.ray);
    CHECK(broken.at("no-duplicate") == runs.lost.twice);
    CHECK(page["launches"][at]["invariants"]["a"].empty());

    // One level down the model's pairs say the same of the queue.
    const json below = launch_of(page, "bounce0/level2/intersect");
    const auto differences = array_of<std::uint32_t>(page, below["differences"]);
    CHECK(differences.at(runs.lost.child) == 2);  // one missing, one extra
    const auto nodes = array_of<std::uint32_t>(page, below["pairs"]["node"]);
    CHECK(std::find(nodes.begin(), nodes.end(), node) != nodes.end());

    const json alone = queues_page_data(runs.of_b, nullptr, {});  // without the other run, too
    CHECK(alone["launches"][alone["first"]["launch"].get<std::size_t>()]["name"] == kFaulty);
    PageRequest request;
    request.node = node;
    request.ray = 3;
    const json asked = queues_page_data(runs.of_a, nullptr, request);
    CHECK(asked["launches"][asked["first"]["launch"].get<std::size_t>()]["level"] == 2);
    CHECK(asked["first"]["ray"] == 3);
}

TEST_CASE("queues page: a 64x64 capture makes a page of less than 8 MB with every launch in it",
          "[queues][page]") {
    const Runs runs(input_of(64));
    const std::string page = queues_page(runs.of_a, &runs.of_b, {});
    CHECK(page.size() < 8'000'000);
    const std::string begin = "id=\"queues-data\">";
    const std::size_t at = page.find(begin) + begin.size();
    const json data = json::parse(page.substr(at, page.find("</script>", at) - at));
    for (const json& launch : data["launches"]) CHECK(launch.contains("arrays"));
}

TEST_CASE("queues page: where room is short the launches around the divergence go first",
          "[queues][page]") {
    const Runs& runs = small_runs();
    PageRequest request;
    request.room = 200'000;
    const json page = queues_page_data(runs.of_a, &runs.of_b, request);
    const auto at = page["first"]["launch"].get<std::size_t>();
    std::size_t embedded = 0;
    for (const json& launch : page["launches"]) {
        embedded += launch.contains("arrays") ? 1 : 0;
        const bool level = launch["kind"] == "intersect" || launch["kind"] == "intersect_root";
        CHECK(launch.contains("counts") == level);
    }
    CHECK(page["launches"][at].contains("arrays"));
    CHECK(embedded > 2);
    CHECK(embedded < page["launches"].size());
    request.launch = page["launches"].back()["launch"];
    const json end = queues_page_data(runs.of_a, &runs.of_b, request);
    CHECK(end["launches"].back().contains("arrays"));
}

TEST_CASE("queues page: --html writes it, and a part of a run says that it is not checked",
          "[queues][page]") {
    const TemporaryFolder folder;
    make_capture(folder.file("part"), small_parameters(), {}, {}, {"bounce0/*", "primary_rays"});
    const std::string page = folder.file("page.html");
    const Result result = scotty_here("queues '" + folder.file("part") + "' --html '" + page + "'");
    CHECK(result.exit_code == kExitPassed);
    CHECK(slurp(page).find("\"checked\":false") != std::string::npos);
    const std::string text = slurp(page);
    CHECK(text.find("default-src 'none'") != std::string::npos);
    for (const char* fetches : {"http:", "https:", "src=", "<link", "@import", "url("}) {
        INFO(fetches);
        CHECK(text.find(fetches) == std::string::npos);
    }
    CHECK(scotty_here("queues '" + folder.file("part") + "' --pixel 99,0 --html '" + page + "'")
              .exit_code == kExitUsage);
}

/// Histories that the model tells, for the page to be held to.
std::string with_told(const std::string& page, const std::vector<const Queues*>& runs,
                      std::uint32_t step = 37) {
    json told = json::array();
    for (std::size_t side = 0; side < runs.size(); ++side) {
        for (std::uint32_t batch = 0; batch < runs[side]->batches(); ++batch) {
            std::vector<std::uint32_t> rays;
            for (std::uint32_t r = 0; r < runs[side]->ray_count(batch); r += step) {
                rays.push_back(r);
            }
            for (const RayHistory& history : histories(*runs[side], batch, rays)) {
                told.push_back({{"side", side == 0 ? "a" : "b"}, {"history", to_json(history)}});
            }
        }
    }
    const std::string data = "<script type=\"application/json\" id=\"queues-data\">";
    return replaced(
        page, data,
        "<script type=\"application/json\" id=\"told\">" + told.dump() + "</script>" + data);
}

TEST_CASE("queues page: in a browser it passes its own test, which sees every planted fault",
          "[queues][page][browser]") {
    if (!browser_is_here()) {
        if (std::getenv("SCOTTY_REQUIRE_BROWSER") != nullptr) FAIL("chromium is not installed");
        WARN("not run: chromium is not installed (Debian: chromium)");
        return;
    }
    const Runs& runs = small_runs();
    const TemporaryFolder folder;
    auto parameters = small_parameters();  // several batches, samples, packed hits, a blunt name
    parameters.batch_rays = 100;
    parameters.hit_mode = scotty::reference::HitMode::packed;
    const Capture odd_capture = make_capture(folder / "<b>&'x'", parameters);
    const Queues odd(odd_capture);
    parameters = small_parameters();  // subtrees below two levels, passes, any-hit shadow rays
    parameters.queue_levels = 2;
    parameters.samples_per_pass = 1;
    parameters.shadow_query = scotty::reference::ShadowQuery::any;
    const Capture cut_capture = make_capture(folder / "cut", parameters);
    const Queues cut(cut_capture);
    PageRequest short_of_room;
    short_of_room.room = 330'000;
    const std::string plain = queues_page(runs.of_a, &runs.of_b, {});
    const std::string diff = with_told(plain, {&runs.of_a, &runs.of_b}, 97);
    const std::string data = queues_page_data(runs.of_a, &runs.of_b, {})["pool"]["blobs"][1];
    std::string spoiled = data;
    spoiled[spoiled.size() / 2] = spoiled[spoiled.size() / 2] == 'A' ? 'B' : 'A';
    // Faults that do not hide one another go into one page: a browser's time goes by pages.
    using Fault = std::pair<const char*, const char*>;
    const auto with = [&](const std::vector<Fault>& faults) {
        std::string page = diff;
        for (const auto& [from, to] : faults) page = replaced(page, from, to);
        return page;
    };
    const auto found = self_tests({
        {"one", with_told(queues_page(runs.of_a, nullptr, {}), {&runs.of_a}, 97)},
        {"diff", diff},
        {"odd", with_told(queues_page(odd, nullptr, {}), {&odd})},
        {"cut", with_told(queues_page(cut, nullptr, {}), {&cut}, 7)},
        {"short", queues_page(runs.of_b, nullptr, short_of_room)},
        {"array", replaced(diff, data, spoiled)},
        {"jump", with({{"(k) => k !== this.launch)", "() => true)"},
                       {"s: () => this.divergeStage(1)", "s: () => this.divergeLaunch(-1)"}})},
        {"stage", with({{"kernelOf(this.page.launches[k]) !== kernelOf(this.at)", "true"}})},
        {"script", with({{"class PageSelection {", "class PageSelection {{"}})},
        {"drawn",
         with({{"if (this.page.failed(k)) return ink.fault;", ""},
               {"differences && most > 0 ? ink.fault", "differences && most > 1e9 ? ink.fault"},
               {"${base} + ${places[t] - base}", "${base} + ${places[t]}"},
               {"if (!last) return;", "return;"},
               {"n: () => this.diverge(1)", "n: () => this.diverge(2)"},
               {"pixel === y * page.width + x", "pixel === x * page.width + y"}})},
        {"told", with({{"'culled', 'pushed', 'lost'", "'pushed', 'culled', 'lost'"},
                       {"const power = exponent - 127", "const power = exponent - 126"},
                       {"`${a} / ${b ?? '–'}` : String(a)", "`${b}` : String(b)"},
                       {"Math.floor(this.box.scrollTop / rowHeight)", "Math.floor(0 / rowHeight)"},
                       {"change: changes[change[i]]", "change: changes[0]"},
                       {"failed > 0 ? `fails", "failed > 99 ? `fails"},
                       {"ray: this.ray ?? undefined", "ray: undefined"}})},
    });
    for (const char* good : {"one", "diff", "odd", "cut", "short"}) {
        INFO(good);
        CHECK_THAT(found.at(good), Catch::Matchers::ContainsSubstring("selftest: passed"));
    }
    const auto fails = [&](const char* page, const char* because) {
        CHECK_THAT(found.at(page), Catch::Matchers::ContainsSubstring("selftest: FAILED") &&
                                       Catch::Matchers::ContainsSubstring(because));
    };
    fails("array", "rror");  // zlib's own checksum goes before ours
    fails("script", "is not defined");
    fails("drawn", "its colour in the timeline says whether it failed");
    fails("drawn", "a difference in the map");
    fails("drawn", "what thread");
    fails("drawn", "dragging turns the box");
    fails("drawn", "n again the second");
    fails("drawn", "chooses the first of its rays");
    fails("told", "history of ray");
    fails("told", "as hexadecimal");
    fails("told", "the length of node");
    fails("told", "the last entry");
    fails("told", "entries that are marked");
    fails("told", "invariants that fail");
    fails("told", "and the ray");
    fails("jump", "s is the next kernel that differs");
    fails("stage", "s is the next kernel that differs");
}

/// Not a test: writes pages to look at to the folder that SCOTTY_PAGES names.
TEST_CASE("queues page: pages to look at", "[.][queues-page-files]") {
    const char* folder = std::getenv("SCOTTY_PAGES");
    REQUIRE(folder != nullptr);
    for (const char* scene : {"spheres", "coil"}) {
        const Runs runs(input_of(64, scene));
        const std::string file = std::string(folder) + "/queues-" + scene;
        scotty::reference::write_file(file + ".html", queues_page(runs.of_a, nullptr, {}));
        scotty::reference::write_file(file + "-diff.html", queues_page(runs.of_a, &runs.of_b, {}));
        scotty::reference::write_file(file + "-faulty.html", queues_page(runs.of_b, nullptr, {}));
    }
}

}  // namespace
