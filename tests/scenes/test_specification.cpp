
#include "reference/base/error.h"
#include "scenes/scenes.h"
#include "tests/catch.h"

using namespace scotty;
using Catch::Matchers::ContainsSubstring;
using scenes::load_scene;

TEST_CASE("specification: an unknown scene names the ones that exist", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("teapot"),
                      ContainsSubstring("no such scene") && ContainsSubstring("cornell") &&
                          ContainsSubstring("slivers") && ContainsSubstring(".dae"));
    CHECK_THROWS_WITH(load_scene(""), ContainsSubstring("no such scene"));
    CHECK_THROWS_WITH(load_scene("Cornell"), ContainsSubstring("no such scene"));
    try {
        load_scene("teapot");
    } catch (const reference::Error& error) {
        CHECK(error.kind() == reference::ErrorKind::bad_input);
    }
}

TEST_CASE("specification: an unknown parameter names the ones that exist", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("coil:radius=2"), ContainsSubstring("no parameter 'radius'") &&
                                                       ContainsSubstring("turns") &&
                                                       ContainsSubstring("segments"));
    CHECK_THROWS_WITH(load_scene("cornell:a=1"), ContainsSubstring("it has no parameters"));
}

TEST_CASE("specification: a value out of range, not whole or no number is an error", "[scenes]") {
    const char* bad =
        GENERATE("coil:segments=2", "coil:segments=10.5", "coil:segments=many",
                 "coil:segments=", "coil:segments=nan", "coil:segments=-5", "coil:turns=inf",
                 "furnace:albedo=1", "veil:layers=0", "blob:triangles=2e8 ", "blob:triangles=1e99");
    CHECK_THROWS_WITH(load_scene(bad),
                      ContainsSubstring("expected") && ContainsSubstring(" from "));
}

TEST_CASE("specification: text that is no assignment, or twice the same, is an error", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("coil:8"), ContainsSubstring("not of the form key=value"));
    CHECK_THROWS_WITH(load_scene("coil:turns=2,"), ContainsSubstring("not of the form key=value"));
    CHECK_THROWS_WITH(load_scene("coil:turns=2,turns=3"), ContainsSubstring("given twice"));
    CHECK_NOTHROW(load_scene("coil:"));
}

TEST_CASE("specification: absurd sizes end in an error, not in a crash", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("blob:triangles=200000001"),
                      ContainsSubstring("20 to 200000000") || ContainsSubstring("from 20 to"));
    CHECK_THROWS_WITH(load_scene("coil:segments=100000000,sides=1000000"),
                      ContainsSubstring("at most 200000000"));
}

TEST_CASE("specification: a file that is not there, a directory, a foreign extension", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.dae"), ContainsSubstring("no such file"));
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.obj#camera=fit"),
                      ContainsSubstring("no such file"));
    CHECK_THROWS_WITH(load_scene("/tmp"),
                      ContainsSubstring("expected a scene file, found a directory"));
    CHECK_THROWS_WITH(load_scene("/dev/null"), ContainsSubstring("expected a scene file"));
    CHECK_THROWS_WITH(load_scene("/etc/passwd"), ContainsSubstring("expected a .dae"));
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.dae#camera=mine"),
                      ContainsSubstring("no such file"));
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.dae#camera="),
                      ContainsSubstring("#camera=file") && ContainsSubstring("#camera=NAME"));
    for (const char* choice : {"#lights=some", "#", "#lights=none,", "#camera=fit,camera"}) {
        CHECK_THROWS_WITH(load_scene(std::string("/nowhere/scene.dae") + choice),
                          ContainsSubstring("#lights=none"));
    }
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.dae#lights=none,camera=fit"),
                      ContainsSubstring("no such file"));
}
