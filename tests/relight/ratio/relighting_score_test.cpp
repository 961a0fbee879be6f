// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/relighting_score.h"

#include "relight/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace relight {
namespace {

// Colours are stored as float: 1e-7 each, 1e-6 in what is made of them.
constexpr double kFloat = 1e-6;
cv::Mat3f RandomColor(const cv::Size& size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0.1f, 1.0f);
  cv::Mat3f color(size);
  for (cv::Vec3f& pixel : color)
    pixel = {uniform(random), uniform(random), uniform(random)};
  return color;
}

// A disc of full coverage in a ring of a quarter.
cv::Mat1f DiscAlpha(const cv::Size& size) {
  cv::Mat1f alpha(size, 0.0f);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double radius = std::hypot(x - size.width / 2.0, y - size.height / 2.0);
      alpha(y, x) = radius < 20.0 ? 1.0f : radius < 24.0 ? 0.25f : 0.0f;
    }
  }
  return alpha;
}

constexpr int kSide = 60;

RelightingPictures Pictures(const cv::Mat3f& result,
                            const cv::Mat3f& truth,
                            const cv::Mat3f& source) {
  const cv::Mat1f alpha = DiscAlpha(truth.size());
  return {.result = {result, alpha.clone()},
          .truth = {truth, alpha.clone()},
          .source = {source},
          .matte = alpha};
}

TEST(RelightingScore, TheTruthItselfIsPerfect) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  const RelightingFigures f =
      ScoreRelighting(Pictures(truth, truth, RandomColor(truth.size(), 2))).result;
  // An error of nothing counts as 1e-20: 200 dB and 20 log10 of the peak, 0.7 to 1 here
  for (const double psnr : {f.psnr, f.psnr_low}) {
    EXPECT_GT(psnr, 200.0 + 20.0 * std::log10(0.7));
    EXPECT_LE(psnr, 200.0);
  }
  EXPECT_GT(*f.ring, 150.0);
  EXPECT_NEAR(f.corr_low, 1.0, 1e-12);
  EXPECT_NEAR(f.corr_high, 1.0, 1e-12);
  EXPECT_NEAR(f.contrast, 1.0, 1e-12);
  EXPECT_NEAR(f.level, 1.0, 1e-12);
  EXPECT_NEAR(f.colour, 0.0, 1e-12);
  EXPECT_NEAR(f.ssim, 1.0, 1e-12);
}

// A result of k times the truth: the gains are 1 / k and undo it, the level is k.
TEST(RelightingScore, AGainIsSeenInLevelAndPsnrOnly) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  const RelightingFigures f = ScoreRelighting(Pictures(truth * 0.5, truth, truth)).result;
  for (const double gain : f.gain) EXPECT_NEAR(gain, 2.0, kFloat);
  EXPECT_NEAR(f.level, 0.5, kFloat);
  EXPECT_NEAR(f.contrast, 1.0, kFloat);
  EXPECT_NEAR(f.corr_low, 1.0, kFloat);
  EXPECT_NEAR(f.colour, 0.0, kFloat);
  EXPECT_GT(f.psnr_low, 120.0);
  EXPECT_LT(f.psnr, 15.0);
  EXPECT_GT(*f.ring, 120.0);
}

// Channels of 2, 1 and 4 times the truth: (ln 2 + ln 4) / 2.
TEST(RelightingScore, ColourIsHowFarTheGainsPart) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  cv::Mat3f tinted = truth.clone();
  for (cv::Vec3f& pixel : tinted) pixel = pixel.mul({2.0f, 1.0f, 4.0f});
  const RelightingFigures f = ScoreRelighting(Pictures(tinted, truth, truth)).result;
  EXPECT_NEAR(f.colour, (std::log(2.0) + std::log(4.0)) / 2, kFloat);
}

// Truth c, result c + d everywhere, absolute: 10 log10(p^2 / d^2). Flat pictures have no
// correlation, and the gain takes the difference out.
TEST(RelightingScore, AFlatErrorHasItsClosedForm) {
  const cv::Mat3f truth(kSide, kSide, cv::Vec3f::all(0.5f));
  const cv::Mat3f result(kSide, kSide, cv::Vec3f::all(0.6f));
  const RelightingFigures f = ScoreRelighting(Pictures(result, truth, truth)).result;
  EXPECT_NEAR(f.psnr, 20.0 * std::log10(0.5 / 0.1), 1e-5);  // 0.6f - 0.5f in float
  EXPECT_NEAR(f.gain[0], 0.5 / 0.6, kFloat);
  EXPECT_NEAR(f.level, 1.2, kFloat);
  // Windows of flat pictures: (2 a b + c1) / (a^2 + b^2 + c1), variances vanish
  const double c1 = std::pow(0.01 * 0.5, 2);
  EXPECT_NEAR(f.ssim, (2 * 0.5 * 0.6 + c1) / (0.25 + 0.36 + c1), kFloat);
}

// The ring's own alpha counts: a result of twice the coverage errs by the truth's
// premultiplied colour.
TEST(RelightingScore, TheRingComparesPremultipliedColours) {
  const cv::Mat3f truth(kSide, kSide, cv::Vec3f::all(0.8f));
  RelightingPictures pictures = Pictures(truth, truth, truth);
  pictures.result.alpha = pictures.result.alpha * 2.0;
  const RelightingScore score = ScoreRelighting(pictures);
  EXPECT_NEAR(*score.result.ring, 20.0 * std::log10(0.8 / (0.25 * 0.8)), 1e-5);
  EXPECT_GT(*score.nothing->ring, 120.0);  // Takes the matte's coverage

  pictures.result.alpha.release();  // None of its own: the matte's
  EXPECT_GT(*ScoreRelighting(pictures).result.ring, 120.0);

  cv::Mat1f hard = pictures.truth.alpha.clone();
  hard.setTo(0.0f, hard < 0.5f);
  pictures.truth.alpha = hard;
  EXPECT_FALSE(ScoreRelighting(pictures).result.ring.has_value());
}

