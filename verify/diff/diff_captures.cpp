/// Compares two captures.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "reference/base/error.h"
#include "verify/capture/npy.h"
#include "verify/diff/diff.h"

namespace scotty::verify {

using reference::Error;
using reference::PipelineParameters;

namespace {

/// `add` shows the differ one stage of B.
template <class Add>
DiffReport diff_stages(const Capture& a, const Capture& b, DiffOptions options, const Add& add) {
    expect_comparable(a, b);
    options.b_backend = b.header().backend;
    options.b_arithmetic = b.header().parameters.arithmetic;
    Differ differ(a, std::move(options));
    for (const StageRecord& stage : b.stages()) add(differ, stage);
    DiffReport report = differ.finish([&](std::string_view stage) { return b.covers(stage); });
    report.b = b.directory().string();
    return report;
}

}  // namespace

void expect_comparable(const Capture& a, const Capture& b) {
    expect_own(a);
    expect_own(b);
    const auto expect = [&](const std::string& what, const std::string& of_a,
                            const std::string& of_b) {
        if (of_a == of_b) return;
        throw Error::bad_input(b.directory().string(),
                               fmt::format("the captures cannot be compared: {} is {} there and "
                                           "{} in {}",
                                           what, of_b, of_a, a.directory().string()));
    };
    const CaptureHeader& ha = a.header();
    const CaptureHeader& hb = b.header();
    expect("the scene's fingerprint", hex_text(ha.scene_fingerprint),
           hex_text(hb.scene_fingerprint));
    PipelineParameters pa = ha.parameters;
    pa.hit_capacity = hb.parameters.hit_capacity;  // its start does not matter: it grows
    pa.arithmetic = hb.parameters.arithmetic;      // differences are held to tolerances
    const nlohmann::ordered_json ja = to_json(pa);
    const nlohmann::ordered_json jb = to_json(hb.parameters);
    for (const auto& item : ja.items()) {
        expect("the parameter " + item.key(), item.value().dump(), jb.at(item.key()).dump());
    }
    expect("the BVH's fingerprint", hex_text(ha.bvh_fingerprint), hex_text(hb.bvh_fingerprint));
}

DiffReport diff_captures(const Capture& a, const Capture& b, DiffOptions options) {
    if (!a.has_buffers() || !b.has_buffers()) return diff_by_hash(a, b, std::move(options));
    return diff_stages(a, b, std::move(options), [&](Differ& differ, const StageRecord& stage) {
        differ.on_stage(b.load(stage).view);
    });
}

DiffReport diff_by_hash(const Capture& a, const Capture& b, DiffOptions options) {
    return diff_stages(a, b, std::move(options),
                       [](Differ& differ, const StageRecord& stage) { differ.add_by_hash(stage); });
}

}  // namespace scotty::verify
