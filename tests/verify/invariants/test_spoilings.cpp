/// Spoils every input and output that the contract's tables know, row by row and field by field,
/// and expects the invariants, the comparison and the canonical form to see each. A new buffer is
/// covered by being in the table.
#include <bit>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "reference/contract/buffers.h"
#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "tests/verify/spheres_run.h"
#include "verify/capture/canonical.h"
#include "verify/diff/diff_parts.h"

namespace {

using namespace scotty;
using namespace scotty::reference;
using namespace scotty::verify;
using verify::test::SpheresRun;
using verify::test::StageCopy;

/// One wrong word of one buffer.
struct Spoiling {
    std::string kind;
    std::size_t word = 0;  ///< of the buffer, 4 bytes each
    std::uint32_t bits = 0;
};

std::uint32_t* words(const BufferView& buffer) {
    return static_cast<std::uint32_t*>(const_cast<void*>(buffer.data));
}

/// The indices of the rows that are in use.
std::vector<std::size_t> used_rows(const StageView& stage, const BufferView& buffer, bool output,
                                   const BufferInfo& info) {
    std::vector<std::size_t> rows;
    const Regions regions = regions_of(stage, buffer, output);
    if (info.order == BufferOrder::ordered) {
        for (std::size_t row = 0; row < buffer.bytes / info.element_bytes; ++row) {
            rows.push_back(row);
        }
    }
    for (const Regions::Region& region : regions.regions) {
        for (std::size_t i = 0; i < region.count; ++i) rows.push_back(region.begin + i);
    }
    return rows;
}

/// The wrong values of a field that is in use. A neighbour's value is the next row's that is
/// another.
std::vector<Spoiling> spoilings_of(const BufferView& buffer, const BufferInfo& info,
                                   const std::vector<std::size_t>& rows, std::size_t at,
                                   std::size_t field) {
    const std::size_t fields = info.fields.size();
    const std::size_t word = rows[at] * fields + field;
    const std::uint32_t old = words(buffer)[word];
    std::vector<Spoiling> all;
    const auto add = [&](const char* kind, std::uint32_t bits) {
        if (bits != old) all.push_back({kind, word, bits});
    };
    if (info.fields[field].is_float) {
        add("NaN", std::bit_cast<std::uint32_t>(std::numeric_limits<float>::quiet_NaN()));
        add("infinity", buffers::kInfinityBits);
        add("sign", old ^ 0x80000000u);
    } else {
        add("highest bit", old ^ 0x80000000u);
        add("none", kNone);
    }
    add("one more", old + 1);
    add("one less", old - 1);
    add("zero", 0);
    for (std::size_t i = 1; i < rows.size(); ++i) {
        const std::uint32_t other = words(buffer)[rows[(at + i) % rows.size()] * fields + field];
        if (other == old) continue;
        add("a neighbour's", other);
        break;
    }
    return all;
}

/// Where a buffer is spoiled: for each kind of stage, the launch with most rows in use.
struct Place {
    StageCopy* stage = nullptr;
    std::size_t index = 0;  ///< of the buffer in its list
    bool output = false;
    std::vector<std::size_t> rows = {};  ///< in use

