#include <fstream>
#include <random>

#include "reference/base/error.h"
#include "tests/catch.h"
#include "tests/fuzz/readers.h"
#include "tests/temporary_folder.h"

using namespace scotty;
using tests::Reader;

namespace {

namespace fs = std::filesystem;

const fs::path kCorpus = fs::path(SCOTTY_SOURCE_DIR) / "tests/fuzz/corpus";

/// Changes bytes as fuzzers do: bytes and numbers replaced, blocks removed, doubled or cut off.
std::string changed(std::string bytes, std::mt19937& random) {
    for (std::uint32_t left = 1 + random() % 4; left > 0 && !bytes.empty(); --left) {
        const std::size_t at = random() % bytes.size();
        const std::size_t length = std::min<std::size_t>(1 + random() % 16, bytes.size() - at);
        switch (random() % 6) {
            case 0:
                bytes[at] = static_cast<char>(random());
                break;
            case 1:
                bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
                break;
            case 2:
                bytes.replace(at, length, "-99999999999");
                break;
            case 3:
                bytes.erase(at, length);
                break;
            case 4:
                bytes.insert(at, bytes.substr(at, length));
                break;
            default:
                bytes.resize(at);
        }
    }
    return bytes;
}

/// Returns how many files of the corpus were accepted.
int hold(const Reader& reader, std::uint32_t changes) {
    const tests::TemporaryFolder folder;
    std::mt19937 random(1);
    int accepted = 0;
    int files = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(kCorpus / reader.name)) {
        const std::string bytes = tests::slurp(entry.path());
        INFO(entry.path().string());
        accepted += tests::try_reader(reader, folder.path(), bytes) ? 1 : 0;
        for (std::uint32_t i = 0; i < changes; ++i) {
            tests::try_reader(reader, folder.path(), changed(bytes, random));
        }
        ++files;
    }
    REQUIRE(files > 0);
    return accepted;
}

}  // namespace

TEST_CASE("fuzz: what the fuzzers start from, and changes of it, is read or refused", "[fuzz]") {
    for (const Reader& reader : tests::file_readers()) {
        DYNAMIC_SECTION(reader.name) {
            const int accepted = hold(reader, 200);
            // A capture's corpus has the index alone; its buffers are missing.
            CHECK((accepted > 0) == (std::string(reader.name) != "capture"));
        }
    }
}

TEST_CASE("fuzz: what strangers can send to a view is answered or refused", "[fuzz][view]") {
    for (const Reader& reader : tests::view_readers()) {
        DYNAMIC_SECTION(reader.name) { CHECK(hold(reader, 300) > 0); }
    }
}

TEST_CASE("fuzz: command lines, and changes of them, are read or refused", "[fuzz]") {
    CHECK(hold({"command_line", tests::read_command_line}, 200) > 0);
}

TEST_CASE("fuzz: a reader that throws anything but a refusal is found", "[fuzz]") {
    const Reader internal{"internal", [](const fs::path&, std::string_view) {
                              throw reference::Error::internal("broken");
                          }};
    const Reader other{
        "other", [](const fs::path&, std::string_view) { throw std::out_of_range("vector::at"); }};
    CHECK_THROWS_WITH(tests::try_reader(internal, {}, ""),
                      Catch::Matchers::ContainsSubstring("broken"));
    CHECK_THROWS_WITH(tests::try_reader(other, {}, ""),
                      Catch::Matchers::ContainsSubstring("vector::at"));
}
