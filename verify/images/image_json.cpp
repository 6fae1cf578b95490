#include "verify/images/image_json.h"

#include "verify/base/json_number.h"

namespace scotty::verify {

using nlohmann::ordered_json;

namespace {

ordered_json json_color(const Color& color) {
    return {json_number(color[0]), json_number(color[1]), json_number(color[2])};
}

ordered_json json_gate(const GateResult& gate) {
    return {{"gate", name(gate.gate)},
            {"ran", gate.ran},
            {"passed", gate.passed},
            {"statistic", json_number(gate.statistic)},
            {"p_value", json_number(gate.p_value)},
            {"threshold", json_number(gate.threshold)},
            {"x", gate.x},
            {"y", gate.y},
            {"width", gate.width},
            {"height", gate.height},
            {"channel", gate.channel},
            {"waiver", gate.waiver},
            {"text", gate.text}};
}

}  // namespace

ordered_json to_json(const ImageVerdict& verdict) {
    ordered_json gates = ordered_json::array();
    for (const GateResult& gate : verdict.gates) gates.push_back(json_gate(gate));
    ordered_json worst = ordered_json::array();
    for (const WorstPixel& pixel : verdict.worst) {
        worst.push_back({{"x", pixel.x},
                         {"y", pixel.y},
                         {"z", json_number(pixel.z)},
                         {"ulps", json_number(pixel.ulps)},
                         {"image", json_color(pixel.image)},
                         {"golden", json_color(pixel.golden)}});
    }
    const ImageMetrics& metrics = verdict.metrics;
    return {{"gates", gates},
            {"not_judged_by",
             {{"flip", json_number(metrics.flip)},
              {"rel_mse", json_number(metrics.rel_mse)},
              {"psnr", json_number(metrics.psnr)},
              {"max_ulps", json_number(metrics.max_ulps)}}},
            {"worst", worst}};
}

}  // namespace scotty::verify
