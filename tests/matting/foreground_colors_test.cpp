// SPDX-License-Identifier: Apache-2.0
#include "matting/foreground_colors.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace relight {
namespace {

// A soft disc of one colour over a slow sky.
struct Scene {
  cv::Mat3f image, foreground, background;
  cv::Mat1f alpha;
};

Scene SoftDisc() {
  const cv::Size size(96, 80);
  Scene scene{cv::Mat3f(size), cv::Mat3f(size), cv::Mat3f(size), cv::Mat1f(size)};
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const double r = std::hypot(x - 48, y - 40);
      const auto a = static_cast<float>(std::clamp((34 - r) / 10, 0.0, 1.0));
      scene.alpha(y, x) = a;
      scene.foreground(y, x) = {0.10f + 0.0005f * static_cast<float>(x), 0.25f, 0.05f};
      scene.background(y, x) = {0.5f, 0.7f, 1.0f + 0.002f * static_cast<float>(y)};
      scene.image(y, x) = a * scene.foreground(y, x) + (1 - a) * scene.background(y, x);
    }
  }
  return scene;
}

TEST(ForegroundColors, SeparatesWhatWasMixed) {
  const Scene scene = SoftDisc();
  const ForegroundColors colors = EstimateForeground(scene.image, scene.alpha);
  double worst_mix = 0, sum = 0;
  int count = 0;
  for (int y = 0; y < scene.alpha.rows; ++y) {
    for (int x = 0; x < scene.alpha.cols; ++x) {
      const float a = scene.alpha(y, x);
      const cv::Vec3f mix =
          a * colors.foreground(y, x) + (1 - a) * colors.background(y, x);
      worst_mix = std::max(worst_mix, cv::norm(mix - scene.image(y, x), cv::NORM_INF));
      if (a > 0.05f && a < 0.95f) {
        sum += cv::norm(colors.foreground(y, x) - scene.foreground(y, x), cv::NORM_INF);
        ++count;
      }
    }
  }
  // (M3) trades the mixture against smoothness; both stay below what 8 bits show
  EXPECT_LT(worst_mix, 0.02);
  EXPECT_LT(sum / count, 0.03);
}

TEST(ForegroundColors, IsThePhotoWhereTheMatteIsSure) {
  const Scene scene = SoftDisc();
  const ForegroundColors colors = EstimateForeground(scene.image, scene.alpha);
  for (int y = 0; y < scene.alpha.rows; ++y) {
    for (int x = 0; x < scene.alpha.cols; ++x) {
      if (scene.alpha(y, x) == 1) {
        EXPECT_EQ(colors.foreground(y, x), scene.image(y, x));
      }
      if (scene.alpha(y, x) == 0) {
        EXPECT_EQ(colors.background(y, x), scene.image(y, x));
      }
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(colors.foreground(y, x)[c]));
    }
  }
}

TEST(ForegroundColors, LeavesNoSkyWhereTheMatteIsEmpty) {
  const Scene scene = SoftDisc();
  const ForegroundColors colors = EstimateForeground(scene.image, scene.alpha);
  // The disc's blue is 0.05, the sky's 1: beyond the edge the disc goes on
  for (int x = 2; x < 10; ++x) EXPECT_LT(colors.foreground(40, x)[2], 0.2f) << x;
}

TEST(ForegroundColors, IsTheSameForAnyNumberOfThreads) {
  const Scene scene = SoftDisc();
  SetThreadCount(1);
  const ForegroundColors one = EstimateForeground(scene.image, scene.alpha);
  SetThreadCount(2);
  const ForegroundColors two = EstimateForeground(scene.image, scene.alpha);
  SetThreadCount(0);
  EXPECT_EQ(cv::norm(one.foreground, two.foreground, cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(one.background, two.background, cv::NORM_INF), 0.0);
}

TEST(ForegroundColors, RefusesAMatteOfAnotherSize) {
  EXPECT_THROW(EstimateForeground(cv::Mat3f::zeros(4, 4), cv::Mat1f::zeros(4, 5)),
               InputError);
}

}  // namespace
}  // namespace relight
