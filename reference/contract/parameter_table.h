/// Every parameter of the pipeline as a row of one table.
///
/// Command lines, JSON, labels, messages, validation and sweeps look parameters up here.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
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
    std::string_view name;    ///< of the member, in JSON too
    std::string_view option;  ///< on command lines; image_width and image_height share one
    std::string_view title;   ///< in messages and labels
    std::string_view help;
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
inline constexpr std::array kEarlyOutWords{"off", "level", "immediate"};
inline constexpr std::array kBlockOrderWords{"linear", "strided"};
inline constexpr std::array kHitModeWords{"buffer", "packed"};
inline constexpr std::array kShadowQueryWords{"any", "closest"};
inline constexpr std::array kFilterWords{"none", "gaussian", "bilateral", "median"};
inline constexpr std::array kArithmeticWords{"exact", "fast"};

template <auto Member>
constexpr ParameterInfo access(ParameterInfo info) {
    info.get = [](const PipelineParameters& p) { return static_cast<std::uint64_t>(p.*Member); };
    info.set = [](PipelineParameters& p, std::uint64_t value) {
        using Type = std::remove_reference_t<decltype(p.*Member)>;
        p.*Member = static_cast<Type>(value);
    };
    return info;
}

}  // namespace detail

/// In the order in which captures state them.
inline constexpr std::array kParameters = [] {
    using P = PipelineParameters;
    using G = ParameterGroup;
    using detail::access;
    return std::array{
        access<&P::image_width>({.name = "image_width",
                                 .option = "--size",
                                 .title = "image width",
                                 .help = "image in pixels, any shape",
                                 .low = 1,
                                 .high = 65536}),
        access<&P::image_height>({.name = "image_height",
                                  .option = "--size",
                                  .title = "image height",
                                  .help = "image in pixels, any shape",
                                  .low = 1,
                                  .high = 65536}),
        access<&P::spp>({.name = "spp",
                         .option = "--spp",
                         .title = "samples per pixel",
                         .help = "samples per pixel",
                         .low = 1,
                         .high = 1u << 20}),
        access<&P::bounces>({.name = "bounces",
                             .option = "--bounces",
                             .title = "bounces",
                             .help = "scatterings after the primary hit",
                             .high = 64}),
        access<&P::light_samples>({.name = "light_samples",
                                   .option = "--light-samples",
                                   .title = "light samples",
                                   .help = "direct-light rays per path vertex",
                                   .high = 64}),
        access<&P::roulette>({.name = "roulette",
                              .option = "--roulette",
                              .title = "roulette",
                              .help = "scatterings after which paths end at random, by their "
                                      "throughput. 0: never",
                              .high = 64,
                              .added_later = true}),
        access<&P::seed>({.name = "seed",
                          .option = "--seed",
                          .title = "seed",
                          .help = "of the random numbers",
                          .high = ~std::uint64_t{0}}),
        access<&P::width>({.name = "width",
                           .option = "--width",
                           .title = "tree width",
                           .help = "children per node: 2, 4, 8 or 16",
                           .group = G::tree,
                           .only = detail::kWidths}),
        access<&P::rays_per_block>({.name = "rays_per_block",
                                    .option = "--rays-per-block",
                                    .title = "rays per block",
                                    .help = "threads per block: 32..1024, whole warps",
                                    .group = G::pipeline,
                                    .low = 32,
                                    .high = 1024,
                                    .multiple_of = 32}),
        access<&P::max_leaf_size>({.name = "max_leaf_size",
                                   .option = "--leaf-size",
                                   .title = "triangles per leaf",
                                   .help = "triangles per leaf, at most",
                                   .group = G::tree,
                                   .low = 1,
                                   .high = 1024}),
        access<&P::queue_levels>({.name = "queue_levels",
                                  .option = "--queue-levels",
                                  .title = "queue levels",
                                  .help = "levels that have queues; below them each ray goes on "
                                          "depth first. 0: all have",
                                  .group = G::tree,
                                  .high = 64,
                                  .zero_is_all = true,
                                  .added_later = true}),
        access<&P::early_out>({.name = "early_out",
                               .option = "--early-out",
                               .title = "early-out",
                               .help = "stop pushing rays on behind their nearest hit",
                               .group = G::pipeline,
                               .words = detail::kEarlyOutWords}),
        access<&P::block_order>({.name = "block_order",
                                 .option = "--block-order",
                                 .title = "block order",
                                 .help = "which rays a block takes",
                                 .group = G::pipeline,
                                 .words = detail::kBlockOrderWords}),
        access<&P::hit_mode>({.name = "hit_mode",
                              .option = "--hit-mode",
                              .title = "hit mode",
                              .help = "how hits of several leaves come together",
                              .group = G::pipeline,
                              .words = detail::kHitModeWords}),
        access<&P::shadow_query>({.name = "shadow_query",
                                  .option = "--shadow-query",
                                  .title = "shadow query",
                                  .help = "what a shadow ray asks for",
                                  .group = G::pipeline,
                                  .words = detail::kShadowQueryWords}),
        access<&P::hit_capacity>({.name = "hit_capacity",
                                  .option = "--hit-capacity",
                                  .title = "hit capacity",
                                  .help = "hit slots per ray at first; they grow",
                                  .group = G::pipeline,
                                  .low = 1,
                                  .high = 65536}),
        access<&P::batch_rays>({.name = "batch_rays",
                                .option = "--batch-rays",
                                .title = "rays per batch",
                                .help = "rays in flight at once",
                                .group = G::pipeline,
                                .low = 1,
                                .high = 1u << 28}),
        access<&P::samples_per_pass>({.name = "samples_per_pass",
                                      .option = "--samples-per-pass",
                                      .title = "samples per pass",
                                      .help = "samples that all pixels get before any gets its "
                                              "next. 0: all",
                                      .group = G::pipeline,
                                      .high = 1u << 20,
                                      .zero_is_all = true,
                                      .added_later = true}),
        access<&P::filter>({.name = "filter",
                            .option = "--filter",
                            .title = "filter",
                            .help = "smooths an image of few samples",
                            .group = G::filter,
                            .words = detail::kFilterWords}),
        access<&P::filter_threshold>({.name = "filter_threshold",
                                      .option = "--filter-threshold",
                                      .title = "filter threshold",
                                      .help = "samples per pixel from which on nothing is filtered",
                                      .group = G::filter,
                                      .high = 0xffffffffu}),
        access<&P::arithmetic>({.name = "arithmetic",
                                .option = "--arithmetic",
                                .title = "arithmetic",
                                .help = "fast: approximate, with --backend cuda only",
                                .group = G::arithmetic,
                                .words = detail::kArithmeticWords})};
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
                       std::span<const ParameterGroup> groups);

}  // namespace scotty::reference
