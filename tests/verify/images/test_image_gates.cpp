/// Each gate seen to fail on the fault that it is there for, at the right place, and none without.
#include <cmath>
#include <limits>
#include <string>

#include "tests/catch.h"
#include "tests/verify/image_tools.h"
#include "verify/images/image_gates.h"
#include "verify/images/planted_faults.h"

namespace {

using namespace scotty::verify;
using namespace scotty::verify::test;
using Catch::Matchers::ContainsSubstring;

constexpr double kFalseAlarm = 1e-4;

SyntheticSettings settings_of(std::uint64_t seed, std::uint32_t samples = 256) {
    SyntheticSettings settings;
    settings.samples = samples;
    settings.seed = seed;
    return settings;
}

/// For what is repeated 200 times.
SyntheticSettings small_settings() {
    SyntheticSettings settings = settings_of(1, 64);
    settings.width = 45;
    settings.height = 37;
    return settings;
}

SyntheticSettings with_seed(SyntheticSettings settings, std::uint64_t seed) {
    settings.seed = seed;
    return settings;
}

const MeasuredImage& golden() {
    static const MeasuredImage image = synthetic_golden(settings_of(1));
    return image;
}

const GateResult& result_of(const ImageVerdict& verdict, Gate gate) {
    for (const GateResult& result : verdict.gates) {
        if (result.gate == gate) return result;
    }
    FAIL("no such gate");
    return verdict.gates.front();
}

bool fails(const ImageVerdict& verdict, Gate gate) {
    const GateResult& result = result_of(verdict, gate);
    return result.ran && !result.passed;
}

std::string told(const ImageVerdict& verdict) {
    std::string text;
    for (const GateResult& result : verdict.gates) {
        text += std::string(name(result.gate)) + ": " + result.text + "\n";
    }
    return text;
}

/// A flat image whose pixels all have that mean, variance and samples.
MeasuredImage flat(double mean, double variance, std::uint64_t samples) {
    MeasuredImage image{16, 16, {}, {}, samples, 1};
    image.mean.assign(256, {mean, mean, mean});
    image.variance.assign(256, {variance, variance, variance});
    return image;
}

TEST_CASE("image gates: each planted fault is rejected by the gate that is there for it",
          "[verify][image][gates]") {
    const std::vector<std::pair<ImageFault, Gate>> table{
        {ImageFault::brighter, Gate::global},
        {ImageFault::black_pixels, Gate::pixel},
        {ImageFault::dark_tile, Gate::tile},
        {ImageFault::not_a_number, Gate::finite},
        {ImageFault::light_sample_dropped, Gate::pixel},
        {ImageFault::cosine_forgotten, Gate::global},
        {ImageFault::mirrored, Gate::tile},
        {ImageFault::wrong_golden, Gate::tile}};
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        for (const auto& [fault, gate] : table) {
            const MeasuredImage image = synthetic_render(settings_of(seed), fault);
            const ImageVerdict verdict =
                fault == ImageFault::wrong_golden
                    ? judge_image(image, synthetic_golden(settings_of(1), 16, fault), {})
                    : judge_image(image, golden(), {});
            INFO(name(fault) << ", seed " << seed << "\n" << told(verdict));
            CHECK(fails(verdict, gate));
            CHECK_FALSE(verdict.passed());
        }
    }
}