    const BufferView& buffer() const {
        return (output ? stage->view.outputs : stage->view.inputs)[index];
    }
};

std::vector<Place> places(SpheresRun& run) {
    std::map<std::tuple<StageKind, std::string, bool>, Place> most;
    for (StageCopy& stage : run.stages.all()) {
        for (const bool output : {false, true}) {
            const auto& buffers = output ? stage.view.outputs : stage.view.inputs;
            for (std::size_t i = 0; i < buffers.size(); ++i) {
                Place& found = most[{stage.view.kind, std::string(buffers[i].name), output}];
                auto rows = used_rows(stage.view, buffers[i], output, buffer_info(buffers[i].name));
                if (rows.size() > found.rows.size()) found = {&stage, i, output, std::move(rows)};
            }
        }
    }
    std::vector<Place> all;
    for (const auto& [key, found] : most) {
        if (found.stage != nullptr) all.push_back(found);
    }
    return all;
}

/// What sees that the buffer is spoiled.
struct Seen {
    bool invariants = false, comparison = false, canonical = false;
};

Seen seen_by(SpheresRun& run, const Place& place, const Spoiling& spoiling) {
    const StageView& stage = place.stage->view;
    const BufferView& buffer = place.buffer();
    const BufferInfo& info = buffer_info(buffer.name);
    const auto* bytes = static_cast<const std::byte*>(buffer.data);
    const std::vector<std::byte> sound(bytes, bytes + buffer.bytes);
    const auto canonical = [&] {
        return canonical_bytes(buffer, regions_of(stage, buffer, place.output));
    };
    const std::vector<std::byte> sound_form = canonical();
    StageView sound_stage = stage;
    BufferView& sound_buffer =
        (place.output ? sound_stage.outputs : sound_stage.inputs)[place.index];
    sound_buffer.data = sound.data();

    std::uint32_t& word = words(buffer)[spoiling.word];
    const std::uint32_t old = std::exchange(word, spoiling.bits);
    Seen seen;
    seen.invariants = !run.check().empty();
    const Comparison found = compare({sound_stage, sound_buffer, stage, buffer, place.output});
    seen.comparison = found.verdict == Verdict::differs;
    if (seen.comparison && info.order == BufferOrder::ordered) {
        const std::size_t fields = info.fields.size();
        CHECK(found.row == spoiling.word / fields);
        CHECK(found.field == info.fields[spoiling.word % fields].name);
    }
    seen.canonical = canonical() != sound_form;
    word = old;
    return seen;
}

PipelineParameters parameters(EarlyOut early_out, HitMode hit_mode, std::uint32_t queue_levels) {
    PipelineParameters p = verify::test::small_parameters();
    p.image_width = 3;
    p.image_height = 2;
    p.width = 16;
    p.early_out = early_out;
    p.hit_mode = hit_mode;
    p.queue_levels = queue_levels;
    p.filter = Filter::median;
    return p;
}

TEST_CASE("spoilings: the first, middle and last row of every buffer, in every field",
          "[verify][invariants]") {
    std::set<std::tuple<StageKind, std::string_view, bool>> spoiled;
    std::size_t count = 0;
    PipelineParameters with_pairs = parameters(EarlyOut::level, HitMode::packed, 0);
    with_pairs.queues = QueueKind::pairs;
    with_pairs.width = 4;
    for (const PipelineParameters& p :
         {parameters(EarlyOut::level, HitMode::buffer, 0),
          parameters(EarlyOut::off, HitMode::packed, 0),
          parameters(EarlyOut::off, HitMode::buffer, 1), with_pairs}) {
        SpheresRun run(p);
        REQUIRE(run.check().empty());
        for (const Place& place : places(run)) {
            const BufferInfo& info = buffer_info(place.buffer().name);
            spoiled.insert({place.stage->view.kind, info.name, place.output});
            const auto& rows = place.rows;
            for (const std::size_t at :
                 std::set<std::size_t>{0, rows.size() / 2, rows.size() - 1}) {
                for (std::size_t field = 0; field < info.fields.size(); ++field) {
                    for (const Spoiling& spoiling :
                         spoilings_of(place.buffer(), info, rows, at, field)) {
                        const Seen seen = seen_by(run, place, spoiling);
                        ++count;
                        INFO(place.stage->view.name << (place.output ? " output " : " input ")
                                                    << info.name << '[' << rows[at] << "] "
                                                    << info.fields[field].name << ": "
                                                    << spoiling.kind);
                        CHECK(seen.invariants);
                        CHECK(seen.comparison);
                        CHECK(seen.canonical);
                    }
                }
            }
        }
    }
    CHECK(count > 1000);
    for (const StageInfo& stage : kStages) {
        for (const StageBuffer& each : stage.inputs) {
            INFO(stage.name << " reads " << each.buffer->name);
            CHECK(spoiled.contains({stage.kind, each.buffer->name, false}));
        }
        for (const StageBuffer& each : stage.outputs) {
            INFO(stage.name << " writes " << each.buffer->name);
            CHECK(spoiled.contains({stage.kind, each.buffer->name, true}));
        }
    }
}

}  // namespace
