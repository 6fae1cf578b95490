/// Captures: what is in them, how they appear, and what is said of one that is broken.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/capture/npy.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
namespace fs = std::filesystem;

std::string reopen_error(const fs::path& directory) {
    return error_of([&] { Capture::open(directory); });
}

TEST_CASE("capture: every stage is there, in order, with its buffers bit for bit",
          "[verify][capture]") {
    const TemporaryFolder folder;
    const PipelineParameters p = small_parameters();
    StageCopies stages;
    const PipelineInput input = spheres_input(p);
    const emulation::DeviceOptions serial{.schedule = emulation::ScheduleKind::linear};
    emulation::Pipeline(input.scene, input.bvh, p, serial, &stages).render();
    const Capture capture = make_capture(folder / "c", p, {}, serial);

    REQUIRE(capture.stages().size() == stages.all().size());
    CHECK(capture.header().backend == "emulator");
    CHECK(capture.header().scene_name == "spheres");
    CHECK(capture.header().bvh_levels == input.bvh.level_count());
    CHECK_FALSE(capture.header().several_batches);
    for (std::size_t i = 0; i < stages.all().size(); ++i) {
        const StageView& expected = stages.all()[i].view;
        const StageRecord& record = capture.stages()[i];
        INFO(expected.name);
        CHECK(record.name == expected.name);
        CHECK(record.kind == expected.kind);
        CHECK(record.level == expected.level);
        CHECK(record.light == expected.light);
        CHECK(record.blocks == expected.blocks);
        REQUIRE(record.outputs.size() == expected.outputs.size());
        const LoadedStage loaded = capture.load(record);
        for (std::size_t b = 0; b < expected.outputs.size(); ++b) {
            INFO(expected.outputs[b].name);
            CHECK(loaded.view.outputs[b].shape == expected.outputs[b].shape);
            if (record.outputs[b].order != BufferOrder::ordered) continue;
            const auto bytes = [&](const BufferView& view) {
                const auto* data = static_cast<const char*>(view.data);
                return std::string(data, data + view.bytes);  // of none there is no place
            };
            CHECK(bytes(loaded.view.outputs[b]) == bytes(expected.outputs[b]));
        }
    }
}

TEST_CASE("capture: the output of one stage and the input of the next are one file",
          "[verify][capture]") {
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", small_parameters());
    const StageRecord& root = *capture.find("bounce0/level0/intersect_root");
    const StageRecord& next = *capture.find("bounce0/level1/intersect");
    CHECK(root.output("child_queue")->file == next.input("queue")->file);
    std::set<std::string> named;
    std::size_t references = 0;
    for (const StageRecord& stage : capture.stages()) {
        for (const auto* list : {&stage.inputs, &stage.outputs}) {
            for (const BufferRecord& buffer : *list) {
                named.insert(buffer.file);
                ++references;
            }
        }
    }
    const auto files =
        std::distance(fs::directory_iterator(folder / "c" / "buffers"), fs::directory_iterator());
    CHECK(static_cast<std::size_t>(files) == named.size());
    CHECK(named.size() * 2 < references);
}