TEST_CASE("image gates: a fault is named where it is", "[verify][image][gates]") {
    const ImageVerdict tile =
        judge_image(synthetic_render(settings_of(2), ImageFault::dark_tile), golden(), {});
    const GateResult& dark = result_of(tile, Gate::tile);
    CHECK((dark.x == 16 && dark.y == 32 && dark.width == 8 && dark.height == 8));
    CHECK_THAT(dark.text, ContainsSubstring("the 8x8 tile at (16, 32)") && ContainsSubstring("-"));

    const ImageVerdict nan =
        judge_image(synthetic_render(settings_of(2), ImageFault::not_a_number), golden(), {});
    const GateResult& finite = result_of(nan, Gate::finite);
    CHECK((finite.x == 0 && finite.y == 32 && finite.channel == 1));
    CHECK_THAT(finite.text, ContainsSubstring("(0, 32) green: nan"));
    CHECK_FALSE(result_of(nan, Gate::global).ran);
    CHECK_THAT(result_of(nan, Gate::global).text, ContainsSubstring("finite gate failed"));
    CHECK(nan.worst.front().y == 32);

    MeasuredImage one = synthetic_render(settings_of(2));
    one.mean[20 * 64 + 50] = {0.0, 0.0, 0.0};
    const ImageVerdict dot = judge_image(one, golden(), {});
    const GateResult& pixel = result_of(dot, Gate::pixel);
    CHECK_FALSE(pixel.passed);
    CHECK((pixel.x == 50 && pixel.y == 20));
    CHECK_THAT(pixel.text, ContainsSubstring("pixel (50, 20)") && ContainsSubstring("-100.00 %"));
    CHECK((dot.worst.front().x == 50 && dot.worst.front().y == 20));
    CHECK(dot.worst.size() == 10);
    CHECK(dot.first_failure() == &pixel);
}

TEST_CASE("image gates: no false alarm in 200 seeded runs, and asked for many, some",
          "[verify][image][gates]") {
    const SyntheticSettings settings = small_settings();
    const MeasuredImage truth = synthetic_golden(settings);
    int alarms = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        const MeasuredImage image = synthetic_render(with_seed(settings, seed));
        const ImageVerdict verdict = judge_image(image, truth, {kFalseAlarm, true});
        INFO("seed " << seed << "\n" << told(verdict));
        REQUIRE(verdict.passed());
        if (!judge_image(image, truth, {0.5, true}).passed()) ++alarms;
    }
    // The promise is "at most": dividing among gates, three channels with the same noise, and
    // believing the larger variance all make it less.
    INFO(alarms << " of 200");
    CHECK(alarms < 100);
    CHECK(alarms > 5);  // the gates are not asleep
}

TEST_CASE("image gates: no false alarm in 200 seeded runs with fireflies, pixels not asked",
          "[verify][image][gates]") {
    SyntheticSettings settings = small_settings();
    settings.fireflies = true;
    const MeasuredImage truth = synthetic_golden(settings);
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        const ImageVerdict verdict =
            judge_image(synthetic_render(with_seed(settings, seed)), truth, {kFalseAlarm, false});
        INFO("seed " << seed << "\n" << told(verdict));
        REQUIRE(verdict.passed());
        REQUIRE_FALSE(result_of(verdict, Gate::pixel).ran);
    }
}

TEST_CASE("image gates: an exact copy passes, however it is made", "[verify][image][gates]") {
    const MeasuredImage image = synthetic_render(settings_of(3));
    CHECK(judge_image(image, image, {}).passed());
    CHECK(judge_image(image, image, {}).worst.empty());
    CHECK(judge_image(flat(1.0, 0.0, 0), flat(1.0, 0.0, 0), {}).passed());
    CHECK(judge_image(flat(0.0, 0.0, 16), flat(0.0, 0.0, 16), {}).passed());
}

TEST_CASE("image gates: constant pixels may differ by rounding and by no more",
          "[verify][image][gates]") {
    // A thousand floats added one by one may be off by 1000 * 2^-24 = 6e-5 of their sum.
    const MeasuredImage truth = flat(0.7, 0.0, 1000);
    CHECK(judge_image(flat(0.7 * (1.0 + 3e-5), 0.0, 1000), truth, {}).passed());
    const ImageVerdict verdict = judge_image(flat(0.7 * (1.0 + 1e-3), 0.0, 1000), truth, {});
    for (const Gate gate : {Gate::global, Gate::tile, Gate::pixel}) CHECK(fails(verdict, gate));
    CHECK(std::isinf(result_of(verdict, Gate::pixel).statistic));

    MeasuredImage background = flat(0.0, 0.0, 1000);
    background.mean[77][2] = 1e-3;  // where nothing can be
    CHECK(fails(judge_image(background, flat(0.0, 0.0, 1000), {}), Gate::pixel));
}

