/// Small scenes that a verification mixes from properties that code paths depend on: how the
/// triangles lie, what lights them, who looks at them. "probe:geometry=2,lights=6,camera=1".
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace scotty::scenes {

/// Names by the number that the parameter `geometry` takes.
const std::vector<std::string>& probe_geometries();
/// The number of the geometry that has a level of more than 65,536 nodes; all others are small.
std::size_t probe_field();
/// Names by the number that the parameter `lights` takes.
const std::vector<std::string>& probe_lights();
/// Names by the number that the parameter `camera` takes.
const std::vector<std::string>& probe_cameras();

}  // namespace scotty::scenes
