/// Bytes as text, for pages.
#pragma once

#include <string>
#include <string_view>

namespace scotty::verify {

/// RFC 4648, section 4: padded, without line breaks; JavaScript's atob() reads it.
std::string base64(std::string_view bytes);

}  // namespace scotty::verify
