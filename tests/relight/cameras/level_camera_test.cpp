// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/level_camera.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

constexpr double kRoundingPx = 1e-9;

TEST(LevelCamera, TheFootIsTheOriginAndIsSeenAtItsPixel) {
  for (const double heading_deg : {0.0, 37.0, 90.0, 180.0, 300.0}) {
    for (const Eigen::Vector2d& foot :
         {Eigen::Vector2d(500, 900), Eigen::Vector2d(40, 700)}) {
      const LevelCamera level = MakeLevelCamera(
          1000, 1200, 800, RadFromDeg(heading_deg), foot, 150, {.distance_m = 14});
      const auto seen = level.camera.Project({0, 0, 0});
      ASSERT_TRUE(seen);
      EXPECT_LT((*seen - foot).norm(), kRoundingPx);
      EXPECT_NEAR(level.camera.PositionInWorld().z(), 1.6, 1e-12);
      EXPECT_NEAR(
          level.camera.PositionInWorld().dot(level.camera.ForwardInWorld()), -14, 1e-12);
      EXPECT_NEAR(
          AzimuthOf(level.camera.ForwardInWorld()), RadFromDeg(heading_deg), 1e-12);
      EXPECT_NEAR(level.camera.ForwardInWorld().z(), 0, 1e-15);
    }
  }
}

TEST(LevelCamera, UprightsStayUprightAndTheTopIsSeenAtItsRow) {
  const LevelCamera level =
      MakeLevelCamera(1000, 1200, 800, 1.1, {620, 1000}, 150, {.distance_m = 14});
  for (const double height_m : {0.0, 0.5, 3.0, level.tree_height_m}) {
    const auto seen = level.camera.Project({0, 0, height_m});
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x(), 620, kRoundingPx);
    EXPECT_NEAR(seen->y(), 1000 - 800 * height_m / 14, kRoundingPx);
  }
  EXPECT_NEAR(level.tree_height_m, 850.0 * 14 / 800, 1e-12);
}

// What is as high as the camera is seen on the horizon, near and far.
TEST(LevelCamera, TheHorizonIsAtEyeHeight) {
  const LevelCamera level = MakeLevelCamera(
      1000, 1200, 800, 2.0, {480, 990}, 100, {.height_m = 1.7, .distance_m = 12});
  const double horizon_px = 990 - 1.7 * 800 / 12;
  const Eigen::Vector3d eye = level.camera.PositionInWorld();
  const Eigen::Vector3d right = DirectionFromAzimuthElevation(2.0 + RadFromDeg(90), 0);
  for (const double ahead_m : {1.0, 12.0, 5000.0}) {
    for (const double aside_m : {-0.4, 0.3}) {
      const auto seen = level.camera.Project(
          eye + ahead_m * (level.camera.ForwardInWorld() + aside_m * right));
      ASSERT_TRUE(seen);
      EXPECT_NEAR(seen->y(), horizon_px, kRoundingPx);
      EXPECT_NEAR(seen->x(), 500 + 800 * aside_m, kRoundingPx);
    }
  }
}

TEST(LevelCamera, WithoutADistanceTheTreeIsAsHighAsTheCrownGiven) {
  const LevelCamera level =
      MakeLevelCamera(1000, 1200, 800, 0, {500, 1000}, 200, {.crown_m = 10});
  EXPECT_NEAR(level.tree_height_m, 10, 1e-12);
  EXPECT_NEAR(level.distance_m, 10, 1e-12);  // 800 px of 800 px focal length
  EXPECT_NEAR(level.camera.Project({0, 0, 10})->y(), 200, kRoundingPx);
}

TEST(LevelCamera, RefusesATreeUpsideDown) {
  EXPECT_THROW(MakeLevelCamera(1000, 1200, 800, 0, {500, 100}, 200, {}),
               std::logic_error);
}

// A 50 mm lens on 36 x 24 mm of 3600 x 2400 pixels: 100 pixels a millimetre.
TEST(LevelCamera, FocalLengthFromTheEquivalent) {
  EXPECT_NEAR(FocalPixelsFrom35mm(50, 3600, 2400), 5000, 1e-9);
  EXPECT_NEAR(FocalPixelsFrom35mm(50, 2400, 3600), 5000, 1e-9);
  EXPECT_NEAR(FocalPixelsFrom35mm(kPhoneFocal35mm_mm, 4000, 3000),
              26 * 5000 / std::hypot(36, 24),
              1e-9);
  // 16:9 and a square, cut from 4:3: the lens sees the same in the same pixels
  EXPECT_NEAR(
      FocalPixelsFrom35mm(26, 4000, 2250), FocalPixelsFrom35mm(26, 4000, 3000), 1e-9);
  EXPECT_NEAR(
      FocalPixelsFrom35mm(26, 2250, 4000), FocalPixelsFrom35mm(26, 4000, 3000), 1e-9);
  EXPECT_NEAR(
      FocalPixelsFrom35mm(26, 3000, 3000), FocalPixelsFrom35mm(26, 4000, 3000), 1e-9);
}

}  // namespace
}  // namespace relight
