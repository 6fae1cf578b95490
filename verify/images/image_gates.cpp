#include "verify/images/image_gates.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>

#include "reference/base/assert.h"
#include "verify/base/statistics.h"
#include "verify/images/image_metrics.h"
#include "verify/images/image_noise.h"

namespace scotty::verify {
namespace {

constexpr std::uint32_t kTile = 8;
constexpr std::size_t kWorstPixels = 10;
constexpr std::array kChannels{"red", "green", "blue"};

GateResult layout_gate(const std::string& complaint) {
    GateResult result;
    result.gate = Gate::layout;
    result.passed = complaint.empty();
    result.text = complaint.empty() ? "same size, and the noise is known" : complaint;
    return result;
}

GateResult not_asked(Gate gate, std::string why) {
    GateResult result;
    result.gate = gate;
    result.ran = false;
    result.text = std::move(why);
    return result;
}

/// A value that the finite gate refuses.
struct BadValue {
    std::size_t pixel = 0, channel = 0;
    double value = 0.0;
    std::uint64_t pixels = 0;  ///< that have one such value
};

std::optional<BadValue> first_bad(const std::vector<Color>& colors) {
    std::optional<BadValue> first;
    std::uint64_t pixels = 0;
    for (std::size_t i = 0; i < colors.size(); ++i) {
        const auto* const bad = std::find_if(colors[i].begin(), colors[i].end(), [](double value) {
            return !(value >= 0.0) || !std::isfinite(value);  // NaN is not >= 0
        });
        if (bad == colors[i].end()) continue;
        ++pixels;
        if (!first) first = {i, static_cast<std::size_t>(bad - colors[i].begin()), *bad, 0};
    }
    if (first) first->pixels = pixels;
    return first;
}

GateResult finite_gate(const MeasuredImage& image, const MeasuredImage& golden) {
    GateResult result;
    result.gate = Gate::finite;
    result.text = "every value is finite and none is negative";
    const std::array<std::tuple<const char*, const MeasuredImage*, bool>, 4> parts{
        {{"the image", &image, false},
         {"the image's variance", &image, true},
         {"the golden image", &golden, false},
         {"the golden image's variance", &golden, true}}};
    for (const auto& [who, of, variance] : parts) {
        const std::optional<BadValue> bad = first_bad(variance ? of->variance : of->mean);
        if (!bad) continue;
        result.passed = false;
        result.x = static_cast<std::uint32_t>(bad->pixel % image.width);
        result.y = static_cast<std::uint32_t>(bad->pixel / image.width);
        result.width = result.height = 1;
        result.channel = static_cast<std::uint32_t>(bad->channel);
        result.statistic = static_cast<double>(bad->pixels);
        result.text = fmt::format(
            "{} has {} pixel{} with a value that is negative or not finite, first "
            "({}, {}) {}: {}",
            who, bad->pixels, bad->pixels == 1 ? "" : "s", result.x, result.y,
            kChannels[bad->channel], bad->value);
        return result;
    }
    return result;
}

std::vector<Region> regions(std::uint32_t width, std::uint32_t height, std::uint32_t side_x,
                            std::uint32_t side_y) {
    std::vector<Region> all;
    for (std::uint32_t y = 0; y < height; y += side_y) {
        for (std::uint32_t x = 0; x < width; x += side_x) {
            all.push_back({x, y, std::min(side_x, width - x), std::min(side_y, height - y)});
        }
    }
    return all;
}

std::string place_of(const GateResult& result) {
    if (result.gate == Gate::global) return "the whole image";
    if (result.gate == Gate::pixel) return fmt::format("pixel ({}, {})", result.x, result.y);
    return fmt::format("the {}x{} tile at ({}, {})", result.width, result.height, result.x,
                       result.y);
}

/// The worst of all regions and channels, by probability and then by size, because the
/// probabilities of very bad ones are all zero.
class Worst {
 public:
    explicit Worst(Gate gate) { result_.gate = gate; }

    void add(const Region& region, std::size_t channel, const RegionTest& test) {
        const double size = std::abs(test.statistic);
        // Student's tails are heavier than the normal's, so this saves most of the work.
        if (any_ && normal_two_sided(size) > result_.p_value) return;
        const double p = student_two_sided(size, test.degrees_of_freedom);
        const double difference = std::abs(test.image - test.golden);
        if (any_ && std::tuple(-p, size, difference) <=
                        std::tuple(-result_.p_value, result_.statistic, difference_)) {
            return;
        }
        any_ = true;
        difference_ = difference;
        worst_ = test;
        result_.p_value = p;
        result_.statistic = size;
        result_.x = region.x;
        result_.y = region.y;
        result_.width = region.width;
        result_.height = region.height;
        result_.channel = static_cast<std::uint32_t>(channel);
    }

