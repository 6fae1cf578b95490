#include <string>

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/golden/waivers.h"

namespace scotty::verify::test {
namespace {

using Catch::Matchers::ContainsSubstring;

Waiver waiver(const std::string& golden, const std::string& gate, const std::string& stage,
              const std::string& device, const Date& expires) {
    return {golden, gate, stage, device, "known", expires};
}

constexpr const char* kGood = R"({"format": "cuda-scotty-waivers", "version": 1, "waivers": [
    {"case": "coil", "stage": "bounce1/*", "device": "*", "reason": "r", "expires": "2024-02-29"}]})";

}  // namespace

TEST_CASE("waivers: each covers its case, gate or stage, and device, until its end",
          "[verify][golden]") {
    WaiverBook book({waiver("coil", "pixel", "", "cuda", "2020-01-31"),
                     waiver("coil", "", "bounce1/*", "*", "2020-01-31"),
                     waiver("blob", "tile", "", "*", "2020-01-30")},
                    "2020-01-31");
    CHECK(book.cover_gate("coil", "pixel", "emulator") == nullptr);
    CHECK(book.cover_gate("coil", "tile", "cuda") == nullptr);
    CHECK(book.cover_gate("blob", "pixel", "cuda") == nullptr);
    CHECK(book.cover_gate("blob", "tile", "cuda") == nullptr);  // expired the day before
    CHECK(book.cover_stage("coil", "bounce0/scene_rays", "cuda") == nullptr);
    CHECK(book.unused({"coil", "blob"}, "cuda").size() == 2);
    CHECK(book.unused({"coil"}, "emulator").size() == 1);
    CHECK(book.unused({"veil"}, "cuda").empty());
    REQUIRE(book.expired().size() == 1);
    CHECK(book.expired().front().golden == "blob");

    REQUIRE(book.cover_gate("coil", "pixel", "cuda") != nullptr);
    REQUIRE(book.cover_stage("coil", "bounce1/scene_rays", "simt") != nullptr);
    CHECK(book.unused({"coil", "blob"}, "cuda").empty());
}

TEST_CASE("waivers: a file that is not as it should be is refused by waiver and member",
          "[verify][golden]") {
    const TemporaryFolder folder;
    const auto error = [&](const std::string& from, const std::string& to) {
        spill(folder / "waivers.json", replaced(kGood, from, to));
        return error_of([&] { read_waivers(folder.path()); });
    };
    CHECK(read_waivers(folder.path()).empty());  // no file, no waivers
    spill(folder / "waivers.json", kGood);
    REQUIRE(read_waivers(folder.path()).size() == 1);
    CHECK(read_waivers(folder.path()).front().stage == "bounce1/*");

    CHECK_THAT(error("\"reason\": \"r\",", ""),
               ContainsSubstring("waiver 0") && ContainsSubstring("'reason'"));
    CHECK_THAT(error("\"r\"", "\"\""), ContainsSubstring("'reason'"));
    CHECK_THAT(error("\"stage\": \"bounce1/*\",", ""),
               ContainsSubstring("either 'gate' or 'stage'"));
    CHECK_THAT(error("\"device\"", "\"gate\": \"tile\", \"device\""), ContainsSubstring("either"));
    CHECK_THAT(error("\"device\"", "\"color\": \"red\", \"device\""), ContainsSubstring("'color'"));
    for (const char* date : {"2023-02-29", "2024-2-9", "tomorrow", "2024-02-29x"}) {
        CHECK_THAT(error("2024-02-29", date),
                   ContainsSubstring("'expires'") && ContainsSubstring(date));
    }
}

TEST_CASE("waivers: today is a date", "[verify][golden]") {
    CHECK(today().size() == 10);
    CHECK(today() > "2024-01-01");
}

}  // namespace scotty::verify::test