TEST_CASE("capture: unused memory is neither stored nor hashed", "[verify][capture]") {
    const TemporaryFolder folder;
    const auto spoil_unused = [](StageCopies& stages) {
        StageCopy& stage = stages.at("bounce0/level1/intersect");
        const auto offsets = stage.input<std::uint32_t>("child_offsets");
        const auto counts = stage.output<std::uint32_t>("child_counts");
        const auto queue = stage.output<std::uint32_t>("child_queue");
        for (std::size_t i = 0; i < counts.size(); ++i) {
            for (std::uint32_t at = offsets[i] + counts[i]; at < offsets[i + 1]; ++at) {
                queue[at] = 12345;
            }
        }
        const auto hit_counts = stage.output<std::uint32_t>("hit_counts");
        const auto hits = stage.output<HitCandidate>("hits");
        const std::size_t capacity = hits.size() / hit_counts.size();
        for (std::size_t ray = 0; ray < hit_counts.size(); ++ray) {
            for (std::size_t slot = hit_counts[ray]; slot < capacity; ++slot) {
                hits[ray * capacity + slot] = {std::nanf(""), 7};
            }
        }
    };
    const emulation::DeviceOptions serial{.schedule = emulation::ScheduleKind::linear};
    const Capture plain = make_capture(folder / "a", small_parameters(), {}, serial);
    const Capture spoiled = make_capture(folder / "b", small_parameters(), spoil_unused, serial);
    for (const char* buffer : {"child_queue", "hits"}) {
        const StageRecord& a = *plain.find("bounce0/level1/intersect");
        const StageRecord& b = *spoiled.find("bounce0/level1/intersect");
        CHECK(a.output(buffer)->hash == b.output(buffer)->hash);
        CHECK(a.output(buffer)->canonical_hash == b.output(buffer)->canonical_hash);
    }
    const LoadedStage loaded = spoiled.load(*spoiled.find("bounce0/level1/intersect"));
    const auto queue = loaded.view.get<std::uint32_t>("child_queue");
    CHECK(std::count(queue.begin(), queue.end(), 12345u) == 0);
    CHECK(std::count(queue.begin(), queue.end(), kNone) > 0);
}

TEST_CASE("capture: the canonical hash does not depend on the order of blocks, the plain one does",
          "[verify][capture]") {
    const TemporaryFolder folder;
    const Capture a = make_capture(folder / "a", small_parameters(), {},
                                   {.schedule = emulation::ScheduleKind::linear});
    const Capture b = make_capture(folder / "b", small_parameters(), {},
                                   {.schedule = emulation::ScheduleKind::reversed});
    bool reordered = false;
    for (const StageRecord& stage : a.stages()) {
        for (const BufferRecord& buffer : stage.outputs) {
            const BufferRecord& other = *b.find(stage.name)->output(buffer.name);
            INFO(stage.name << " " << buffer.name);
            CHECK(buffer.canonical_hash == other.canonical_hash);
            reordered = reordered || buffer.hash != other.hash;
        }
    }
    CHECK(reordered);
}

TEST_CASE("capture: a traversal that is run again is there once", "[verify][capture]") {
    const TemporaryFolder folder;
    PipelineParameters p = small_parameters();
    p.hit_capacity = 1;
    p.early_out = EarlyOut::off;
    struct Counter : CaptureWriter {
        using CaptureWriter::CaptureWriter;
        void on_retry(std::string_view stage, std::string_view reason) override {
            ++retries;
            CaptureWriter::on_retry(stage, reason);
        }
        int retries = 0;
    };
    const PipelineInput input = spheres_input(p);
    Counter writer(folder / "c", header_of("emulator", input.scene, input.bvh, p));
    emulation::Pipeline(input.scene, input.bvh, p, {}, &writer).render();
    writer.finish();
    REQUIRE(writer.retries > 0);
    // Duplicate names would not open.
    const Capture capture = Capture::open(folder / "c");
    const auto& hits = *capture.find("bounce0/merge_intersections")->input("hits");
    CHECK(hits.shape.at(1) > 1);
    CHECK(capture.find("primary_rays") != nullptr);
    CHECK(capture.find("bounce0/level0/intersect_root")->output("hits")->shape == hits.shape);
}

TEST_CASE("capture: patterns choose stages, and the capture remembers them", "[verify][capture]") {
    const TemporaryFolder folder;
    const Capture capture = make_capture(folder / "c", small_parameters(), {}, {},
                                         {"primary_rays", "*/level1/intersect"});
    std::vector<std::string> names;
    for (const StageRecord& stage : capture.stages()) names.push_back(stage.name);
    CHECK(names == std::vector<std::string>{"primary_rays", "bounce0/level1/intersect",
                                            "bounce0/light0/level1/intersect",
                                            "bounce1/level1/intersect",
                                            "bounce1/light0/level1/intersect"});
    CHECK(capture.covers("bounce7/level1/intersect"));
    CHECK_FALSE(capture.covers("bounce0/level2/intersect"));
}

