#include "verify/report/report_images.h"

#include <fmt/format.h>

#include <bit>
#include <nlohmann/json.hpp>

#include "verify/images/image_json.h"
#include "verify/pages/base64.h"

namespace scotty::verify {
namespace {

/// A plane of pixels as bytes: little-endian whatever this machine is.
struct EncodedPlane {
    std::string base64;
    std::uint32_t checksum = 0;

    explicit EncodedPlane(const std::vector<Color>& colors) {
        std::string bytes;
        bytes.reserve(colors.size() * 12);
        for (const Color& color : colors) {
            for (const double channel : color) {
                const auto word = std::bit_cast<std::uint32_t>(static_cast<float>(channel));
                checksum += word;
                for (int shift = 0; shift < 32; shift += 8) {
                    bytes += static_cast<char>((word >> shift) & 0xffu);
                }
            }
        }
        base64 = verify::base64(bytes);
    }
};

}  // namespace

std::vector<Failure> failures_of(const ImageCase& image) {
    std::vector<Failure> failures = image.exact;
    for (const GateResult& gate : image.verdict.gates) {
        if (!gate.failed()) continue;
        Failure failure;
        failure.invariant = fmt::format("image-{}", name(gate.gate));
        failure.stage = image.name + " against its golden image";
        failure.sentence = gate.text;
        failures.push_back(failure);
    }
    return failures;
}

nlohmann::json to_json(const ImageCase& image) {
    nlohmann::json out = {{"name", image.name},
                          {"passed", image.passed()},
                          {"waived", image.waived},
                          {"width", image.image.width},
                          {"height", image.image.height},
                          {"samples", image.image.samples},
                          {"golden_samples", image.golden.samples},
                          {"replay", image.replay},
                          {"approve", image.approve}};
    out.update(to_json(image.verdict));
    return out;
}

nlohmann::json page_data(const ImageCase& image) {
    nlohmann::json data = to_json(image);
    data["golden_width"] = image.golden.width;
    data["golden_height"] = image.golden.height;
    const auto add = [&](const char* plane_name, const std::vector<Color>& colors) {
        const EncodedPlane plane(colors);
        data["pixels"][plane_name] = plane.base64;
        data["checksums"][plane_name] = plane.checksum;
    };
    add("new", image.image.mean);
    add("golden", image.golden.mean);
    add("new_variance", image.image.variance);
    add("golden_variance", image.golden.variance);
    add("z", image.z);
    return data;
}

}  // namespace scotty::verify
