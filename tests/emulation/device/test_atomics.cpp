/// Atomics under contention, and distances ordered by their bits.
#include <limits>
#include <vector>

#include "emulation/device/atomics.h"
#include "emulation/device/device.h"
#include "emulation/kernels/views.h"
#include "reference/base/vec3.h"
#include "tests/catch.h"

using namespace scotty::emulation;
using scotty::reference::kInfinity;

TEST_CASE("atomics: no addition is lost and every caller gets another slot",
          "[emulation][atomics]") {
    constexpr std::uint32_t kItems = 100000;
    Device device({2, ScheduleKind::free, 0});
    std::uint32_t counter = 0;
    std::vector<std::uint8_t> taken(kItems, 0);
    device.launch_per_item(kItems, [&](std::uint32_t) { taken.at(atomic_add(counter, 1)) += 1; });
    CHECK(counter == kItems);
    CHECK(taken == std::vector<std::uint8_t>(kItems, 1));
}

TEST_CASE("atomics: minima and maxima under contention are those of a plain loop",
          "[emulation][atomics]") {
    constexpr std::uint32_t kItems = 100000;
    Device device({2, ScheduleKind::free, 0});
    std::uint64_t least = ~std::uint64_t{0};
    std::uint32_t most = 0;
    float nearest = kInfinity;
    const auto scrambled = [](std::uint32_t i) { return i * 2654435761u % kItems; };
    device.launch_per_item(kItems, [&](std::uint32_t i) {
        atomic_min(least, (std::uint64_t{scrambled(i)} + 17) << 32);
        atomic_max(most, scrambled(i));
        atomic_min_distance(nearest, 0.5f + static_cast<float>(scrambled(i)));
    });
    CHECK(least == std::uint64_t{17} << 32);
    CHECK(most == kItems - 1);
    CHECK(nearest == 0.5f);
}

TEST_CASE("atomics: distances are ordered: done, zero, denormal, one, infinity",
          "[emulation][atomics]") {
    const std::vector<float> ascending{kDone,
                                       0.0f,
                                       std::numeric_limits<float>::denorm_min(),
                                       1.0f,
                                       std::nextafter(1.0f, 2.0f),
                                       std::numeric_limits<float>::max(),
                                       kInfinity};
    for (std::size_t i = 0; i < ascending.size(); ++i) {
        for (std::size_t j = 0; j < ascending.size(); ++j) {
            float target = ascending[i];
            atomic_min_distance(target, ascending[j]);
            CHECK(target == ascending[std::min(i, j)]);
        }
    }
    float value = 2.0f;
    CHECK(load_relaxed(value) == 2.0f);
}