TEST_CASE("capture: batches are noted", "[verify][capture]") {
    const TemporaryFolder folder;
    PipelineParameters p = small_parameters();
    p.batch_rays = 100;
    const Capture capture = make_capture(folder / "c", p);
    CHECK(capture.header().several_batches);
    CHECK(capture.find("batch1/primary_rays")->batch == 1);
}

TEST_CASE("capture: appears whole or not at all", "[verify][capture]") {
    const TemporaryFolder folder;
    const PipelineInput input = spheres_input(small_parameters());
    const auto header = header_of("emulator", input.scene, input.bvh, input.parameters);
    {
        CaptureWriter writer(folder / "c", header);
        emulation::Pipeline(input.scene, input.bvh, input.parameters, {}, &writer).render();
        CHECK_FALSE(fs::exists(folder / "c"));
    }
    CHECK(fs::is_empty(folder.path()));
    make_capture(folder / "c", small_parameters(), {}, {}, {"primary_rays"});
    {
        CaptureWriter writer(folder / "c", header);
        // Given up: the old capture stays.
    }
    CHECK(Capture::open(folder / "c").stages().size() == 1);
}

TEST_CASE("capture: replaces a capture or an empty directory, and nothing else",
          "[verify][capture][errors]") {
    const TemporaryFolder folder;
    const PipelineInput input = spheres_input(small_parameters());
    const auto header = header_of("emulator", input.scene, input.bvh, input.parameters);
    const auto write = [&](const char* name) { CaptureWriter(folder / name, header).finish(); };
    write("c");
    write("c");
    fs::create_directories(folder / "empty");
    write("empty");
    CHECK(Capture::open(folder / "empty").stages().empty());
    fs::create_directories(folder / "thesis");
    spill(folder / "thesis" / "chapter1.tex", "years of work");
    CHECK_THAT(error_of([&] { write("thesis"); }),
               ContainsSubstring("thesis") &&
                   ContainsSubstring("is not a capture, so it is not replaced"));
    CHECK(slurp(folder / "thesis" / "chapter1.tex") == "years of work");
    spill(folder / "file", "a file");
    CHECK_THAT(error_of([&] { write("file"); }), ContainsSubstring("is not a capture"));
    CHECK_THAT(error_of([&] { CaptureWriter(folder / "file" / "x", header); }),
               ContainsSubstring("cannot be made"));
}

TEST_CASE("capture: a foreign or broken index is named with what was expected",
          "[verify][capture][errors]") {
    const TemporaryFolder folder;
    const fs::path directory = folder / "c";
    CHECK_THAT(reopen_error(directory),
               ContainsSubstring("expected a capture, which is a directory"));
    fs::create_directories(directory);
    CHECK_THAT(reopen_error(directory), ContainsSubstring("it holds no index.json"));
    spill(directory / "index.json", "[1, 2");
    CHECK_THAT(reopen_error(directory),
               ContainsSubstring("index.json") && ContainsSubstring("expected JSON"));
    spill(directory / "index.json", R"({"format": "somebody-elses"})");
    CHECK_THAT(
        reopen_error(directory),
        ContainsSubstring(R"(expected "format": "cuda-scotty-capture", found "somebody-elses")"));
    fs::remove_all(directory);

    make_capture(directory, small_parameters(), {}, {}, {"primary_rays"});
    const std::string good = slurp(directory / "index.json");
    const auto broken = [&](const std::string& from, const std::string& to) {
        spill(directory / "index.json", replaced(good, from, to));
        return reopen_error(directory);
    };
    CHECK_THAT(broken("\"version\": 1", "\"version\": 2"),
               ContainsSubstring("expected version 1, found 2"));
    CHECK_THAT(
        broken("\"spp\": 2", "\"spp\": -2"),
        ContainsSubstring("parameters") && ContainsSubstring("'spp': expected a whole number"));
    CHECK_THAT(broken("\"spp\": 2", "\"spp\": 0"), ContainsSubstring("samples per pixel"));
    CHECK_THAT(broken("\"spp\": 2,", ""), ContainsSubstring("'spp' is missing"));
    CHECK_THAT(broken("\"spp\": 2,", "\"spp\": 2, \"warp\": 9,"),
               ContainsSubstring("the parameter 'warp' is not known"));
    CHECK_THAT(broken("\"early_out\": \"level\"", "\"early_out\": \"sometimes\""),
               ContainsSubstring("expected one of off, level, immediate, found 'sometimes'"));
    CHECK_THAT(broken("\"kind\": \"primary_rays\"", "\"kind\": \"knit\""),
               ContainsSubstring("stages[0] (primary_rays)") && ContainsSubstring("found 'knit'"));
    CHECK_THAT(broken("\"type\": \"float32\"", "\"type\": \"float16\""),
               ContainsSubstring("outputs[0]") && ContainsSubstring("found 'float16'"));
    CHECK_THAT(broken("\"file\": \"buffers/", "\"file\": \"buffers/../../"),
               ContainsSubstring("expected buffers/NAME.npy"));
    CHECK_THAT(broken("\"hash\": \"", "\"hash\": \"x"), ContainsSubstring("16 hexadecimal digits"));
    auto twice = nlohmann::json::parse(good);
    twice["stages"].push_back(twice["stages"][0]);
    spill(directory / "index.json", twice.dump());
    CHECK_THAT(reopen_error(directory), ContainsSubstring("primary_rays is there twice"));
}

