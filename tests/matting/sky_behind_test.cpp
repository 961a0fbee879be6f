// SPDX-License-Identifier: Apache-2.0
#include "matting/sky_behind.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <random>

namespace relight {
namespace {

constexpr int kRows = 240, kCols = 320, kLowestSky = 179;
const cv::Rect kCrown(80, 30, 160, 120), kHole(150, 80, 16, 16);

// A sky that pales downwards and to the right, above lawn.
cv::Mat3f MadeSky() {
  cv::Mat3f sky(kRows, kCols, cv::Vec3f(0.3f, 0.4f, 0.15f));
  for (int y = 0; y <= kLowestSky; ++y) {
    for (int x = 0; x < kCols; ++x) {
      const float t = static_cast<float>(y) / kLowestSky, u = 0.05f * x / kCols;
      sky(y, x) = {0.35f + 0.35f * t + u, 0.5f + 0.25f * t + u, 0.8f + 0.1f * t + u};
    }
  }
  return sky;
}

// The same behind a rough crown with a hole and many small gaps.
cv::Mat3f MadePhoto() {
  cv::Mat3f photo = MadeSky();
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  for (int y = kCrown.y; y < kCrown.br().y; ++y) {
    for (int x = kCrown.x; x < kCrown.br().x; ++x) {
      const float light = 0.5f + uniform(random);
      if (kHole.contains({x, y}) || uniform(random) < 0.1f) continue;
      photo(y, x) = cv::Vec3f(0.15f, 0.25f, 0.08f) * light;
    }
  }
  return photo;
}

TEST(SkyBehind, PredictsTheSkyBehindATree) {
  const SkyBehind sky = FindSky(MadePhoto());
  EXPECT_EQ(sky.share, 1.0);
  // d of the sky itself, had no tree stood before it: 0.36 at most behind the crown. A
  // step of 2.3 in CIELAB is just seen, and less than a quarter of it is nothing
  const cv::Mat1f off = DistanceToSky(MadeSky(), 0, kRows, sky);
  double most = 0;
  cv::minMaxLoc(off(kCrown), nullptr, &most);
  EXPECT_LT(most, 0.5);
  // The crown stands out far from that, its hole does not
  EXPECT_GT(sky.contrast, 40);
  EXPECT_LT(sky.spread, 1.1);
  EXPECT_EQ(sky.known(kHole.y + 8, kHole.x + 8), 255);
  EXPECT_EQ(sky.known(kCrown.y + 5, 10), 255);
}

TEST(SkyBehind, EndsAboveTheGround) {
  const SkyBehind sky = FindSky(MadePhoto());
  // Smoothness is of 5 x 5 pixels, and three rows are left for blur
  EXPECT_NEAR(sky.horizon, kLowestSky - 4, 2);
  EXPECT_EQ(sky.ground(kRows - 5, 100), 255);
  EXPECT_EQ(sky.ground(50, 10), 0);
  EXPECT_EQ(sky.known(kRows - 5, 100), 0);
}

TEST(SkyBehind, NoiseOfALargerPhotoWidensTheSpread) {
  const SkyBehind sky = FindSky(MadePhoto());
  cv::Mat3f large;
  cv::resize(MadePhoto(), large, {}, 4, 4, cv::INTER_LINEAR);
  EXPECT_LT(SkySpread(large, sky), 1.1);
  std::mt19937 random(2);
  std::normal_distribution<float> noise(0.0f, 0.03f);
  for (cv::Vec3f& pixel : large) {
    for (int i = 0; i < 3; ++i) pixel[i] += noise(random);
  }
  EXPECT_GT(SkySpread(large, sky), 3);  // L* alone spreads by about 3
}

TEST(SkyBehind, APhotoWithoutSkySaysSo) {
  const cv::Rect lawn(0, kLowestSky + 1, kCols, kRows - kLowestSky - 1);
  const cv::Mat3f photo = MadePhoto()(lawn).clone();
  const SkyBehind sky = FindSky(photo);
  EXPECT_EQ(sky.share, 0.0);
  EXPECT_EQ(sky.horizon, -1);
  EXPECT_EQ(cv::countNonZero(sky.known), 0);
  EXPECT_EQ(cv::countNonZero(sky.distance), 0);
  EXPECT_EQ(SkySpread(photo, sky), sky.spread);
}

}  // namespace
}  // namespace relight
