#include "reference/bvh/tree_figures.h"

#include <tbb/task_arena.h>

#include <chrono>

#include "reference/base/error.h"
#include "reference/bvh/binary_bvh.h"
#include "reference/bvh/reinsertion.h"

namespace scotty::reference {

TreeFigures measure_tree(const Scene& scene, std::size_t threads) {
    if (scene.triangles.empty()) {
        throw Error::bad_input(scene.name, "expected at least one triangle, found none");
    }
    using Clock = std::chrono::steady_clock;
    const auto seconds = [](Clock::time_point begin, Clock::time_point end) {
        return std::chrono::duration<double>(end - begin).count();
    };
    TreeFigures figures;
    tbb::task_arena arena(threads == 0 ? tbb::task_arena::automatic : static_cast<int>(threads));
    arena.execute([&] {
        const Clock::time_point begin = Clock::now();
        BinaryBvh bvh = build_binary_bvh(scene);
        figures.seconds_built = seconds(begin, Clock::now());
        figures.cost_built = surface_area_cost(bvh);
        const Clock::time_point built = Clock::now();
        optimise_by_reinsertion(bvh);
        figures.seconds_optimised = seconds(built, Clock::now());
        figures.cost_optimised = surface_area_cost(bvh);
    });
    return figures;
}

}  // namespace scotty::reference
