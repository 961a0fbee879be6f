// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/tree_place.h"

#include "relight/base/angles.h"
#include "tests/support/made_cameras.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

// Cameras around a tree at (3, -2) on ground that rises to the east, and its points.
CalibratedScene MadeScene(double slope_deg, bool with_ground) {
  const double rise = std::tan(RadFromDeg(slope_deg));
  const auto ground_m = [&](double x) { return 10 + rise * (x - 3); };
  CalibratedScene scene;
  for (int i = 0; i < 16; ++i) {
    const Eigen::Vector3d away =
        DirectionFromAzimuthElevation(2 * std::numbers::pi * i / 16, 0);
    Eigen::Vector3d eye = Eigen::Vector3d(3, -2, 0) + 15 * away;
    eye.z() = ground_m(eye.x()) + 1.6;
    scene.cameras.push_back({"v" + std::to_string(10 + i),
                             tests::LookingAt(eye, {3, -2, 14}, 800, 600, 700)});
  }
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 800; ++i) {
    // The crown, and walls around
    const Eigen::Vector3d crown =
        Eigen::Vector3d(3, -2, 15) + 2 * tests::RandomDirection(random);
    scene.points.push_back({crown, 4});
    if (!with_ground || i % 2 == 1) continue;
    const double x = 3 + 6 * normal(random), y = -2 + 6 * normal(random);
    scene.points.push_back({{x, y, ground_m(x) + 0.03 * normal(random)}, 3});
  }
  return scene;
}

TEST(TreePlace, IsWhereTheCamerasLookAndTheGroundIs) {
  for (const double slope_deg : {0.0, 6.0}) {
    const TreePlace place = FindTreePlace(MadeScene(slope_deg, true));
    EXPECT_TRUE(place.is_looked_at);
    // Ground points scatter by 3 cm; the axes meet exactly
    EXPECT_LT((place.foot - Eigen::Vector3d(3, -2, 10)).norm(), 0.05) << slope_deg;
    EXPECT_NEAR(DegFromRad(place.slope_rad), slope_deg, 0.3);
    EXPECT_GT(place.ground_points, 300);
    EXPECT_LT(place.ground_error_m, 0.06);
  }
}

TEST(TreePlace, OneViewThatLooksElsewhereChangesNothing) {
  CalibratedScene scene = MadeScene(0, true);
  Camera& stray = scene.cameras[4].camera;
  stray = tests::LookingAt(stray.PositionInWorld(), {-30, 20, 14}, 800, 600, 700);
  EXPECT_LT((FindTreePlace(scene).foot - Eigen::Vector3d(3, -2, 10)).norm(), 0.1);
}

TEST(TreePlace, WithoutGroundPointsTheCamerasAreAtEyeHeight) {
  const TreePlace place = FindTreePlace(MadeScene(0, false));
  EXPECT_NEAR(place.foot.z(), 10, 1e-6);
  EXPECT_EQ(place.ground_points, 0);
  EXPECT_NE(place.ground_from.find("assumed"), std::string::npos);
}

TEST(TreePlace, CamerasThatLookDownInParallelLookAtNoTree) {
  CalibratedScene scene;
  for (int i = 0; i < 9; ++i) {
    const Eigen::Vector3d eye(10.0 * (i % 3), 10.0 * (i / 3), 40);
    scene.cameras.push_back(
        {"v" + std::to_string(i),
         tests::LookingAt(eye, {eye.x(), eye.y(), 0}, 800, 600, 700)});
  }
  const TreePlace place = FindTreePlace(scene);
  EXPECT_FALSE(place.is_looked_at);
  EXPECT_NEAR(place.foot.x(), 10, 1e-9);
}

}  // namespace
}  // namespace relight
