/// Runs held to the tables in reference/contract/buffers.h and stages.h, and every field of every
/// buffer of the table spoiled in turn.
#include <limits>
#include <map>
#include <set>
#include <string>

#include "tests/catch.h"
#include "tests/small_parameters.h"
#include "tests/verify/spheres_run.h"
#include "verify/capture/finite.h"

namespace {

using namespace scotty;
using namespace scotty::verify;
using namespace scotty::verify::test;
using reference::BufferInfo;
using reference::BufferView;
using reference::EarlyOut;
using reference::HitMode;
using reference::PipelineParameters;
using reference::StageInfo;
using reference::StageView;

PipelineParameters small(EarlyOut early_out, HitMode hit_mode, std::uint32_t queue_levels) {
    PipelineParameters p = scotty::test::small_picture(9, 7, 2, 1, 2);
    p.width = 4;
    p.batch_rays = 50;  // several batches
    p.early_out = early_out;
    p.hit_mode = hit_mode;
    p.queue_levels = queue_levels;
    p.filter = reference::Filter::median;
    return p;
}

/// Holds what a pipeline shows to the tables.
class TableKeeper : public reference::StageObserver {
 public:
    explicit TableKeeper(const PipelineParameters& p) : parameters_(p) {}
    void on_stage(const StageView& stage) override {
        const StageInfo& info = reference::stage_info(stage.kind);
        INFO(stage.name);
        CHECK(names(stage.inputs) == names(info.inputs, stage.level));
        CHECK(names(stage.outputs) == names(info.outputs, stage.level));
        for (const auto* list : {&stage.inputs, &stage.outputs}) {
            for (const BufferView& buffer : *list) check(buffer);
        }
        kinds.insert(stage.kind);
    }
    std::set<reference::StageKind> kinds;

 private:
    static std::set<std::string> names(const std::vector<BufferView>& buffers) {
        std::set<std::string> out;
        for (const BufferView& buffer : buffers) CHECK(out.emplace(buffer.name).second);
        return out;
    }
    template <class List>
    std::set<std::string> names(const List& list, std::uint32_t level) const {
        std::set<std::string> out;
        for (const reference::StageBuffer& each : list) {
            if (applies(each.when, parameters_, level)) out.emplace(each.buffer->name);
        }
        return out;
    }
    static void check(const BufferView& buffer) {
        const BufferInfo* info = reference::find_buffer(buffer.name);
        INFO(buffer.name);
        REQUIRE(info != nullptr);
        CHECK(buffer.type == info->type);
        CHECK(buffer.meaning == info->meaning);
        CHECK(buffer.bytes % info->element_bytes == 0);
        std::size_t bytes = info->type == reference::ElementType::uint64 ? 8 : 4;
        for (const std::size_t extent : buffer.shape) bytes *= extent;
        CHECK(bytes == buffer.bytes);
    }
    PipelineParameters parameters_;
};

/// One row of a buffer, and the buffers that say which of it is in use.
struct OneRow {
    explicit OneRow(const BufferInfo& info) : words(info.fields.size(), 0) {
        view.name = info.name;
        view.type = info.type;
        view.data = words.data();
        view.bytes = words.size() * sizeof(std::uint32_t);
        stage.name = "a stage";
        stage.outputs = {view};
        for (const BufferInfo* other : {info.lengths, info.offsets}) {
            if (other == nullptr) continue;
            BufferView beside;
            beside.name = other->name;
            beside.data = other == info.lengths ? &one : offsets;
            beside.bytes = other == info.lengths ? sizeof one : sizeof offsets;
            stage.outputs.push_back(beside);
        }
    }
    std::uint64_t wrong() const { return find_non_finite_values(stage, view).values; }

    std::vector<std::uint32_t> words;
    std::uint32_t one = 1;
    std::uint32_t offsets[2] = {0, 1};
    BufferView view;
    StageView stage;
};

}  // namespace

TEST_CASE("contract: what a run shows is what the tables say", "[verify][contract]") {
    std::set<reference::StageKind> kinds;
    for (const EarlyOut early_out : {EarlyOut::off, EarlyOut::level, EarlyOut::immediate}) {
        for (const HitMode hit_mode : {HitMode::buffer, HitMode::packed}) {
            for (const std::uint32_t way : {0u, 1u, 2u, 3u, 4u, 5u}) {
                PipelineParameters p = small(early_out, hit_mode, way % 3);
                p.queues = way < 3 ? reference::QueueKind::nodes : reference::QueueKind::pairs;
                const reference::WideBvh bvh = build_wide_bvh(spheres(), bvh_parameters(p, 0));
                TableKeeper keeper(p);
                emulation::Pipeline(spheres(), bvh, p, {}, &keeper).render();
                kinds.insert(keeper.kinds.begin(), keeper.kinds.end());
            }
        }
    }
    CHECK(kinds.size() == reference::kStageKinds);
}

TEST_CASE(
    "contract: every float of every buffer is watched, and infinity where the table allows it",
    "[verify][contract]") {
    for (const BufferInfo* info : reference::kBuffers) {
        const OneRow clean(*info);
        INFO(info->name);
        CHECK(clean.wrong() == 0);
        for (std::size_t column = 0; column < info->fields.size(); ++column) {
            const reference::Field& field = info->fields[column];
            INFO("field " << field.name);
            const auto wrong_with = [&](std::uint32_t bits) {
                OneRow row(*info);
                row.words[column] = bits;
                return row.wrong();
            };
            const std::uint64_t watched = field.is_float ? 1 : 0;
            CHECK(wrong_with(0x7fc00000u) == watched);  // NaN
            CHECK(wrong_with(0xff800000u) == watched);  // -infinity
            CHECK(wrong_with(0x7f800000u) == (field.may_be_infinite ? 0 : watched));
        }
    }
}

TEST_CASE("contract: a blank row is finite only as a whole", "[verify][contract]") {
    for (const BufferInfo* info :
         {static_cast<const BufferInfo*>(&reference::buffers::merged),
          static_cast<const BufferInfo*>(&reference::buffers::hits),
          static_cast<const BufferInfo*>(&reference::buffers::packed_hits)}) {
        OneRow row(*info);
        for (std::size_t i = 0; i < row.words.size(); ++i) row.words[i] = info->fields[i].blank;
        INFO(info->name);
        CHECK(row.wrong() == 0);
        for (std::size_t i = 0; i < row.words.size(); ++i) {
            if (info->fields[i].name == "primitive") row.words[i] = 5;
        }
        CHECK(row.wrong() == 1);
    }
}
