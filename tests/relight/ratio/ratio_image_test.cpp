// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/ratio_image.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace relight {
namespace {

cv::Mat3f RandomLight(unsigned seed, const cv::Size& size = {17, 13}) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0.01f, 100.0f);
  cv::Mat3f light(size);
  for (cv::Vec3f& pixel : light) {
    pixel = {uniform(random), uniform(random), uniform(random)};
  }
  return light;
}

// The relighting identity: no change of hour, no change of photograph.
TEST(RatioImage, IsOneWhenTheTargetHourIsTheCaptureHour) {
  cv::Mat3f light = RandomLight(/*seed=*/7);
  light(3, 4) = {0, 0, 0};                // No light at all
  light(5, 6) = {1e-30f, 3e38f, 1e-44f};  // Next to none, and very much
  const cv::Mat3f ones(light.size(), cv::Vec3f::all(1.0f));
  for (const cv::Vec3f& floor : {cv::Vec3f(0, 0, 0), cv::Vec3f(1, 50, 1e-3f)}) {
    EXPECT_EQ(cv::norm(RatioImage(light, light, floor), ones, cv::NORM_INF), 0.0);
  }
}

// [Cabral11, Eq. 3]: one division of floats.
TEST(RatioImage, IsTargetOverInputWhereBothAreAboveTheFloor) {
  const cv::Mat3f input = RandomLight(8), target = RandomLight(9);
  const cv::Mat3f ratio = RatioImage(input, target, {0, 0, 0});
  for (int row = 0; row < ratio.rows; ++row) {
    for (int column = 0; column < ratio.cols; ++column) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(ratio(row, column)[c], target(row, column)[c] / input(row, column)[c]);
      }
    }
  }
}

// The way back undoes the way there.
TEST(RatioImage, OfThereAndBackIsOne) {
  const cv::Mat3f input = RandomLight(10), target = RandomLight(11);
  const cv::Vec3f floor(2, 2, 2);
  const cv::Mat3f round =
      RatioImage(input, target, floor).mul(RatioImage(target, input, floor));
  EXPECT_LT(cv::norm(round, cv::Mat3f(round.size(), cv::Vec3f::all(1)), cv::NORM_INF),
            5e-7);  // Three roundings of a float
}

TEST(RatioImage, IsBoundedByTheFloorInDeepShade) {
  const cv::Mat3f dark(1, 1, cv::Vec3f(1e-20f, 0, 0.5f));
  const cv::Mat3f light(1, 1, cv::Vec3f(10, 10, 10));
  const cv::Vec3f floor(0.1f, 0.1f, 0.1f);
  EXPECT_EQ(RatioImage(dark, light, floor)(0, 0), cv::Vec3f(100, 100, 20));
  EXPECT_EQ(RatioImage(light, dark, floor)(0, 0), cv::Vec3f(0.01f, 0.01f, 0.05f));
}

// No light at either hour, no floor: nothing is known, nothing is changed.
TEST(RatioImage, IsOneWhereThereIsNoLight) {
  const cv::Mat3f dark(2, 2, cv::Vec3f(0, 0, 0));
  EXPECT_EQ(RatioImage(dark, dark, {0, 0, 0})(1, 1), cv::Vec3f(1, 1, 1));
}

TEST(RatioImage, TheFloorIsAShareOfTheMeanWhereThereIsLight) {
  cv::Mat3f light(2, 2, cv::Vec3f(0, 0, 0));
  EXPECT_EQ(RatioFloor(light), cv::Vec3f(0, 0, 0));
  light(0, 0) = {1, 2, 3};
  light(1, 1) = {3, 4, 5};
  const cv::Vec3f floor = RatioFloor(light, {.floor = 0.25});
  EXPECT_EQ(floor, cv::Vec3f(0.5f, 0.75f, 1.0f));
}

TEST(RatioImage, RefusesLightsOfTwoSizes) {
  EXPECT_THROW(RatioImage(RandomLight(1), RandomLight(2, {4, 4}), {0, 0, 0}),
               std::logic_error);
}

}  // namespace
}  // namespace relight
