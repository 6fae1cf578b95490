#include "verify/schedules/schedule_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>

#include "reference/base/error.h"
#include "reference/contract/records.h"
#include "verify/capture/canonical.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

namespace buffers = reference::buffers;

using emulation::Schedule;
using reference::BufferView;
using reference::EarlyOut;
using reference::StageKind;
using reference::StageView;

namespace {

std::string hash_of(const std::vector<std::byte>& bytes) {
    return hash_text(bytes.data(), bytes.size());
}

/// For each hit, whether it is one.
std::vector<std::byte> occlusion(const BufferView& merged) {
    const auto* hits = static_cast<const std::byte*>(merged.data);
    std::vector<std::byte> out;
    for (std::size_t at = 0; at + sizeof(reference::Hit) <= merged.bytes;
         at += sizeof(reference::Hit)) {
        reference::Hit hit;
        std::memcpy(&hit, hits + at, sizeof hit);
        out.push_back(std::byte{reference::is_hit(hit)});
    }
    return out;
}

std::string determined_hash(const StageView& stage, const BufferView& buffer,
                            const Regions& regions,
                            const reference::PipelineParameters& parameters) {
    if (parameters.early_out == EarlyOut::immediate) {
        if (reference::is_of_traversal(stage.kind)) return {};
        if (stage.kind == StageKind::merge_intersections &&
            stage.light != reference::kNotApplicable &&
            parameters.shadow_query == reference::ShadowQuery::any) {
            return hash_of(occlusion(buffer));
        }
        // Hits of shadow rays are only handed on.
        if (buffer.name == buffers::shadow_hits.name) return {};
    }
    return hash_of(canonical_bytes(buffer, regions));
}

/// The hashes to compare: all, or those with determined content, which every schedule has.
std::vector<const StageHash*> compared(const std::vector<StageHash>& hashes, bool all) {
    std::vector<const StageHash*> out;
    for (const StageHash& hash : hashes) {
        if (all || !hash.determined.empty()) out.push_back(&hash);
    }
    return out;
}

/// Finds where two runs part; returns false if they do not.
bool first_difference(const std::vector<StageHash>& expected, const std::vector<StageHash>& found,
                      bool all_bytes, Failure& failure) {
    const auto a = compared(expected, all_bytes);
    const auto b = compared(found, all_bytes);
    for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
        const bool both = i < a.size() && i < b.size();
        const StageHash& here = i < b.size() ? *b[i] : *a[i];
        if (both && a[i]->stage == b[i]->stage && a[i]->buffer == b[i]->buffer) {
            const std::string& was = all_bytes ? a[i]->bytes : a[i]->determined;
            const std::string& is = all_bytes ? b[i]->bytes : b[i]->determined;
            if (was == is) continue;
            failure.expected = was;
            failure.found = is;
        } else {
            failure.expected = i < a.size() ? a[i]->stage : "the end of the run";
            failure.found = i < b.size() ? b[i]->stage : "the end of the run";
        }
        failure.stage = here.stage;
        failure.field = here.buffer;
        failure.launch = here.launch;
        return true;
    }
    return false;
}

}  // namespace

void StageHasher::on_stage(const StageView& stage) {
    // Pairs are not scanned.
    const bool pairs = parameters_.queues == reference::QueueKind::pairs;
    if (stage.level == 0 &&
        stage.kind == (pairs ? StageKind::intersect_root : StageKind::scan_counts)) {
        traversal_begin_ = hashes_.size();
    }
    for (const BufferView& buffer : stage.outputs) {
        const Regions regions = regions_of(stage, buffer, true);
        hashes_.push_back({stage.name, std::string(buffer.name), stage.launch,
                           determined_hash(stage, buffer, regions, parameters_),
                           hash_of(without_unused(buffer, regions))});
    }
}

void StageHasher::on_retry(std::string_view, std::string_view) { hashes_.resize(traversal_begin_); }

std::vector<Failure> check_schedules(const std::vector<Schedule>& schedules,
                                     const reference::PipelineParameters& parameters,
                                     const ScheduledRender& render) {
    std::vector<Failure> failures;
    const auto run = [&](const Schedule& schedule) {
        StageHasher hasher(parameters);
        try {
            render(schedule, hasher);
        } catch (const reference::Error& error) {
            Failure failure;
            failure.invariant = "error";
            failure.stage = hasher.hashes().empty() ? "render" : hasher.hashes().back().stage;
            failure.sentence =
                fmt::format("schedule {}, after this stage: {}", to_string(schedule), error.what());
            failures.push_back(std::move(failure));
        }
        return hasher.hashes();
    };
    std::vector<StageHash> first;
    for (std::size_t i = 0; i < schedules.size(); ++i) {
        const Schedule& schedule = schedules[i];
        const std::size_t failed = failures.size();
        const std::vector<StageHash> hashes = run(schedule);
        if (i == 0) first = hashes;
        Failure failure;
        if (failures.size() == failed && first_difference(first, hashes, false, failure)) {
            failure.invariant = "same-in-every-schedule";
            failure.sentence = fmt::format("schedule {} gives what {} does not",
                                           to_string(schedule), to_string(schedules.front()));
            failures.push_back(failure);
        }
        if (i != 0 && i + 1 != schedules.size()) continue;
        if (failures.size() == failed && first_difference(hashes, run(schedule), true, failure)) {
            failure.invariant = "stray-nondeterminism";
            failure.sentence =
                fmt::format("schedule {} run twice gives two results", to_string(schedule));
            failures.push_back(failure);
        }
    }
    return failures;
}

}  // namespace scotty::verify
