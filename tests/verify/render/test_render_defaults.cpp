/// What a back end is given where nobody asks for anything.

#include "tests/catch.h"
#include "tests/verify/capture_tools.h"
#include "verify/render/render_defaults.h"

namespace scotty::verify::test {

TEST_CASE("render defaults: a device's batches are as large as its free memory allows",
          "[verify][render]") {
    const auto batch = [](std::size_t free_memory, std::string_view given) {
        Backend device;
        device.name = "cuda";
        device.free_memory = free_memory;
        reference::PipelineParameters p;
        p.image_width = p.image_height = 16;
        p.batch_rays = 5;
        set_render_defaults(device, p, [&](std::string_view option) { return option == given; });
        return p;
    };
    CHECK(batch(std::size_t{1} << 37, "").batch_rays == 1u << 22);
    CHECK(batch(std::size_t{1} << 31, "").batch_rays == 1u << 20);
    CHECK(batch(1, "").batch_rays == 1u << 16);
    CHECK(batch(std::size_t{1} << 37, "--batch-rays").batch_rays == 5);
    CHECK(batch(std::size_t{1} << 37, "").width == 4);
    CHECK(batch(std::size_t{1} << 37, "--width").width == 8);
    CHECK(batch(std::size_t{1} << 37, "").queue_levels == 1);
}

}  // namespace scotty::verify::test
