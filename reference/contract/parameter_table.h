/// Every parameter of the pipeline as a row of one table.
///
/// Command lines, JSON, labels, messages, validation and sweeps look parameters up here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

#include "reference/contract/pipeline_parameters.h"

namespace scotty::reference {

/// What a parameter is about.
enum class ParameterGroup {
    picture,     ///< it changes the image
    tree,        ///< it changes the BVH
    pipeline,    ///< it changes how the pipeline works, and no bit of the image
    filter,      ///< it changes what becomes of the finished image
    arithmetic,  ///< it changes the image within a tolerance
};

struct ParameterInfo {
    std::string_view name = {};    ///< of the member, in JSON too
    std::string_view option = {};  ///< on command lines; image_width and image_height share one
    std::string_view title = {};   ///< in messages and labels
    std::string_view help = {};
    ParameterGroup group = ParameterGroup::picture;
    /// Valid numbers; of an enumeration its words.
    std::uint64_t low = 0, high = 0;
    std::uint64_t multiple_of = 1;
    std::span<const std::uint64_t> only = {};  ///< where few numbers are valid
    std::span<const char* const> words = {};   ///< by value of the enumeration
    bool zero_is_all = false;                  ///< 0 stands for no limit
    /// Files from before it was there lack it, and so do files where it is 0.
    bool added_later = false;
    /// As an unsigned number; a negative value keeps its bits.
    std::uint64_t (*get)(const PipelineParameters&) = nullptr;
    void (*set)(PipelineParameters&, std::uint64_t) = nullptr;
};

namespace detail {

inline constexpr std::array<std::uint64_t, 4> kWidths{2, 4, 8, 16};
inline constexpr std::array kQueueKindWords{"nodes", "pairs"};
inline constexpr std::array kEarlyOutWords{"off", "level", "immediate"};
inline constexpr std::array kBlockOrderWords{"linear", "strided"};
inline constexpr std::array kHitModeWords{"buffer", "packed"};
inline constexpr std::array kShadowQueryWords{"any", "closest"};
inline constexpr std::array kFilterWords{"none", "gaussian", "bilateral", "median"};
inline constexpr std::array kArithmeticWords{"exact", "fast"};

/// A row; `values` says which are valid.
template <auto Member>
constexpr ParameterInfo row(std::string_view name, std::string_view option, std::string_view title,
                            std::string_view help, ParameterGroup group, ParameterInfo values) {
    values.name = name;
    values.option = option;
    values.title = title;
    values.help = help;
    values.group = group;
    values.get = [](const PipelineParameters& p) { return static_cast<std::uint64_t>(p.*Member); };
    values.set = [](PipelineParameters& p, std::uint64_t value) {
        using Type = std::remove_reference_t<decltype(p.*Member)>;
        p.*Member = static_cast<Type>(value);
    };
    return values;
}

}  // namespace detail

/// In the order in which captures state them.
inline constexpr std::array kParameters = [] {
    using P = PipelineParameters;
    using G = ParameterGroup;
    using detail::row;
    return std::array{
        row<&P::image_width>("image_width", "--size", "image width", "image in pixels, any shape",
                             G::picture, {.low = 1, .high = 65536}),
        row<&P::image_height>("image_height", "--size", "image height",
                              "image in pixels, any shape", G::picture, {.low = 1, .high = 65536}),
        row<&P::spp>("spp", "--spp", "samples per pixel", "samples per pixel", G::picture,
                     {.low = 1, .high = 1u << 20}),
        row<&P::bounces>("bounces", "--bounces", "bounces", "scatterings after the primary hit",
                         G::picture, {.high = 64}),
        row<&P::light_samples>("light_samples", "--light-samples", "light samples",
                               "direct-light rays per path vertex", G::picture, {.high = 64}),
        row<&P::roulette>(
            "roulette", "--roulette", "roulette",
            "scatterings after which paths end at random, by their throughput. 0: never",
            G::picture, {.high = 64, .added_later = true}),
        row<&P::seed>("seed", "--seed", "seed", "of the random numbers", G::picture,
                      {.high = ~std::uint64_t{0}}),
        row<&P::width>("width", "--width", "tree width", "children per node: 2, 4, 8 or 16",
                       G::tree, {.only = detail::kWidths}),
        row<&P::rays_per_block>("rays_per_block", "--rays-per-block", "rays per block",
                                "threads per block: 32..1024, whole warps", G::pipeline,
                                {.low = 32, .high = 1024, .multiple_of = 32}),
        row<&P::max_leaf_size>("max_leaf_size", "--leaf-size", "triangles per leaf",
                               "triangles per leaf, at most", G::tree, {.low = 1, .high = 1024}),
        row<&P::queue_levels>(
            "queue_levels", "--queue-levels", "queue levels",
            "levels that have queues; below them each ray goes on depth first. 0: all have",
            G::tree, {.high = 64, .zero_is_all = true, .added_later = true}),
        row<&P::queues>("queues", "--queues", "queues",
                        "a queue per node, or per level one of (node, ray) pairs", G::pipeline,
                        {.words = detail::kQueueKindWords, .added_later = true}),
        row<&P::early_out>("early_out", "--early-out", "early-out",
                           "stop pushing rays on behind their nearest hit", G::pipeline,
                           {.words = detail::kEarlyOutWords}),
        row<&P::block_order>("block_order", "--block-order", "block order",
                             "which rays a block takes", G::pipeline,
                             {.words = detail::kBlockOrderWords}),
        row<&P::hit_mode>("hit_mode", "--hit-mode", "hit mode",
                          "how hits of several leaves come together", G::pipeline,
                          {.words = detail::kHitModeWords}),
        row<&P::shadow_query>("shadow_query", "--shadow-query", "shadow query",
                              "what a shadow ray asks for", G::pipeline,
                              {.words = detail::kShadowQueryWords}),
        row<&P::hit_capacity>("hit_capacity", "--hit-capacity", "hit capacity",
                              "hit slots per ray at first; they grow", G::pipeline,
                              {.low = 1, .high = 65536}),
        row<&P::batch_rays>("batch_rays", "--batch-rays", "rays per batch",
                            "rays in flight at once", G::pipeline, {.low = 1, .high = 1u << 28}),
        row<&P::samples_per_pass>("samples_per_pass", "--samples-per-pass", "samples per pass",
                                  "samples that all pixels get before any gets its next. 0: all",
                                  G::pipeline,
                                  {.high = 1u << 20, .zero_is_all = true, .added_later = true}),
        row<&P::filter>("filter", "--filter", "filter", "smooths an image of few samples",
                        G::filter, {.words = detail::kFilterWords}),
        row<&P::filter_threshold>("filter_threshold", "--filter-threshold", "filter threshold",
                                  "samples per pixel from which on nothing is filtered", G::filter,
                                  {.high = 0xffffffffu}),
        row<&P::arithmetic>("arithmetic", "--arithmetic", "arithmetic",
                            "fast: approximate, with --backend cuda only", G::arithmetic,
                            {.words = detail::kArithmeticWords})};
}();

/// The row of that name; a name that is in no row does not compile.
consteval const ParameterInfo& parameter(std::string_view name) {
    for (const ParameterInfo& info : kParameters) {
        if (info.name == name) return info;
    }
    throw "no parameter has this name";
}

/// The value as command lines and JSON write it: a word of an enumeration, or a number.
std::string text_of(const ParameterInfo& info, const PipelineParameters& parameters);
/// The valid values, as "32..1024" or "off, level, immediate".
std::string valid_values(const ParameterInfo& info);
/// Sets it from such a text. Throws bad_input naming the parameter and what is allowed.
void set_from_text(const ParameterInfo& info, PipelineParameters& parameters,
                   const std::string& text);
/// "--width 8 --queue-levels 0 ...": the options of some parameters, ready for a command line.
std::string options_of(const PipelineParameters& parameters,
                       std::initializer_list<ParameterGroup> groups);

}  // namespace scotty::reference
