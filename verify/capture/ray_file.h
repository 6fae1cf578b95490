/// Rays, hits and scenes in the small binary files that other tracers' programs exchange.
///
/// Little endian, no padding (docs/captures.md):
///  - rays:      "RAY1", u32 n, u32 any_hit, then n x {origin[3], t_min, direction[3], t_max}
///  - reference: "REF1", u32 n, then n hits
///  - hits:      n x {float t, u32 primitive}, no header
///  - scene:     "SCN1", u32 vertices, u32 triangles, float[vertices][3], u32[triangles][3]
/// A miss is (+infinity, 0xffffffff). Of an any-hit query t is 0 and primitive 1 where something
/// is hit, 0 where nothing is.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "reference/contract/records.h"
#include "reference/contract/scene.h"

namespace scotty::verify {

struct RayFile {
    std::vector<reference::Ray> rays;
    bool any_hit = false;
};

/// Throws bad_input naming the file: not there, another kind of file, cut short or too long; and
/// the ray: NaN or infinite origin or direction, an origin beyond 1e12, a direction that is zero or
/// whose largest component is not within 1e-12 .. 1e12, negative or NaN t_min, NaN t_max.
RayFile read_rays(const std::filesystem::path& file);
void write_rays(const std::filesystem::path& file, const RayFile& rays);

/// `count`: how many there must be. Throws bad_input as above.
std::vector<reference::HitCandidate> read_reference(const std::filesystem::path& file,
                                                    std::size_t count);
/// Of a file without header: every 8 bytes a hit.
std::vector<reference::HitCandidate> read_hits(const std::filesystem::path& file);
void write_hits(const std::filesystem::path& file, std::span<const reference::HitCandidate> hits);

/// What such files say of a hit.
reference::HitCandidate hit_record(const reference::Hit& hit, bool any_hit);

/// Triangles only: one grey material, no light, a default camera. Validated; its repairs are in
/// the scene's warnings. Throws bad_input naming file and element.
reference::Scene read_scene_file(const std::filesystem::path& file);
/// The scene's triangles in their order, so that a hit's primitive is the same.
void write_scene_file(const std::filesystem::path& file, const reference::Scene& scene);

}  // namespace scotty::verify
