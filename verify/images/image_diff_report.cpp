/// The verdict on an image as text and as JSON.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "verify/images/image_diff.h"
#include "verify/images/image_json.h"

namespace scotty::verify {

using nlohmann::ordered_json;

namespace {

const char* to_string(ImageDiff::Basis basis) {
    switch (basis) {
        case ImageDiff::Basis::noise:
            return "noise";
        case ImageDiff::Basis::tolerance:
            return "tolerance";
        case ImageDiff::Basis::bits:
            return "bits";
    }
    return "?";
}

std::string about(const ReadImage& read) {
    const MeasuredImage& image = read.image;
    std::string text = fmt::format("{}x{}, {}, ", image.width, image.height, read.encoding);
    text += image.samples == 0 ? "samples not known" : fmt::format("{} samples", image.samples);
    if (image.paths_per_sample != 1) text += fmt::format(" of {} paths", image.paths_per_sample);
    return text + (image.variance.empty() ? ", no variances" : ", with variances");
}

const char* outcome(const GateResult& result) {
    if (!result.ran) return "-";
    return result.passed ? "passed" : "FAILED";
}

std::string values(const Color& color) {
    return fmt::format("{:>12.6g} {:>12.6g} {:>12.6g}", color[0], color[1], color[2]);
}

std::string worst_table(const ImageDiff& diff) {
    if (diff.verdict.worst.empty()) return {};
    std::string out = fmt::format("\n{:<14} {:>8} {:>11}  {:^38}   {:^38}\n", "worst pixels", "z",
                                  "ulps", "image: red, green, blue", "golden");
    for (const WorstPixel& pixel : diff.verdict.worst) {
        out += fmt::format(
            "{:<14} {:>8} {:>11.0f}  {}   {}\n", fmt::format("({}, {})", pixel.x, pixel.y),
            diff.basis == ImageDiff::Basis::noise ? fmt::format("{:.1f}", pixel.z) : "-",
            pixel.ulps, values(pixel.image), values(pixel.golden));
    }
    return out;
}

ordered_json to_json(const std::string& path, const ReadImage& read) {
    const MeasuredImage& image = read.image;
    return {{"path", path},
            {"width", image.width},
            {"height", image.height},
            {"encoding", read.encoding},
            {"samples", image.samples == 0 ? ordered_json(nullptr) : ordered_json(image.samples)},
            {"paths_per_sample", image.paths_per_sample},
            {"variances", !image.variance.empty()},
            {"attributes", read.attributes},
            {"not_read", read.not_read}};
}

}  // namespace

std::string to_text(const ImageDiff& diff) {
    std::string out = fmt::format("golden  {}: {}\nimage   {}: {}\n", diff.golden_path,
                                  about(diff.golden), diff.image_path, about(diff.image));
    for (const std::string& note : diff.notes) out += fmt::format("note    {}\n", note);
    out += fmt::format("\n{:<8} {:<8} worst\n", "gate", "verdict");
    for (const GateResult& result : diff.verdict.gates) {
        out += fmt::format("{:<8} {:<8} {}\n", name(result.gate), outcome(result), result.text);
    }
    const ImageMetrics& m = diff.verdict.metrics;
    out += fmt::format(
        "\nnot judged by: flip {:.5f}, relative squared error {:.3e}, PSNR {:.2f} dB, at most "
        "{:.0f} ulps\n",
        m.flip, m.rel_mse, m.psnr, m.max_ulps);
    out += worst_table(diff);
    if (const GateResult* failed = diff.verdict.first_failure()) {
        return out +
               fmt::format("\ndiffers, by the {} gate: {}\n", name(failed->gate), failed->text);
    }
    if (!diff.verdict.not_judged.empty()) {
        return out +
               fmt::format("\nnot judged: the images differ, and {}\n", diff.verdict.not_judged);
    }
    return out + (diff.basis == ImageDiff::Basis::noise
                      ? fmt::format("\npassed: no difference beyond noise; a sound image fails "
                                    "with probability {:g} at most\n",
                                    diff.settings.gates.false_alarm)
                      : "\npassed\n");
}

ordered_json to_json(const ImageDiff& diff) {
    const auto& tolerance = diff.settings.tolerance;
    ordered_json out = {{"passed", diff.verdict.passed()},
                        {"basis", to_string(diff.basis)},
                        {"not_judged", diff.verdict.not_judged},
                        {"notes", diff.notes},
                        {"false_alarm", diff.settings.gates.false_alarm},
                        {"light_tailed", diff.settings.gates.light_tailed},
                        {"tolerance", tolerance ? ordered_json(*tolerance) : ordered_json(nullptr)},
                        {"golden", to_json(diff.golden_path, diff.golden)},
                        {"image", to_json(diff.image_path, diff.image)}};
    out.update(to_json(diff.verdict));
    return out;
}

}  // namespace scotty::verify
