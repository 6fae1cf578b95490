#include "tests/properties.h"

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/capture/npy.h"

namespace {

using namespace scotty;
using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;
using reference::ElementType;

void write(const std::filesystem::path& file) {
    const std::vector<float> values{1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f};
    const std::size_t shape[] = {3, 2};
    write_npy(file, ElementType::float32, shape, values.data(), 24);
}

TEST_CASE("npy: what is written is read, for any shape and type", "[verify][npy]") {
    const TemporaryFolder folder;
    scotty::tests::check_property("round trip", [&] {
        const auto type = *rc::gen::element(ElementType::uint8, ElementType::uint32,
                                            ElementType::uint64, ElementType::float32);
        const auto shape = *rc::gen::resize(
            4, rc::gen::container<std::vector<std::size_t>>(rc::gen::inRange<std::size_t>(0, 5)));
        const std::size_t bytes = element_count(shape) * size_of(type);
        const auto values =
            *rc::gen::container<std::vector<char>>(bytes, rc::gen::arbitrary<char>());
        write_npy(folder / "a.npy", type, shape, values.data(), bytes);
        const NpyArray array = read_npy(folder / "a.npy");
        RC_ASSERT(array.type == type);
        RC_ASSERT(array.shape == shape);
        RC_ASSERT(array.bytes.size() == bytes);
        const auto* read = reinterpret_cast<const char*>(array.bytes.data());
        RC_ASSERT(std::equal(values.begin(), values.end(), read));
    });
}

TEST_CASE("npy: the header is numpy's, padded to 64 bytes", "[verify][npy]") {
    const std::size_t one[] = {5};
    const std::string header = npy_header(ElementType::uint32, one);
    CHECK(header.size() % 64 == 0);
    CHECK(header.substr(0, 8) == std::string("\x93NUMPY\x01\x00", 8));
    CHECK_THAT(header,
               ContainsSubstring("{'descr': '<u4', 'fortran_order': False, 'shape': (5,), }"));
    CHECK(header.back() == '\n');
    CHECK_THAT(npy_header(ElementType::float32, {}), ContainsSubstring("'shape': ()"));
}

TEST_CASE("npy: a file that is not one, or not whole, is named with what was expected",
          "[verify][npy][errors]") {
    const TemporaryFolder folder;
    const auto file = folder / "a.npy";
    const auto error = [&] { return error_of([&] { read_npy(file); }); };
    CHECK_THAT(error(), ContainsSubstring("a.npy") && ContainsSubstring("cannot be read"));
    write(file);
    const std::string good = slurp(file);
    spill(file, good.substr(0, good.size() - 4));
    CHECK_THAT(error(),
               ContainsSubstring("expected 24 bytes of data for float32 [3, 2], found 20"));
    spill(file, good + "more");
    CHECK_THAT(error(), ContainsSubstring("found 28"));
    spill(file, good.substr(0, 40));
    CHECK_THAT(error(), ContainsSubstring("ends within its .npy header"));
    spill(file, "PK\x03\x04 something else entirely");
    CHECK_THAT(error(), ContainsSubstring("expected a .npy file of version 1.0"));
    spill(file, replaced(good, "<f4", ">f4"));
    CHECK_THAT(error(),
               ContainsSubstring("expected elements of type |u1, <u4, <u8 or <f4, found '>f4'"));
    spill(file, replaced(good, "<f4", "<f8"));
    CHECK_THAT(error(), ContainsSubstring("found '<f8'"));
    spill(file, replaced(good, "False", "True "));
    CHECK_THAT(error(), ContainsSubstring("Fortran order"));
    spill(file, replaced(good, "(3, 2)", "[3, 2]"));
    CHECK_THAT(error(), ContainsSubstring("expected a shape"));
    spill(file, replaced(good, "(3, 2), }                ", "(9999999999999999999,)}  "));
    CHECK_THAT(error(), ContainsSubstring("a.npy"));
    spill(file, replaced(good, "'shape'", "'shade'"));
    CHECK_THAT(error(), ContainsSubstring("expected 'shape' in the .npy header"));
    CHECK_THAT(error_of([&] { write(folder / "no" / "such.npy"); }),
               ContainsSubstring("such.npy") && ContainsSubstring("cannot be written"));
}

TEST_CASE("npy: hashes are XXH64 of the bytes", "[verify][npy]") {
    CHECK(hash_text("", 0) == "ef46db3751d8e999");
    CHECK(hash_text("a", 1) == "d24ec4f1a98c6e5b");
}

}  // namespace