    GateResult judged(double threshold) const {
        GateResult result = result_;
        result.threshold = threshold;
        result.passed = result.p_value >= threshold;
        const double share =
            worst_.golden != 0.0 ? 100.0 * (worst_.image / worst_.golden - 1.0) : 0.0;
        result.text = fmt::format(
            "{}, {}: {:.6g} against {:.6g} ({:+.2f} %), {}, p = {:.1e} {} {:.1e}", place_of(result),
            kChannels[result.channel], worst_.image, worst_.golden, share,
            std::isfinite(worst_.statistic)
                ? fmt::format("{:.1f} standard deviations", worst_.statistic)
                : "where neither image has any noise",
            result.p_value, result.passed ? "not below" : "below", threshold);
        return result;
    }

 private:
    GateResult result_;
    RegionTest worst_;
    double difference_ = 0.0;
    bool any_ = false;
};

GateResult noise_gate(Gate gate, const NoisyPair& pair, const std::vector<Region>& parts,
                      double false_alarm) {
    Worst worst(gate);
    for (const Region& region : parts) {
        for (std::size_t c = 0; c < 3; ++c) worst.add(region, c, pair.test(region, c));
    }
    return worst.judged(sidak(false_alarm, 3 * parts.size()));
}

void ask_noise_gates(const NoisyPair& pair, const MeasuredImage& image,
                     const GateSettings& settings, ImageVerdict& verdict) {
    const double share = settings.false_alarm / (settings.light_tailed ? 3.0 : 2.0);
    const std::uint32_t w = image.width;
    const std::uint32_t h = image.height;
    verdict.gates.push_back(noise_gate(Gate::global, pair, regions(w, h, w, h), share));
    verdict.gates.push_back(noise_gate(Gate::tile, pair, regions(w, h, kTile, kTile), share));
    if (settings.light_tailed) {
        verdict.gates.push_back(noise_gate(Gate::pixel, pair, regions(w, h, 1, 1), share));
    } else {
        verdict.gates.push_back(
            not_asked(Gate::pixel, "the scene is heavy-tailed: single pixels prove nothing"));
    }
}

/// Sorts pixels that are not finite first, then by z, then by distance.
std::vector<WorstPixel> worst_pixels(const MeasuredImage& image, const MeasuredImage& golden,
                                     const std::vector<double>& z) {
    const std::vector<double> ulps = ulps_map(image, golden);
    const auto rank = [&](std::size_t i) {
        double distance = 0.0;
        for (std::size_t c = 0; c < 3; ++c) {
            const double d = std::abs(image.mean[i][c] - golden.mean[i][c]);
            distance =
                std::isfinite(d) ? std::max(distance, d) : std::numeric_limits<double>::infinity();
        }
        return std::tuple(!std::isfinite(distance), z.empty() ? 0.0 : z[i], distance, ulps[i]);
    };
    using Ranked = std::pair<decltype(rank(0)), std::size_t>;
    std::vector<Ranked> order;
    for (std::size_t i = 0; i < ulps.size(); ++i) {
        const auto r = rank(i);
        if (std::get<0>(r) || std::get<1>(r) > 0.0 || ulps[i] > 0.0) order.emplace_back(r, i);
    }
    const std::size_t count = std::min(kWorstPixels, order.size());
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(count),
                      order.end(), [](const Ranked& a, const Ranked& b) {
                          return a.first != b.first ? a.first > b.first : a.second < b.second;
                      });
    std::vector<WorstPixel> worst;
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t i = order[k].second;
        worst.push_back({static_cast<std::uint32_t>(i % image.width),
                         static_cast<std::uint32_t>(i / image.width), z.empty() ? 0.0 : z[i],
                         ulps[i], image.mean[i], golden.mean[i]});
    }
    return worst;
}

/// Asks layout and finite; if one of those fails, marks the rest as not asked.
bool passes_the_first_two(const MeasuredImage& image, const MeasuredImage& golden,
                          const std::string& complaint, const std::vector<Gate>& rest,
                          ImageVerdict& verdict) {
    verdict.gates.push_back(layout_gate(complaint));
    const bool comparable = NoisyPair::other_layout(image, golden).empty();
    if (comparable) {
        verdict.gates.push_back(finite_gate(image, golden));
        verdict.metrics = image_metrics(image, golden);
    } else {
        verdict.gates.push_back(not_asked(Gate::finite, "not asked: the layout gate failed"));
        const double unknown = std::nan("");
        verdict.metrics = {unknown, unknown, unknown, unknown};
    }
    if (verdict.passed()) return true;
    const std::string why =
        fmt::format("not asked: the {} gate failed", name(verdict.first_failure()->gate));
    for (const Gate gate : rest) verdict.gates.push_back(not_asked(gate, why));
    if (comparable) verdict.worst = worst_pixels(image, golden, {});
    return false;
}

