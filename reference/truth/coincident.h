/// Which of several triangles in exactly the same place is seen.
#pragma once

#include <cstdint>
#include <vector>

#include "reference/contract/scene.h"

namespace scotty::reference {

/// No light could tell which one it is, so the contract's triangle test and tie rule say so.
class CoincidentTriangles {
 public:
    /// Keeps a reference to the scene.
    explicit CoincidentTriangles(const Scene& scene);

    /// `hit`, or the triangle in its place that the contract prefers, with the contract's distance.
    Hit seen(const Ray& ray, const Hit& hit) const;

 private:
    const Scene& scene_;
    /// By triangle: all that lie exactly on it, itself included; empty where it is alone.
    std::vector<std::vector<std::uint32_t>> places_;
};

}  // namespace scotty::reference
