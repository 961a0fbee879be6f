// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/luminance_error.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

constexpr int kSide = 60;
constexpr double kFloat = 1e-6;  // Colours are floats.

// A flat truth, and a result that is k times as bright on its right half.
RelightingPictures HalfBrighter(float k) {
  const cv::Mat3f truth(kSide, kSide, cv::Vec3f::all(0.5f));
  cv::Mat3f result = truth.clone();
  result.colRange(kSide / 2, kSide) *= k;
  cv::Mat1f matte(kSide, kSide, 0.0f);
  matte.rowRange(10, 50).setTo(1.0f);
  return {.result = {result}, .truth = {truth}, .matte = matte};
}

TEST(LuminanceError, HasTheSignOfTheResult) {
  const RelightingPictures pictures = HalfBrighter(2.0f);
  const RelightingScore score = ScoreRelighting(pictures);
  const cv::Mat1f error = LuminanceError(pictures, score);
  const double gain = score.result.gain[1];
  // p is the truth's 0.5: D is gain - 1 on the left, 2 gain - 1 on the right
  EXPECT_NEAR(error(30, 2), gain - 1.0, kFloat);
  EXPECT_NEAR(error(30, 57), 2.0 * gain - 1.0, kFloat);
  EXPECT_LT(error(30, 2), 0.0f);
  EXPECT_GT(error(30, 57), 0.0f);
  EXPECT_EQ(error(5, 57), 0.0f);  // Outside
}

TEST(LuminanceError, AGainAloneDoesNotShow) {
  RelightingPictures pictures = HalfBrighter(1.0f);
  pictures.result.color = pictures.result.color * 3.0;
  const cv::Mat1f error = LuminanceError(pictures, ScoreRelighting(pictures));
  EXPECT_LT(cv::norm(error, cv::NORM_INF), kFloat);
}

TEST(LuminanceError, TheScaleIsTakenOff) {
  RelightingPictures pictures = HalfBrighter(2.0f);
  const cv::Mat1f plain = LuminanceError(pictures, ScoreRelighting(pictures));
  pictures.result.color = pictures.result.color * 4.0;
  const RelightingScoreOptions options{.scale = 4.0};
  const cv::Mat1f scaled =
      LuminanceError(pictures, ScoreRelighting(pictures, options), options);
  EXPECT_LT(cv::norm(plain, scaled, cv::NORM_INF), kFloat);
}

TEST(LuminanceError, BrighterIsRedDarkerIsBlueRightIsWhite) {
  cv::Mat1f error(1, 4, 0.0f);
  error(0, 0) = 0.3f;
  error(0, 1) = -0.3f;
  error(0, 3) = 9.0f;
  cv::Mat1b inside(1, 4, uchar{255});
  inside(0, 3) = 0;
  const cv::Mat3b picture = LuminanceErrorPicture(error, inside);
  EXPECT_GT(picture(0, 0)[0], picture(0, 0)[2] + 50);
  EXPECT_GT(picture(0, 1)[2], picture(0, 1)[0] + 50);
  EXPECT_EQ(picture(0, 2), cv::Vec3b(245, 245, 245));
  EXPECT_EQ(picture(0, 3), cv::Vec3b(48, 48, 46));  // Outside, whatever its error
}

}  // namespace
}  // namespace relight
