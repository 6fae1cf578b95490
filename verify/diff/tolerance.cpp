#include "verify/diff/tolerance.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>

namespace scotty::verify {

using reference::BufferInfo;
using reference::BufferView;
using reference::Tolerance;

namespace {

/// A few rows may fork even if the share of a short array rounds to none.
std::uint64_t allowed(const Tolerance& tolerance, std::uint64_t rows) {
    if (tolerance.share == 0.0) return 0;
    return 2 + static_cast<std::uint64_t>(tolerance.share * static_cast<double>(rows));
}

void close(Comparison& out, const Tolerance& tolerance, std::uint64_t rows) {
    if (out.different == 0) {
        out.verdict = Verdict::within_tolerance;
        return;
    }
    const bool passes = out.different <= allowed(tolerance, rows);
    out.verdict = passes ? Verdict::within_tolerance : Verdict::differs;
    out.sentence = fmt::format(
        "{} of {} are beyond the tolerance for fast arithmetic ({} relative); {} may be",
        out.different, rows, tolerance.relative, allowed(tolerance, rows));
}

/// The largest finite magnitude of each field.
std::vector<double> scales_of(const BufferView& buffer, const BufferInfo& layout) {
    const std::size_t columns = layout.fields.size();
    std::vector<double> scales(columns, 0.0);
    for (std::size_t i = 0; i < buffer.bytes / 4; ++i) {
        if (!layout.fields[i % columns].is_float) continue;
        const double value =
            std::abs(static_cast<double>(std::bit_cast<float>(word_at(buffer, i))));
        if (std::isfinite(value)) scales[i % columns] = std::max(scales[i % columns], value);
    }
    return scales;
}

/// Zero for equal values, infinite if one is not finite or the field is no float.
double error_between(std::uint32_t a, std::uint32_t b, bool is_float, double scale) {
    if (a == b) return 0.0;
    const auto x = static_cast<double>(std::bit_cast<float>(a));
    const auto y = static_cast<double>(std::bit_cast<float>(b));
    if (!is_float || !std::isfinite(x) || !std::isfinite(y)) return HUGE_VAL;
    const double magnitude = std::max({std::abs(x), std::abs(y), 0.01 * scale});
    return magnitude == 0.0 ? 0.0 : std::abs(x - y) / magnitude;
}

Comparison compare_rows(const BufferPair& pair, const BufferInfo& layout) {
    Comparison out = compare_ordered(pair);
    if (out.verdict == Verdict::identical || out.field == "shape") return out;
    const std::size_t columns = layout.fields.size();
    const std::vector<double> scales = scales_of(pair.a, layout);
    const std::size_t rows = pair.a.bytes / 4 / columns;
    out = {};
    const std::string_view only = layout.tolerance.only;
    double worst = 0.0;
    for (std::size_t row = 0; row < rows; ++row) {
        bool beyond = false;
        for (std::size_t column = 0; column < columns; ++column) {
            const Field& field = layout.fields[column];
            if (!only.empty() && field.name != only) continue;
            const std::uint32_t a = word_at(pair.a, row * columns + column);
            const std::uint32_t b = word_at(pair.b, row * columns + column);
            const double error = error_between(a, b, field.is_float, scales[column]);
            if (error <= layout.tolerance.relative) continue;
            beyond = true;
            if (error <= worst) continue;
            worst = error;
            out.row = row;
            out.field = field.name;
            out.a = value_text(a, field.is_float);
            out.b = value_text(b, field.is_float);
            out.ulps = field.is_float ? ulps_between(a, b) : std::nullopt;
        }
        out.different += beyond ? 1 : 0;
    }
    close(out, layout.tolerance, rows);
    return out;
}

/// Lengths and offsets of queues: the number of entries on which they disagree.
Comparison compare_lengths(const BufferPair& pair, const BufferInfo& info) {
    Comparison out = compare_ordered(pair);
    if (out.verdict == Verdict::identical || out.field == "shape") return out;
    const bool offsets = info.content == reference::Content::offsets;
    const std::size_t rows = pair.a.bytes / 4;
    std::uint64_t total = 0;
    out.different = 0;
    for (std::size_t row = 0; row < rows; ++row) {
        const std::uint64_t a = word_at(pair.a, row);
        const std::uint64_t b = word_at(pair.b, row);
        const std::uint64_t gap = a > b ? a - b : b - a;
        total = offsets ? std::max(total, a) : total + a;
        out.different = offsets ? std::max(out.different, gap) : out.different + gap;
    }
    close(out, info.tolerance, total);
    return out;
}

/// Queues as sets by region; hit lists by number of hits, whose t is judged after the merge.
Comparison compare_sets(const BufferPair& pair, const BufferInfo& info) {
    const Regions a = regions_of(pair.a_stage, pair.a, pair.output);
    const Regions b = regions_of(pair.b_stage, pair.b, pair.output);
    Comparison out;
    std::uint64_t total = 0;
    for (std::size_t region = 0; region < std::min(a.regions.size(), b.regions.size()); ++region) {
        const auto of_a = sorted_entries(pair.a, a, region);
        const auto of_b = sorted_entries(pair.b, b, region);
        total += of_a.size();
        if (info.order == reference::BufferOrder::hit_list) {
            out.different +=
                of_a.size() > of_b.size() ? of_a.size() - of_b.size() : of_b.size() - of_a.size();
            continue;
        }
        std::vector<std::uint64_t> only;
        std::set_symmetric_difference(of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
                                      std::back_inserter(only));
        if (!only.empty() && out.different == 0) {
            out.row = region;
            out.entry_ray = static_cast<std::uint32_t>(only.front());
        }
        out.different += only.size();
    }
    close(out, info.tolerance, total);
    return out;
}

}  // namespace

Comparison compare_within_tolerance(const BufferPair& pair) {
    const reference::BufferInfo& info = reference::buffer_info(pair.a.name);
    if (info.order != reference::BufferOrder::ordered) return compare_sets(pair, info);
    if (info.row == Row::node || info.row == Row::child_node) return compare_lengths(pair, info);
    return compare_rows(pair, info);
}

}  // namespace scotty::verify
