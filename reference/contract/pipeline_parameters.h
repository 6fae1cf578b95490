/// Every knob of the pipeline in one plain struct, recorded with whatever comes out of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace scotty::reference {

/// When a ray stops being pushed on, given the nearest hit known so far ("early out" of the paper).
enum class EarlyOut {
    off,       ///< never: every box overlapped is visited
    level,     ///< by the minimum as of the end of the level before: deterministic
    immediate  ///< by the minimum at this moment, while other blocks lower it: never wrong, only
               ///< late
};

/// Which rays a block takes: its linear index, or the 2018 paper's 2-D grid that spreads
/// neighbouring blocks over different nodes ("block striding").
enum class BlockOrder { linear, strided };

/// Where the rays of a level wait.
enum class QueueKind {
    nodes,  ///< the 2018 paper's: each node has a queue of ray ids
    pairs   ///< each level below the root has one queue, of pairs of an inner node and a ray; the
            ///< launch that finds a leaf tests it
};

/// How hits of concurrent leaves come together.
enum class HitMode {
    buffer,  ///< the 2018 paper's multi-intersection buffer, one atomicAdd a hit, merged afterwards
    packed   ///< one 64-bit atomicMin of (t, primitive) a hit
};

/// What a shadow query asks for.
enum class ShadowQuery {
    any,     ///< is anything in the way: a ray is done with its first hit (under an early-out)
    closest  ///< the 2018 paper's: a closest-hit traversal up to the light
};

/// Which arithmetic the kernels are compiled to.
enum class Arithmetic {
    exact,  ///< IEEE operations only, no contraction: the same bits everywhere
    fast    ///< the device's approximate division and square root, and contraction; CUDA only
};

enum class Filter { none, gaussian, bilateral, median };

struct PipelineParameters {
    std::uint32_t image_width = 256;   ///< pixels, 1..65536
    std::uint32_t image_height = 256;  ///< pixels, 1..65536
    std::uint32_t spp = 4;             ///< samples per pixel, 1..2^20
    std::uint32_t bounces = 2;         ///< scatterings after the primary hit, 0..64
    std::uint32_t light_samples = 2;   ///< direct-light rays per path vertex, 0..64
    /// Scatterings after which a path goes on only with the probability of its throughput (Russian
    /// roulette); what survives carries the more. 0: never, each path goes on to the end.
    std::uint32_t roulette = 0;  ///< 0..64
    std::uint64_t seed = 0;

    int width = 8;            ///< children a node: 2, 4, 8 or 16
    int rays_per_block = 64;  ///< threads per block: 32..1024, a multiple of 32
    int max_leaf_size = 4;    ///< triangles per leaf, 1..1024
    /// Levels of the BVH that have queues, 1..64; below them each ray goes on depth first. 0: all.
    std::uint32_t queue_levels = 0;
    QueueKind queues = QueueKind::nodes;
    EarlyOut early_out = EarlyOut::level;
    BlockOrder block_order = BlockOrder::linear;
    HitMode hit_mode = HitMode::buffer;
    ShadowQuery shadow_query = ShadowQuery::any;
    /// Slots a ray in the multi-intersection buffer at first; grown when a ray needs more.
    std::uint32_t hit_capacity = 8;  ///< 1..65536
    /// Rays in flight at once. Images larger than that are rendered in batches, with the same bits.
    std::uint32_t batch_rays = 1u << 16;  ///< 1..2^28
    /// Samples that every pixel gets before any pixel gets its next ones: what a picture that is
    /// looked at while it is rendered wants. 0: all, each pixel is finished when its batch is.
    std::uint32_t samples_per_pass = 0;  ///< 0..2^20

    Filter filter = Filter::none;
    std::uint32_t filter_threshold = 32;  ///< a filter is applied only below so many spp (paper)

    Arithmetic arithmetic = Arithmetic::exact;
};

/// Throws bad_input naming the parameter, its value and what is allowed. Also refuses an image
/// whose pixels alone would not fit in a sensible memory (over 2^28 pixels).
void validate(const PipelineParameters& parameters);

/// Samples of a pass, at least 1; the last pass may have fewer.
inline std::uint32_t samples_of_pass(const PipelineParameters& p) {
    return p.samples_per_pass == 0 || p.samples_per_pass > p.spp ? p.spp : p.samples_per_pass;
}

const char* to_string(QueueKind value);
const char* to_string(EarlyOut value);
const char* to_string(BlockOrder value);
const char* to_string(HitMode value);
const char* to_string(ShadowQuery value);
const char* to_string(Filter value);
const char* to_string(Arithmetic value);
/// Inverse of to_string; throws bad_input naming the valid words.
QueueKind parse_queues(const std::string& word);
EarlyOut parse_early_out(const std::string& word);
BlockOrder parse_block_order(const std::string& word);
HitMode parse_hit_mode(const std::string& word);
ShadowQuery parse_shadow_query(const std::string& word);
Filter parse_filter(const std::string& word);
Arithmetic parse_arithmetic(const std::string& word);

}  // namespace scotty::reference
