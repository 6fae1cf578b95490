/// capture_layout.h against the libraries that it does without: its hash, its JSON.
#include <xxhash.h>

#include <nlohmann/json.hpp>
#include <numeric>

#include "tests/catch.h"
#include "tests/temporary_folder.h"
#include "verify/capture/include/scotty/capture_layout.h"

namespace {

using namespace scotty::capture;

TEST_CASE("capture layout: the hash is XXH64 for every length", "[verify][capture]") {
    std::vector<unsigned char> bytes(300);
    std::iota(bytes.begin(), bytes.end(), static_cast<unsigned char>(7));
    for (std::size_t n = 0; n <= bytes.size(); ++n) {
        INFO(n << " bytes");
        REQUIRE(scotty::capture::hash(bytes.data(), n) == XXH64(bytes.data(), n, 0));
    }
}

TEST_CASE("capture layout: JSON is what another library writes", "[verify][capture]") {
    const std::string odd = "a \"b\" \\ \b\f\n\r\t \x01 \x1f /";
    nlohmann::ordered_json expected;
    expected["text"] = odd;
    expected["none"] = nullptr;
    expected["list"] = {1, 18446744073709551615u, nlohmann::ordered_json::array()};
    expected["object"] = nlohmann::ordered_json::object();
    expected["yes"] = true;
    Json json;
    json.open('{').key("text").text(odd).key("none").raw("null").key("list").open('[');
    json.number(1).number(18446744073709551615u).open('[').close(']').close(']');
    json.key("object").open('{').close('}').key("yes").boolean(true).close('}');
    CHECK(json.result() == expected.dump(1));
}

TEST_CASE("capture layout: a directory appears whole, and replaces only captures",
          "[verify][capture]") {
    const scotty::tests::TemporaryFolder folder;
    const auto target = folder / "x";
    {
        const Directory given_up(target);
        write_file(given_up.path() / "a", "1");
    }
    CHECK(std::filesystem::is_empty(folder.path()));
    for (int i = 0; i < 2; ++i) {  // the second replaces the first
        Directory made(target);
        write_file(made.path() / "index.json", text_of(Index{}));
        made.finish();
        CHECK(std::filesystem::exists(target / "index.json"));
    }
    std::filesystem::create_directories(folder / "other");
    write_file(folder / "other" / "index.json", "{\"format\": \"something else\"}");
    CHECK_THROWS_AS(Directory(folder / "other"), Error);
}

}  // namespace
