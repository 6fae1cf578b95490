/// Both sides of a golden comparison: what is there, and what the pipeline makes.
#include <fmt/format.h>

#include "reference/base/error.h"
#include "reference/contract/wide_bvh.h"
#include "verify/backends/temporary_capture.h"
#include "verify/golden/golden_judge.h"
#include "verify/images/image_read.h"

namespace scotty::verify {

GoldenTruth read_golden(const std::filesystem::path& golden, const GoldenCase& golden_case,
                        const reference::Scene& scene) {
    const Manifest manifest = read_manifest(golden);
    const GoldenEntry* entry = manifest.find(golden_case.name);
    const auto refuse = [&](const std::string& what) {
        return reference::Error::bad_input(fmt::format("golden case '{}'", golden_case.name),
                                           what + "; scotty golden check says what to do");
    };
    if (entry == nullptr) throw refuse("is missing from the manifest");
    if (nlohmann::json(entry->settings) != nlohmann::json(settings_of(golden_case, scene))) {
        throw refuse("is stale: it was made for other settings");
    }
    for (const auto& file : {image_path(golden_case.name), ledger_path(golden_case.name)}) {
        const auto listed = entry->files.find(file.string());
        if (listed == entry->files.end() || checksum(golden / file) != listed->second) {
            throw refuse(file.string() + " is corrupted or not in the manifest");
        }
    }
    return {read_image((golden / image_path(golden_case.name)).string()).image,
            read_ledger(golden / ledger_path(golden_case.name))};
}

GoldenRun run_golden(const GoldenCase& golden_case, const reference::Scene& scene,
                     const Backend& backend, std::size_t threads) {
    PipelineInput input{scene, {}, golden_case.pipeline};
    input.bvh = build_wide_bvh(scene, bvh_parameters(input.parameters, threads));
    GoldenRun run;
    run.image = measure_pipeline(backend, input);
    const reference::PipelineParameters& small = golden_case.ledger;
    input.parameters = small;
    input.bvh = build_wide_bvh(scene, bvh_parameters(small, threads));
    run.ledger = ledger_of(TemporaryCapture(backend, input).get());
    return run;
}

}  // namespace scotty::verify