double mean_value(const MeasuredImage& image) {
    double sum = 0.0;
    for (const Color& color : image.mean) sum += color[0] + color[1] + color[2];
    return sum / (3.0 * static_cast<double>(image.mean.size()));
}

GateResult equal_gate(const MeasuredImage& image, const MeasuredImage& golden, double tolerance) {
    const double usual = mean_value(golden);
    GateResult result;
    result.gate = Gate::equal;
    result.threshold = tolerance;
    std::uint64_t wrong = 0;
    for (std::size_t i = 0; i < image.mean.size(); ++i) {
        for (std::size_t c = 0; c < 3; ++c) {
            const double a = image.mean[i][c];
            const double b = golden.mean[i][c];
            if (std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b)) continue;
            const double scale = std::max({std::abs(a), std::abs(b), usual});
            const double off = scale > 0.0 ? std::abs(a - b) / scale : 0.0;
            const bool outside = !(tolerance > 0.0 && off <= tolerance);
            if (outside) ++wrong;
            if (off < result.statistic || (off == result.statistic && result.width != 0)) continue;
            result.statistic = off;
            result.x = static_cast<std::uint32_t>(i % image.width);
            result.y = static_cast<std::uint32_t>(i / image.width);
            result.width = result.height = 1;
            result.channel = static_cast<std::uint32_t>(c);
        }
    }
    result.passed = wrong == 0;
    if (result.width == 0) {
        result.text = "every value has the golden image's bits";
        return result;
    }
    const std::size_t pixel = std::size_t{result.y} * image.width + result.x;
    result.text = fmt::format(
        "{} of {} values differ{}; farthest off is {} of {}: {:.9g} against {:.9g}, {:.2e} of it",
        wrong, 3 * image.mean.size(),
        tolerance > 0.0 ? fmt::format(" by more than {:g}", tolerance) : " in their bits",
        kChannels[result.channel], fmt::format("pixel ({}, {})", result.x, result.y),
        image.mean[pixel][result.channel], golden.mean[pixel][result.channel], result.statistic);
    return result;
}

}  // namespace

std::string_view name(Gate gate) {
    switch (gate) {
        case Gate::layout:
            return "layout";
        case Gate::finite:
            return "finite";
        case Gate::global:
            return "global";
        case Gate::tile:
            return "tile";
        case Gate::pixel:
            return "pixel";
        case Gate::equal:
            return "equal";
    }
    return "?";
}

double false_alarm_per_image(double run, std::uint64_t images) { return sidak(run, images); }

bool ImageVerdict::passed() const { return first_failure() == nullptr && not_judged.empty(); }

const GateResult* ImageVerdict::first_failure() const {
    const auto failed = std::find_if(gates.begin(), gates.end(),
                                     [](const GateResult& result) { return result.failed(); });
    return failed == gates.end() ? nullptr : &*failed;
}

ImageVerdict judge_image(const MeasuredImage& image, const MeasuredImage& golden,
                         const GateSettings& settings) {
    SCOTTY_ASSERT(settings.false_alarm, >, 0.0);
    SCOTTY_ASSERT(settings.false_alarm, <, 1.0);
    ImageVerdict verdict;
    if (!passes_the_first_two(image, golden, NoisyPair::why_not(image, golden),
                              {Gate::global, Gate::tile, Gate::pixel}, verdict)) {
        return verdict;
    }
    const NoisyPair pair(image, golden);
    ask_noise_gates(pair, image, settings, verdict);
    verdict.worst = worst_pixels(image, golden, z_map(pair, image.width, image.height));
    return verdict;
}

ImageVerdict judge_by_tolerance(const MeasuredImage& image, const MeasuredImage& golden,
                                double tolerance) {
    ImageVerdict verdict;
    if (!passes_the_first_two(image, golden, NoisyPair::other_layout(image, golden), {Gate::equal},
                              verdict)) {
        return verdict;
    }
    verdict.gates.front().text = "same size";
    verdict.gates.push_back(equal_gate(image, golden, tolerance));
    verdict.worst = worst_pixels(image, golden, {});
    return verdict;
}

ImageVerdict judge_bits(const MeasuredImage& image, const MeasuredImage& golden,
                        const std::string& why) {
    ImageVerdict verdict = judge_by_tolerance(image, golden, 0.0);
    GateResult& last = verdict.gates.back();
    if (last.gate == Gate::equal && last.failed()) {
        last.ran = false;
        verdict.not_judged = why;
    }
    return verdict;
}

}  // namespace scotty::verify
