#include <catch2/catch.hpp>

#include "reference/base/error.h"
#include "scenes/scenes.h"

using namespace scotty;
using Catch::Matchers::Contains;
using scenes::load_scene;

TEST_CASE("specification: an unknown scene names the ones that exist", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("teapot"), Contains("no such scene") && Contains("cornell") &&
                                                Contains("slivers") && Contains(".dae"));
    CHECK_THROWS_WITH(load_scene(""), Contains("no such scene"));
    CHECK_THROWS_WITH(load_scene("Cornell"), Contains("no such scene"));
    try {
        load_scene("teapot");
    } catch (const reference::Error& error) {
        CHECK(error.kind() == reference::ErrorKind::bad_input);
    }
}

TEST_CASE("specification: an unknown parameter names the ones that exist", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("coil:radius=2"), Contains("no parameter 'radius'") &&
                                                       Contains("turns") && Contains("segments"));
    CHECK_THROWS_WITH(load_scene("cornell:a=1"), Contains("it has no parameters"));
}

TEST_CASE("specification: a value out of range, not whole or no number is an error", "[scenes]") {
    const char* bad =
        GENERATE("coil:segments=2", "coil:segments=10.5", "coil:segments=many",
                 "coil:segments=", "coil:segments=nan", "coil:segments=-5", "coil:turns=inf",
                 "furnace:albedo=1", "veil:layers=0", "blob:triangles=2e8 ", "blob:triangles=1e99");
    CHECK_THROWS_WITH(load_scene(bad), Contains("expected") && Contains(" from "));
}

TEST_CASE("specification: text that is no assignment, or twice the same, is an error", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("coil:8"), Contains("not of the form key=value"));
    CHECK_THROWS_WITH(load_scene("coil:turns=2,"), Contains("not of the form key=value"));
    CHECK_THROWS_WITH(load_scene("coil:turns=2,turns=3"), Contains("given twice"));
    CHECK_NOTHROW(load_scene("coil:"));
}

TEST_CASE("specification: absurd sizes end in an error, not in a crash", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("blob:triangles=200000001"),
                      Contains("20 to 200000000") || Contains("from 20 to"));
    CHECK_THROWS_WITH(load_scene("coil:segments=100000000,sides=1000000"),
                      Contains("at most 200000000"));
}

TEST_CASE("specification: a file that is not there, a directory, a foreign extension", "[scenes]") {
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.dae"), Contains("no such file"));
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.obj#camera=fit"), Contains("no such file"));
    CHECK_THROWS_WITH(load_scene("/tmp"), Contains("expected a scene file, found a directory"));
    CHECK_THROWS_WITH(load_scene("/dev/null"), Contains("expected a scene file"));
    CHECK_THROWS_WITH(load_scene("/etc/passwd"), Contains("expected a .dae"));
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.dae#camera=mine"),
                      Contains("#camera=file") && Contains("#camera=fit"));
    for (const char* choice : {"#lights=some", "#", "#lights=none,", "#camera=fit,camera"}) {
        CHECK_THROWS_WITH(load_scene(std::string("/nowhere/scene.dae") + choice),
                          Contains("#lights=none"));
    }
    CHECK_THROWS_WITH(load_scene("/nowhere/scene.dae#lights=none,camera=fit"),
                      Contains("no such file"));
}