TEST_CASE("image gates: a pixel that saw no rare path is no fault where the golden image knows it",
          "[verify][image][gates]") {
    // 16 samples saw nothing; of 65536 one in 1000 was worth 100: 0.1 +- 0.0123 for the golden
    // image, a variance of 10 a path. By the image's own variance, 0, that is 8 deviations.
    MeasuredImage image = flat(0.5, 1e-3, 16);
    MeasuredImage truth = flat(0.5, 1e-3 * 16 / 65536, 65536);
    image.mean[40] = image.variance[40] = {0.0, 0.0, 0.0};
    truth.mean[40] = {0.1, 0.1, 0.1};
    const double variance = 10.0 / 65536;
    truth.variance[40] = {variance, variance, variance};
    CHECK(judge_image(image, truth, {}).passed());
    image.samples = truth.samples = 0;  // samples not known: Welch by what each says
    CHECK(fails(judge_image(image, truth, {}), Gate::pixel));
}

TEST_CASE("image gates: few samples mean Student's tails, not the normal's",
          "[verify][image][gates]") {
    // 7 deviations: hardly ever with a known variance, common enough with one from 4 samples.
    MeasuredImage image = flat(0.5, 1e-4, 4);
    const MeasuredImage truth = flat(0.5, 1e-13, 1u << 30);
    image.mean[40] = {0.57, 0.57, 0.57};
    image.variance[40] = {1e-4, 1e-4, 1e-4};
    const ImageVerdict few = judge_image(image, truth, {});
    INFO(told(few));
    CHECK(result_of(few, Gate::pixel).statistic == Approx(7.0).epsilon(1e-3));
    CHECK(result_of(few, Gate::pixel).p_value > 1e-3);
    CHECK(few.passed());
    image.samples = 4000;
    image.variance.assign(256, {1e-4, 1e-4, 1e-4});
    CHECK(fails(judge_image(image, truth, {}), Gate::pixel));
}

TEST_CASE("image gates: a calmer golden image does not lend its certainty to few samples",
          "[verify][image][gates]") {
    // By chance 6 renders agree better than they should; the golden image's paths are less noisy
    // than theirs. 10 deviations of the golden image's noise are no proof.
    MeasuredImage image = flat(0.5, 1e-4, 6);
    image.paths_per_sample = 256;
    const MeasuredImage truth = flat(0.5, 1e-5 * 1536 / 4096, 4096);
    image.mean[40] = {0.54, 0.54, 0.54};
    image.variance[40] = {1e-6, 1e-6, 1e-6};
    const ImageVerdict verdict = judge_image(image, truth, {});
    INFO(told(verdict));
    CHECK(result_of(verdict, Gate::pixel).statistic > 9.0);
    CHECK(verdict.passed());
}

TEST_CASE("image gates: a few samples that are alike by chance are no certainty",
          "[verify][image][gates]") {
    // Each sample is 0 or bright; the golden image's estimator is far calmer.
    const MeasuredImage reference = flat(0.17, 1e-7, 4096);
    const auto image_of = [](std::uint64_t samples, std::uint32_t dark_pixels) {
        MeasuredImage image = flat(0.17, 0.03 / static_cast<double>(samples), samples);
        for (std::uint32_t i = 0; i < dark_pixels; ++i) {
            const std::uint32_t pixel = i % 8 + i / 8 * image.width;  // of the first tile
            image.mean[pixel] = {0.0, 0.0, 0.0};
            image.variance[pixel] = {0.0, 0.0, 0.0};
        }
        return image;
    };
    const GateSettings settings{kFalseAlarm, true};
    CHECK_FALSE(fails(judge_image(image_of(4, 1), reference, settings), Gate::pixel));
    CHECK(fails(judge_image(image_of(64, 1), reference, settings), Gate::pixel));
    CHECK(fails(judge_image(image_of(4, 64), reference, settings), Gate::tile));
}

