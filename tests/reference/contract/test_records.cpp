
#include "reference/contract/scene.h"
#include "reference/numerics/intersect_triangle.h"
#include "reference/numerics/rng.h"
#include "tests/catch.h"

using namespace scotty::reference;

TEST_CASE("records: a dead ray is dead and hits nothing", "[reference][records]") {
    const Ray ray = dead_ray();
    CHECK(is_dead(ray));
    Hit hit = no_hit();
    CHECK_FALSE(intersect_triangle(ray, safe_inverse(ray.direction), ray_shear(ray.direction),
                                   Vec3(-1, -1, 1), Vec3(1, -1, 1), Vec3(0, 1, 1), hit));
    CHECK_FALSE(is_hit(hit));
}
