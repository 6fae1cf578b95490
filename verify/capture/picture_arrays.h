/// A picture as arrays, for machines without a library for image files.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "reference/contract/image.h"

namespace scotty::verify {

/// The files beside X.npy: X.variance.npy and X.json.
std::filesystem::path variance_file(const std::filesystem::path& image);
std::filesystem::path about_file(const std::filesystem::path& image);

/// Writes X.npy (float32 [height, width, 3], linear radiance), X.variance.npy of the same shape
/// where variances are known, and `about` to X.json, where a reader looks for the member "samples".
/// Each file is whole at any time; a variance file of an earlier picture goes away. Throws
/// bad_input naming the file that cannot be written.
void write_picture_arrays(const std::filesystem::path& file, const reference::Image& image,
                          const nlohmann::ordered_json& about);

}  // namespace scotty::verify