TEST_CASE("image gates: a variance that is missing is not guessed from the other image's",
          "[verify][image][gates]") {
    MeasuredImage image = synthetic_render(settings_of(4));
    image.variance.clear();
    const ImageVerdict unknown = judge_image(image, golden(), {});
    CHECK(fails(unknown, Gate::layout));
    CHECK_THAT(result_of(unknown, Gate::layout).text, ContainsSubstring("the image does not say"));
    image.samples = 1;
    CHECK_THAT(judge_image(image, golden(), {}).first_failure()->text,
               ContainsSubstring("one sample a pixel"));
}

TEST_CASE("image gates: bits that differ where no noise is known are no verdict",
          "[verify][image][gates]") {
    const MeasuredImage image = smooth_image(16, 12);
    CHECK(judge_bits(image, image, "nobody knows").passed());
    MeasuredImage off = image;
    off.mean[7][1] *= 1.001;
    const ImageVerdict verdict = judge_bits(off, image, "nobody knows");
    CHECK(verdict.first_failure() == nullptr);
    CHECK_FALSE(verdict.passed());
    CHECK(verdict.not_judged == "nobody knows");
    off.mean[7][1] = std::nan("");
    CHECK(fails(judge_bits(off, image, "nobody knows"), Gate::finite));
    CHECK(judge_bits(off, image, "nobody knows").not_judged.empty());
}

TEST_CASE("image gates: a constant pixel that differs is told without infinities",
          "[verify][image][gates]") {
    MeasuredImage truth = synthetic_golden(settings_of(1));
    MeasuredImage image = synthetic_render(settings_of(1));
    truth.variance[0] = image.variance[0] = {0.0, 0.0, 0.0};
    image.mean[0][0] = truth.mean[0][0] + 0.5;
    const ImageVerdict verdict = judge_image(image, truth, {});
    CHECK(fails(verdict, Gate::pixel));
    CHECK_THAT(result_of(verdict, Gate::pixel).text,
               ContainsSubstring("neither image has any noise") && !ContainsSubstring("inf"));
}

TEST_CASE("image gates: samples that are means of paths weigh as many", "[verify][image][gates]") {
    // 16 renders of 16 paths, or 256 paths: the same noise a path, fewer degrees of freedom.
    MeasuredImage paths = flat(0.5, 1e-4, 256);
    MeasuredImage renders = flat(0.5, 1e-4, 16);
    renders.paths_per_sample = 16;
    const MeasuredImage truth = flat(0.5, 1e-4 / 256, 65536);
    for (MeasuredImage* image : {&paths, &renders}) {
        image->mean[9] = {0.58, 0.58, 0.58};
        CHECK(result_of(judge_image(*image, truth, {}), Gate::pixel).statistic ==
              Approx(8.0).epsilon(0.01));
    }
}

TEST_CASE("image gates: layouts that do not fit are a finding, not an exception",
          "[verify][image][gates]") {
    const MeasuredImage image = flat(0.5, 1e-4, 16);
    MeasuredImage wide = image;
    wide.width = 32;
    wide.height = 8;
    const ImageVerdict verdict = judge_image(wide, image, {});
    CHECK(fails(verdict, Gate::layout));
    CHECK_THAT(verdict.first_failure()->text,
               ContainsSubstring("32x8") && ContainsSubstring("16x16"));
    CHECK_FALSE(result_of(verdict, Gate::finite).ran);
    MeasuredImage cut = image;
    cut.mean.resize(100);
    CHECK(fails(judge_image(cut, image, {}), Gate::layout));
    CHECK(fails(judge_image({}, {}, {}), Gate::layout));
    MeasuredImage single = image;
    single.samples = 1;
    CHECK_THAT(judge_image(single, image, {}).first_failure()->text,
               ContainsSubstring("single sample"));
}

