/// Images held against their golden images, as reports show them.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "verify/capture/failure.h"
#include "verify/images/image_gates.h"
#include "verify/images/measured_image.h"

namespace scotty::verify {

struct ImageCase {
    std::string name;
    std::size_t unit = 0;  ///< its number in the whole sweep
    MeasuredImage image, golden;
    ImageVerdict verdict;
    /// What was compared exactly beside the image, and failed: the stage ledger, and whether the
    /// picture is the mean of its paths.
    std::vector<Failure> exact;
    std::vector<std::string> waived;  ///< failures that are let pass, with the waiver
    /// The signed statistic of each pixel and channel, by the rule that the verdict was found by:
    /// the page shows statistics and works out none. Empty where noise is not known.
    std::vector<Color> z;
    std::string replay;   ///< command that renders and judges this case alone
    std::string approve;  ///< command that makes the new image the golden one

    bool passed() const { return exact.empty() && verdict.passed(); }
};

/// What failed exactly, then each gate that did, as failures of the report: "[image-tile] ...".
std::vector<Failure> failures_of(const ImageCase& image);

/// The verdict without the pixels. A number that is not finite is the string "NaN", "Infinity" or
/// "-Infinity".
nlohmann::json to_json(const ImageCase& image);

/// What the report page draws from: the verdict, and in "pixels" the planes new, golden,
/// new_variance, golden_variance and z as base64 of little-endian float32 RGB, row-major from the
/// top left; empty where there is none. "checksums" has each plane's sum of 32-bit words, modulo
/// 2^32.
nlohmann::json page_data(const ImageCase& image);

}  // namespace scotty::verify