TEST_CASE("capture: a broken buffer is named with file, stage and what was expected",
          "[verify][capture][errors]") {
    const TemporaryFolder folder;
    const Capture capture =
        make_capture(folder / "c", small_parameters(), {}, {}, {"primary_rays"});
    const StageRecord& stage = *capture.find("primary_rays");
    const BufferRecord& rays = *stage.output("rays");
    const fs::path file = folder / "c" / rays.file;
    const std::string good = slurp(file);
    const auto error = [&] { return error_of([&] { capture.load(stage, rays); }); };

    spill(file, good.substr(0, good.size() - 1));
    CHECK_THAT(error(), ContainsSubstring(file.filename().string()) &&
                            ContainsSubstring("it has been cut short"));
    std::string changed = good;
    changed.back() = static_cast<char>(changed.back() ^ 1);
    spill(file, changed);
    CHECK_THAT(error(), ContainsSubstring("expected bytes of hash " + rays.hash) &&
                            ContainsSubstring("rays of primary_rays") &&
                            ContainsSubstring("has been changed"));
    const std::size_t shape[] = {2};
    write_npy(file, ElementType::uint32, shape, "12345678", 8);
    CHECK_THAT(error(),
               ContainsSubstring("expected float32 [286, 8] for rays of primary_rays, found "
                                 "uint32 [2]"));
    fs::remove(file);
    CHECK_THAT(error(), ContainsSubstring("the file is missing"));
}

TEST_CASE("capture: numpy reads it with no help from us", "[verify][capture][numpy]") {
    std::string python;
    for (const std::string candidate : {"python3", "/usr/bin/python3"}) {
        const std::string probe = candidate + " -c 'import numpy' >/dev/null 2>&1";
        if (python.empty() && std::system(probe.c_str()) == 0) python = candidate;
    }
    if (python.empty()) {
        WARN("not run: python3 with numpy is not installed (Debian: python3-numpy)");
        return;
    }
    const TemporaryFolder folder;
    make_capture(folder / "c", small_parameters());
    spill(folder / "read.py", R"(
import json, os, sys
import numpy as np
top = sys.argv[1]
index = json.load(open(os.path.join(top, "index.json")))
assert index["format"] == "cuda-scotty-capture", index["format"]
stages = {s["name"]: s for s in index["stages"]}
def load(stage, side, name):
    b = next(b for b in stages[stage][side] if b["name"] == name)
    a = np.load(os.path.join(top, b["file"]))
    assert a.dtype == b["type"] and list(a.shape) == b["shape"], (name, a.dtype, a.shape)
    return a
for s in index["stages"]:
    for side in ("inputs", "outputs"):
        for b in s[side]:
            load(s["name"], side, b["name"])
rays = load("primary_rays", "outputs", "rays")
assert rays.shape == (13 * 11 * 2, 8)
assert np.allclose(np.linalg.norm(rays[:, 4:7], axis=1), 1, atol=1e-6)
assert np.isinf(rays[:, 7]).all()
merged = load("bounce0/merge_intersections", "outputs", "merged")
assert merged[:, 0].view(np.float32).min() > 0
vertices = np.load(os.path.join(top, "input", "vertices.npy"))
triangles = np.load(os.path.join(top, "input", "triangles.npy"))
hit = merged[merged[:, 1] != 0xffffffff]
assert len(hit) > 0 and triangles[hit[:, 1]].max() < len(vertices)
print("read", len(index["stages"]))
)");
    const std::string command = python + " " + (folder / "read.py").string() + " " +
                                (folder / "c").string() + " > " + (folder / "out").string() +
                                " 2>&1";
    const int status = std::system(command.c_str());
    INFO(slurp(folder / "out"));
    CHECK(status == 0);
    CHECK_THAT(slurp(folder / "out"), ContainsSubstring("read "));
}

