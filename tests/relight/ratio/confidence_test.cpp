// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/confidence.h"

#include "relight/base/angles.h"

#include <gtest/gtest.h>

#include <cmath>

namespace relight {
namespace {

ViewLight LightOfOnePatch(float weight, float trust, float spread) {
  ViewLight light;
  light.images.weight = cv::Mat1f(4, 4, weight);
  light.correction = {
      .grid = {.columns = 1, .rows = 1, .left_px = 0, .top_px = 0, .patch_px = 4},
      .log_factor = cv::Mat1f(1, 1, 0.1f),
      .trust = cv::Mat1f(1, 1, trust),
      .spread = cv::Mat1f(1, 1, spread)};
  return light;
}

TEST(Confidence, IsOneForEqualHoursAndFallsWithTrust) {
  const cv::Mat1f alpha(4, 4, 1.0f);
  const double far_rad = RadFromDeg(120);
  EXPECT_EQ(Confidence(LightOfOnePatch(0, 0, 9), alpha, 0)(1, 1), 1.0f);
  EXPECT_FLOAT_EQ(Confidence(LightOfOnePatch(1, 1, 0), alpha, far_rad)(1, 1), 1.0f);
  EXPECT_FLOAT_EQ(Confidence(LightOfOnePatch(1, 0.5f, 0), alpha, far_rad)(1, 1), 0.5f);
  EXPECT_FLOAT_EQ(Confidence(LightOfOnePatch(0.01f, 1, 0), alpha, far_rad)(1, 1), 0.2f);
  EXPECT_FLOAT_EQ(Confidence(LightOfOnePatch(1, 1, 0.3f), alpha, far_rad)(1, 1),
                  std::exp(-1.0f));
}

TEST(Confidence, IsZeroBesideTheTreeAndKnowsNoCorrection) {
  cv::Mat1f alpha(4, 4, 1.0f);
  alpha(2, 3) = 0;
  ViewLight light = LightOfOnePatch(1, 0.1f, 0);
  light.correction = {};
  const cv::Mat1f confidence = Confidence(light, alpha, RadFromDeg(120));
  EXPECT_EQ(confidence(2, 3), 0.0f);
  EXPECT_FLOAT_EQ(confidence(0, 0), 1.0f);
}

}  // namespace
}  // namespace relight
