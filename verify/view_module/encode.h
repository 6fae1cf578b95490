/// JPEG and PNG of 8-bit RGB, row-major; empty where a library fails.
#pragma once

#include <cstdint>
#include <string>

namespace scotty::verify {

std::string encode_jpeg(const std::uint8_t* rgb, int width, int height, int quality);
/// Compressed quickly rather than well.
std::string encode_png(const std::uint8_t* rgb, int width, int height);

}  // namespace scotty::verify
