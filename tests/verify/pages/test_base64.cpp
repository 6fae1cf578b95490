/// The examples of RFC 4648, section 10, and bytes that are no text.
#include <string>

#include "tests/catch.h"
#include "verify/pages/base64.h"

namespace {

using scotty::verify::base64;

TEST_CASE("base64: the standard's own examples", "[verify][pages]") {
    CHECK(base64("").empty());
    CHECK(base64("f") == "Zg==");
    CHECK(base64("fo") == "Zm8=");
    CHECK(base64("foo") == "Zm9v");
    CHECK(base64("foob") == "Zm9vYg==");
    CHECK(base64("fooba") == "Zm9vYmE=");
    CHECK(base64("foobar") == "Zm9vYmFy");
    CHECK(base64(std::string("\xff\x00\xfb\xef", 4)) == "/wD77w==");
}

}  // namespace
