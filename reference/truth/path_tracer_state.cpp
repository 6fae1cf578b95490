#include "reference/truth/path_tracer_state.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "reference/base/error.h"
#include "reference/base/write_file.h"
#include "reference/truth/path_tracer.h"

namespace scotty::reference {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "sums are stored as they lie in memory");

namespace {

constexpr std::string_view kSamples = "samples ";

std::string identity_of(const Scene& scene, const PipelineParameters& p) {
    return fmt::format(
        "path tracer state, version {}\nscene {:016x}\nimage {}x{}\nbounces {}\nlights {}\n"
        "seed {}\n",
        kPathTracerVersion, fingerprint(scene), p.image_width, p.image_height, p.bounces,
        p.light_samples > 0 ? "sampled" : "found by paths", p.seed);
}

std::string next_line(std::string_view& text) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    return line;
}

void append(std::string& to, const std::vector<SampleSums::Color>& colors) {
    to.append(reinterpret_cast<const char*>(colors.data()), colors.size() * sizeof(colors[0]));
}
void take(std::string_view& from, std::vector<SampleSums::Color>& colors) {
    const std::size_t bytes = colors.size() * sizeof(colors[0]);
    std::memcpy(colors.data(), from.data(), bytes);
    from.remove_prefix(bytes);
}

std::uint64_t hash_of(std::string_view bytes) { return XXH64(bytes.data(), bytes.size(), 0); }

}  // namespace

PathTracerState::PathTracerState(fs::path file, const Scene& scene,
                                 const PipelineParameters& parameters)
    : file_(std::move(file)),
      identity_(identity_of(scene, parameters)),
      width_(parameters.image_width),
      height_(parameters.image_height) {}

SampleSums PathTracerState::load() const {
    SampleSums sums(width_, height_);
    std::error_code ignored;
    if (file_.empty() || !fs::exists(file_, ignored)) return sums;
    std::ifstream in(file_, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (!in) throw Error::bad_input(file_.string(), "cannot be read");

    std::string_view found(bytes);
    for (std::string_view expected(identity_); !expected.empty();) {
        const std::string ours = next_line(expected);
        const std::string theirs = next_line(found);
        if (ours == theirs) continue;
        throw Error::bad_input(
            file_.string(),
            fmt::format("expected '{}', found '{:.60}': it is of another run; remove it, or name "
                        "another file",
                        ours, theirs));
    }
    const std::string samples = next_line(found);
    const bool has_samples = samples.starts_with(kSamples);
    const char* last = samples.data() + samples.size();
    const auto parsed =
        std::from_chars(samples.data() + (has_samples ? kSamples.size() : 0), last, sums.samples);
    const bool whole = has_samples && parsed.ec == std::errc() && parsed.ptr == last &&
                       next_line(found).empty() &&
                       found.size() == 2 * sums.sum.size() * sizeof(sums.sum[0]) + 8;
    std::uint64_t hash = 0;
    if (whole) std::memcpy(&hash, bytes.data() + bytes.size() - 8, 8);
    if (!whole || hash != hash_of(std::string_view(bytes).substr(0, bytes.size() - 8))) {
        throw Error::bad_input(file_.string(),
                               "is damaged or has been cut short; remove it and start again");
    }
    take(found, sums.sum);
    take(found, sums.sum_of_squares);
    return sums;
}

void PathTracerState::save(const SampleSums& sums) const {
    if (file_.empty()) return;
    std::string bytes = identity_ + std::string(kSamples) + std::to_string(sums.samples) + "\n\n";
    append(bytes, sums.sum);
    append(bytes, sums.sum_of_squares);
    const std::uint64_t hash = hash_of(bytes);
    bytes.append(reinterpret_cast<const char*>(&hash), sizeof hash);
    write_file(file_, bytes);
}

}  // namespace scotty::reference