TEST_CASE("capture: a pipeline input is read back bit for bit, for every width",
          "[verify][capture][input]") {
    const int width = GENERATE(2, 4, 8, 16);
    const TemporaryFolder folder;
    PipelineParameters p = small_parameters();
    p.width = width;
    p.seed = 0xfedcba9876543210u;
    p.filter = Filter::bilateral;
    const PipelineInput input = spheres_input(p);
    write_pipeline_input(folder / "i", input.scene, input.bvh, p);
    const PipelineInput back = read_pipeline_input(folder / "i");
    CHECK(fingerprint(back.scene) == fingerprint(input.scene));
    CHECK(fingerprint(back.bvh) == fingerprint(input.bvh));
    CHECK(back.bvh.level_begins == input.bvh.level_begins);
    CHECK(back.scene.name == "spheres");
    CHECK(back.parameters.seed == p.seed);
    CHECK(back.parameters.filter == p.filter);
    CHECK(back.parameters.width == width);
    CHECK(validate(back.bvh, back.scene).empty());
    const Image a = emulation::Pipeline(input.scene, input.bvh, p).render();
    const Image b = emulation::Pipeline(back.scene, back.bvh, back.parameters).render();
    CHECK(std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(Vec3)) == 0);
}

TEST_CASE("capture: a pipeline input that was changed or cut is refused",
          "[verify][capture][input][errors]") {
    const TemporaryFolder folder;
    const PipelineInput input = spheres_input(small_parameters());
    write_pipeline_input(folder / "i", input.scene, input.bvh, input.parameters);
    const auto error = [&] { return error_of([&] { read_pipeline_input(folder / "i"); }); };
    for (const char* name : {"vertices.npy", "materials.npy", "bvh_boxes.npy", "bvh_parents.npy"}) {
        const fs::path file = folder / "i" / name;
        const std::string good = slurp(file);
        std::string changed = good;
        changed.back() = static_cast<char>(changed.back() ^ 1);
        spill(file, changed);
        CHECK_THAT(error(), ContainsSubstring(name) && ContainsSubstring("has been changed"));
        spill(file, good.substr(0, good.size() - 2));
        CHECK_THAT(error(), ContainsSubstring(name) && ContainsSubstring("cut short"));
        fs::remove(file);
        CHECK_THAT(error(), ContainsSubstring(name) && ContainsSubstring("cannot be read"));
        spill(file, good);
    }
    const fs::path wide = folder / "i" / "bvh_children.npy";
    const std::string good = slurp(wide);
    fs::copy_file(folder / "i" / "bvh_parents.npy", wide, fs::copy_options::overwrite_existing);
    CHECK_THAT(error(), ContainsSubstring("bvh_children.npy") &&
                            ContainsSubstring("expected uint32 [n, 4]"));
    spill(wide, good);
    CHECK(error() == "(no error)");
    fs::remove(folder / "i" / "input.json");
    CHECK_THAT(error(), ContainsSubstring("expected a pipeline input"));
}

}  // namespace
