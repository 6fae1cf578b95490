#include "verify/view/view_measures.h"

#include <fmt/format.h>
#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_reduce.h>
#include <xxhash.h>

#include <algorithm>
#include <cmath>

#include "reference/contract/parameter_table.h"
#include "verify/capture/npy.h"

namespace scotty::verify {

using reference::Image;
using reference::ParameterGroup;
using reference::ParameterInfo;
using reference::PipelineParameters;
using reference::Vec3;

namespace {

double luminance(const Vec3& v) {
    return static_cast<double>(v.x) + static_cast<double>(v.y) + static_cast<double>(v.z);
}

}  // namespace

double noise_of(const Image& image) {
    if (image.variance.empty()) return 0.0;
    struct Sums {
        double variance = 0.0;
        double radiance = 0.0;
    };
    constexpr std::size_t kGrain = 1u << 14;
    const Sums sums = oneapi::tbb::parallel_deterministic_reduce(
        oneapi::tbb::blocked_range<std::size_t>(0, image.pixels.size(), kGrain), Sums{},
        [&](const oneapi::tbb::blocked_range<std::size_t>& range, Sums part) {
            for (std::size_t p = range.begin(); p != range.end(); ++p) {
                part.variance += luminance(image.variance[p]);
                part.radiance += luminance(image.pixels[p]);
            }
            return part;
        },
        [](const Sums& a, const Sums& b) {
            return Sums{a.variance + b.variance, a.radiance + b.radiance};
        });
    const double channels = 3.0 * static_cast<double>(image.pixels.size());
    const double mean = sums.radiance / channels;
    return mean > 0.0 ? std::sqrt(sums.variance / channels) / mean : 0.0;
}

std::string hash_of(const Image& image) {
    return hex_text(XXH3_64bits(image.pixels.data(), image.pixels.size() * sizeof(Vec3)));
}

FeatureImage variance_of(const Image& image) {
    FeatureImage out{image.width, image.height, {}, ViewSubject::variance, {}};
    out.values.assign(image.pixels.size(), std::nanf(""));
    for (std::size_t p = 0; p < image.variance.size(); ++p) {
        const double mean = luminance(image.pixels[p]) / 3.0;
        if (mean <= 0.0) continue;
        out.values[p] = static_cast<float>(std::sqrt(luminance(image.variance[p]) / 3.0) / mean);
    }
    return out;
}

bool is_cpu(const std::string& backend) { return backend != "cuda"; }

bool needs_new_pipeline(const ViewState& a, const ViewState& b) {
    if (a.backend != b.backend || (a.measured != b.measured && !is_cpu(b.backend))) return true;
    return std::any_of(reference::kParameters.begin(), reference::kParameters.end(),
                       [&](const ParameterInfo& info) {
                           const bool made_with =
                               info.group == ParameterGroup::tree ||
                               info.group == ParameterGroup::arithmetic ||
                               (info.group == ParameterGroup::pipeline &&
                                info.name != "batch_rays" && info.name != "samples_per_pass");
                           return made_with && info.get(a.parameters) != info.get(b.parameters);
                       });
}
bool needs_new_tree(const PipelineParameters& a, const PipelineParameters& b) {
    return std::any_of(reference::kParameters.begin(), reference::kParameters.end(),
                       [&](const ParameterInfo& info) {
                           return info.group == ParameterGroup::tree && info.get(a) != info.get(b);
                       });
}

std::string differences(const ViewState& a, const ViewState& b, bool& changes_picture) {
    std::string text;
    const auto add = [&](std::string_view title, const std::string& from, const std::string& to) {
        text += fmt::format("{}{} {} to {}", text.empty() ? "" : ", ", title, from, to);
    };
    if (a.backend != b.backend) add("back end", a.backend, b.backend);
    for (const ParameterInfo& info : reference::kParameters) {
        if (info.get(a.parameters) == info.get(b.parameters)) continue;
        if (info.group == ParameterGroup::filter || info.name == "samples_per_pass" ||
            info.name == "spp") {
            continue;
        }
        add(info.title, text_of(info, a.parameters), text_of(info, b.parameters));
        changes_picture = changes_picture || info.group == ParameterGroup::picture ||
                          info.group == ParameterGroup::arithmetic;
    }
    return text;
}

bool same_camera(const reference::Camera& a, const reference::Camera& b) {
    return std::equal(&a.position, &a.position + 4, &b.position,
                      [](const Vec3& x, const Vec3& y) {
                          return x.x == y.x && x.y == y.y && x.z == y.z;
                      }) &&
           a.tan_half_fov == b.tan_half_fov && a.tan_half_width == b.tan_half_width;
}

}  // namespace scotty::verify