// Blurring takes local contrast away, and the low frequencies hardly notice.
TEST(RelightingScore, FlatteningIsSeen) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  cv::Mat3f flat = truth.clone();
  for (cv::Vec3f& pixel : flat)
    pixel = cv::Vec3f::all(0.55f) + 0.4f * (pixel - cv::Vec3f::all(0.55f));
  const RelightingFigures f = ScoreRelighting(Pictures(flat, truth, truth)).result;
  EXPECT_NEAR(f.contrast, 0.4, 0.01);  // The mean of the random colours is 0.55 to 1 %
  EXPECT_NEAR(f.corr_high, 1.0, kFloat);
}

TEST(RelightingScore, NothingIsTheSourceAndHistogramHasTheTruthsValues) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  const cv::Mat3f source = RandomColor({kSide, kSide}, 2) * 3.0;
  const RelightingScore score = ScoreRelighting(Pictures(source, truth, source));
  EXPECT_EQ(score.nothing->psnr, score.result.psnr);
  EXPECT_EQ(score.nothing->ssim, score.result.ssim);
  EXPECT_NEAR(score.histogram->level, 1.0, kFloat);  // The same values in another order
  EXPECT_GT(std::abs(score.nothing->level - 1.0), 1.0);

  // A source whose order is the truth's, channel by channel, becomes the truth
  cv::Mat3f cubed = truth.clone();
  for (cv::Vec3f& pixel : cubed) pixel = pixel.mul(pixel).mul(pixel);
  EXPECT_GT(ScoreRelighting(Pictures(truth, truth, cubed)).histogram->psnr, 150.0);
}

TEST(RelightingScore, TheScaleDividesTheResultOnly) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  const RelightingScore score =
      ScoreRelighting(Pictures(truth * 4.0, truth, truth * 4.0), {.scale = 4.0});
  EXPECT_NEAR(score.result.level, 1.0, kFloat);
  EXPECT_NEAR(score.nothing->level, 4.0, kFloat);
}

TEST(RelightingScore, OnlyTheInsideCounts) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  RelightingPictures pictures = Pictures(truth, truth, truth);
  const RelightingScore before = ScoreRelighting(pictures);
  cv::Mat3f dirty = truth.clone();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  dirty.setTo(cv::Vec3f::all(nan), pictures.matte == 0.0f);
  pictures.result.color = dirty;
  const RelightingScore after = ScoreRelighting(pictures);
  EXPECT_EQ(after.result.psnr_low, before.result.psnr_low);
  EXPECT_EQ(after.result.ssim, before.result.ssim);
  EXPECT_EQ(after.pixels, cv::countNonZero(pictures.matte > 0.5f));
}

TEST(RelightingScore, WithoutMatteTheTruthsAlphaDecidesAndWithoutAlphaTheMatte) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  const cv::Mat3f result = RandomColor({kSide, kSide}, 2);
  const RelightingPictures both = Pictures(result, truth, truth);
  const RelightingScore score = ScoreRelighting(both);
  RelightingPictures one = both;
  one.matte.release();
  EXPECT_EQ(ScoreRelighting(one).result.psnr_low, score.result.psnr_low);
  EXPECT_EQ(ScoreRelighting(one).result.ring, score.result.ring);
  one = both;
  one.truth.alpha.release();
  EXPECT_EQ(ScoreRelighting(one).result.psnr_low, score.result.psnr_low);
  EXPECT_FALSE(
      ScoreRelighting(one).result.ring.has_value());  // What is the tree's there?
}

TEST(RelightingScore, WithoutASourceThereIsNoRowOfIt) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  RelightingPictures pictures = Pictures(truth, truth, truth);
  EXPECT_TRUE(ScoreRelighting(pictures).monge_kantorovich.has_value());
  pictures.source.color.release();
  const RelightingScore score = ScoreRelighting(pictures);
  EXPECT_FALSE(score.nothing || score.histogram || score.reinhard);
  EXPECT_FALSE(score.monge_kantorovich.has_value());
}

TEST(RelightingScore, SaysWhatCannotBeScored) {
  const cv::Mat3f truth = RandomColor({kSide, kSide}, 1);
  const RelightingPictures good = Pictures(truth, truth, truth);
  RelightingPictures bad = good;
  bad.result.color = RandomColor({kSide, kSide + 1}, 1);
  EXPECT_THROW(ScoreRelighting(bad), InputError);
  bad = good;
  bad.truth.alpha.release();
  bad.matte.release();  // Nothing says where the tree is
  EXPECT_THROW(ScoreRelighting(bad), InputError);
  bad.truth.alpha = cv::Mat1f(kSide, kSide, 1.0f);  // Opaque all over
  EXPECT_THROW(ScoreRelighting(bad), InputError);
  bad = good;
  bad.matte = cv::Mat1f(kSide, kSide, 0.0f);
  EXPECT_THROW(ScoreRelighting(bad), InputError);
  bad = good;
  bad.result.color = truth.clone();
  bad.result.color(kSide / 2, kSide / 2)[1] = std::numeric_limits<float>::infinity();
  EXPECT_THROW(ScoreRelighting(bad), InputError);
  bad = good;
  bad.truth.color = cv::Mat3f(kSide, kSide, cv::Vec3f::all(0.0f));
  EXPECT_THROW(ScoreRelighting(bad), InputError);
  EXPECT_THROW(ScoreRelighting(good, {.scale = 0.0}), OptionError);
}

}  // namespace
}  // namespace relight