TEST_CASE("image gates: infinities, negative radiance and spoiled variances are not finite",
          "[verify][image][gates]") {
    const MeasuredImage good = flat(0.5, 1e-4, 16);
    const double inf = std::numeric_limits<double>::infinity();
    for (const double value : {inf, -inf, std::nan(""), -1e-9}) {
        MeasuredImage image = good;
        image.mean[200][0] = value;
        CHECK(fails(judge_image(image, good, {}), Gate::finite));
        const ImageVerdict reversed = judge_image(good, image, {});
        CHECK_THAT(reversed.first_failure()->text,
                   ContainsSubstring("the golden image has 1 pixel"));
        image = good;
        image.variance[200][0] = value;
        CHECK(fails(judge_image(image, good, {}), Gate::finite));
    }
}

TEST_CASE("image gates: tiles at the border are smaller, images below a tile are one",
          "[verify][image][gates]") {
    SyntheticSettings settings = settings_of(1);
    settings.width = 21;
    settings.height = 13;
    const MeasuredImage truth = synthetic_golden(settings);
    MeasuredImage image = synthetic_render(settings);
    CHECK(judge_image(image, truth, {}).passed());
    for (std::uint32_t y = 8; y < 13; ++y) {
        for (std::uint32_t x = 16; x < 21; ++x) {
            for (double& value : image.mean[y * 21 + x]) value *= 1.2;
        }
    }
    const ImageVerdict verdict = judge_image(image, truth, {});
    const GateResult& tile = result_of(verdict, Gate::tile);
    CHECK_FALSE(tile.passed);
    CHECK((tile.x == 16 && tile.y == 8 && tile.width == 5 && tile.height == 5));
    settings.width = settings.height = 1;
    settings.seed = 8;
    CHECK(judge_image(synthetic_render(settings), synthetic_golden(settings), {}).passed());
}

TEST_CASE("image gates: without noise only equal bits pass, or a stated tolerance",
          "[verify][image][gates]") {
    const MeasuredImage image = smooth_image(16, 12);
    CHECK(judge_by_tolerance(image, image, 0.0).passed());
    MeasuredImage off = image;
    off.mean[30][1] = std::nextafter(static_cast<float>(off.mean[30][1]), 2.0f);
    const ImageVerdict verdict = judge_by_tolerance(off, image, 0.0);
    CHECK(fails(verdict, Gate::equal));
    CHECK_THAT(verdict.first_failure()->text, ContainsSubstring("1 of 576 values differ") &&
                                                  ContainsSubstring("green of pixel (14, 1)"));
    CHECK(verdict.metrics.max_ulps == 1.0);
    CHECK(judge_by_tolerance(off, image, 1e-6).passed());
    off.mean[30][1] *= 1.03;
    CHECK(judge_by_tolerance(off, image, 0.031).passed());
    CHECK_FALSE(judge_by_tolerance(off, image, 0.01).passed());
    off.mean[30][1] = std::nan("");
    CHECK(fails(judge_by_tolerance(off, image, 1.0), Gate::finite));
    CHECK(fails(judge_by_tolerance(off, off, 1.0), Gate::finite));
    CHECK(fails(judge_by_tolerance(smooth_image(12, 16), image, 1.0), Gate::layout));
}

TEST_CASE("image gates: a run's false-alarm probability is shared among its images",
          "[verify][image][gates]") {
    CHECK(false_alarm_per_image(1e-3, 1) == Approx(1e-3));
    const double each = false_alarm_per_image(1e-3, 7);
    CHECK(1.0 - std::pow(1.0 - each, 7) == Approx(1e-3));
}

}  // namespace
