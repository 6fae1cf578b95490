#include "reference/contract/pipeline_parameters.h"

#include <fmt/format.h>

#include <array>
#include <span>
#include <string_view>
#include <utility>

#include "reference/base/error.h"

namespace scotty::reference {
namespace {

/// More pixels than this are taken for a slip of the keyboard: the image alone is 3 GiB.
constexpr std::uint64_t kMaxPixels = 1ull << 28;

template <class Enum>
struct Word {
    Enum value;
    const char* word;
};

constexpr std::array kEarlyOutWords{Word<EarlyOut>{EarlyOut::off, "off"},
                                    Word<EarlyOut>{EarlyOut::level, "level"},
                                    Word<EarlyOut>{EarlyOut::immediate, "immediate"}};
constexpr std::array kBlockOrderWords{Word<BlockOrder>{BlockOrder::linear, "linear"},
                                      Word<BlockOrder>{BlockOrder::strided, "strided"}};
constexpr std::array kHitModeWords{Word<HitMode>{HitMode::buffer, "buffer"},
                                   Word<HitMode>{HitMode::packed, "packed"}};
constexpr std::array kShadowQueryWords{Word<ShadowQuery>{ShadowQuery::any, "any"},
                                       Word<ShadowQuery>{ShadowQuery::closest, "closest"}};
constexpr std::array kFilterWords{
    Word<Filter>{Filter::none, "none"}, Word<Filter>{Filter::gaussian, "gaussian"},
    Word<Filter>{Filter::bilateral, "bilateral"}, Word<Filter>{Filter::median, "median"}};
constexpr std::array kArithmeticWords{Word<Arithmetic>{Arithmetic::exact, "exact"},
                                      Word<Arithmetic>{Arithmetic::fast, "fast"}};

template <class Enum, std::size_t Count>
const char* word_of(const std::array<Word<Enum>, Count>& words, Enum value) {
    for (const auto& entry : words) {
        if (entry.value == value) return entry.word;
    }
    return "(invalid)";
}

template <class Enum, std::size_t Count>
Enum value_of(const std::array<Word<Enum>, Count>& words, std::string_view parameter,
              const std::string& word) {
    std::string valid;
    for (const auto& entry : words) {
        if (word == entry.word) return entry.value;
        valid += (valid.empty() ? "" : ", ") + std::string(entry.word);
    }
    throw Error::bad_input(std::string(parameter),
                           fmt::format("expected one of {}, found '{}'", valid, word));
}

void expect_range(std::string_view parameter, std::uint64_t value, std::uint64_t low,
                  std::uint64_t high) {
    if (low <= value && value <= high) return;
    throw Error::bad_input(std::string(parameter),
                           fmt::format("expected {}..{}, found {}", low, high, value));
}

/// The same for signed parameters, so that a negative value is printed as it was given.
void expect_int_range(std::string_view parameter, int value, int low, int high) {
    if (low <= value && value <= high) return;
    throw Error::bad_input(std::string(parameter),
                           fmt::format("expected {}..{}, found {}", low, high, value));
}

}  // namespace

void validate(const PipelineParameters& p) {
    expect_range("image width", p.image_width, 1, 65536);
    expect_range("image height", p.image_height, 1, 65536);
    const std::uint64_t pixels = std::uint64_t{p.image_width} * p.image_height;
    if (pixels > kMaxPixels) {
        throw Error::bad_input(
            "image size", fmt::format("expected at most {} pixels, found {}x{} = {} pixels; render "
                                      "it in parts or smaller",
                                      kMaxPixels, p.image_width, p.image_height, pixels));
    }
    expect_range("samples per pixel", p.spp, 1, 1u << 20);
    expect_range("bounces", p.bounces, 0, 64);
    expect_range("light samples", p.light_samples, 0, 64);
    if (p.width != 2 && p.width != 4 && p.width != 8 && p.width != 16) {
        throw Error::bad_input("tree width",
                               fmt::format("expected 2, 4, 8 or 16, found {}", p.width));
    }
    expect_int_range("rays per block", p.rays_per_block, 32, 1024);
    if (p.rays_per_block % 32 != 0) {
        throw Error::bad_input(
            "rays per block",
            fmt::format("expected a multiple of 32 (whole warps), found {}", p.rays_per_block));
    }
    expect_int_range("triangles a leaf", p.max_leaf_size, 1, 64);
    if (p.queue_levels != 0) expect_range("queue levels (0: all)", p.queue_levels, 1, 64);
    expect_range("hit capacity", p.hit_capacity, 1, 65536);
    expect_range("rays a batch", p.batch_rays, 1, 1u << 28);
    expect_range("samples a pass (0: all)", p.samples_per_pass, 0, 1u << 20);
}

const char* to_string(EarlyOut value) { return word_of(kEarlyOutWords, value); }
const char* to_string(BlockOrder value) { return word_of(kBlockOrderWords, value); }
const char* to_string(HitMode value) { return word_of(kHitModeWords, value); }
const char* to_string(ShadowQuery value) { return word_of(kShadowQueryWords, value); }
const char* to_string(Filter value) { return word_of(kFilterWords, value); }
const char* to_string(Arithmetic value) { return word_of(kArithmeticWords, value); }

EarlyOut parse_early_out(const std::string& word) {
    return value_of(kEarlyOutWords, "early-out", word);
}
BlockOrder parse_block_order(const std::string& word) {
    return value_of(kBlockOrderWords, "block order", word);
}
HitMode parse_hit_mode(const std::string& word) {
    return value_of(kHitModeWords, "hit mode", word);
}
ShadowQuery parse_shadow_query(const std::string& word) {
    return value_of(kShadowQueryWords, "shadow query", word);
}
Filter parse_filter(const std::string& word) { return value_of(kFilterWords, "filter", word); }
Arithmetic parse_arithmetic(const std::string& word) {
    return value_of(kArithmeticWords, "arithmetic", word);
}

}  // namespace scotty::reference
