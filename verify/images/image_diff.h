/// An image file against its golden image: `scotty diff GOLDEN IMAGE`.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "verify/images/image_gates.h"
#include "verify/images/image_read.h"

namespace scotty::verify {

struct ImageDiffSettings {
    GateSettings gates;
    /// Judges by this and not by noise (judge_by_tolerance).
    std::optional<double> tolerance;
    ImageChoice choice;         ///< for files with several parts or layers, both of them
    std::uint64_t samples = 0;  ///< per pixel of the image, if its file does not say; 0: none
    std::string heat_map;       ///< .png or .exr to write; empty: none
    /// The same render with other seeds. The image judged is then the mean of all, and their
    /// differences are its noise.
    std::vector<std::string> also;
};

struct ImageDiff {
    /// The basis of the verdict; these are never mixed.
    enum class Basis { noise, tolerance, bits };

    std::string golden_path, image_path;
    ReadImage golden, image;
    ImageDiffSettings settings;
    Basis basis = Basis::noise;
    std::vector<std::string> notes;  ///< what was not judged, or not by noise, and how to do so
    ImageVerdict verdict;
};

/// Reads both and judges: by a stated tolerance, else by noise if both images know theirs, else by
/// whether the bits are equal; if these differ, there is no verdict (ImageVerdict::not_judged).
/// Throws bad_input as read_image does, and for a sample count that contradicts the file's.
ImageDiff diff_images(const std::string& golden, const std::string& image,
                      const ImageDiffSettings& settings);

/// The largest z of each pixel from 0 to 8, or, if noise is not known, log2 of 1 + units in the
/// last place from 0 to 24. Layouts must agree. Throws bad_input as write_image does.
void write_heat_map(const ImageDiff& diff, const std::string& path);

/// Verdict by gate, metrics, worst pixels with their values.
std::string to_text(const ImageDiff& diff);
/// Numbers that are not finite are the strings "nan", "inf", "-inf".
nlohmann::ordered_json to_json(const ImageDiff& diff);

}  // namespace scotty::verify
