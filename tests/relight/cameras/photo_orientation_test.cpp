// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/photo_orientation.h"

#include "relight/base/angles.h"
#include "relight/cameras/camera.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace relight {
namespace {

constexpr double kRounding = 1e-12;
const Eigen::Vector2d kCenter(2000, 1500);

Camera Held(double heading_deg, double pitch_deg, double roll_deg) {
  Camera camera;
  camera.width_px = 4000;
  camera.height_px = 3000;
  camera.focal_px = {3000, 3000};
  camera.center_px = kCenter;
  camera.camera_from_world.linear() =
      RotationFromUp(UpFromPitchAndRoll(RadFromDeg(pitch_deg), RadFromDeg(roll_deg)),
                     RadFromDeg(heading_deg));
  return camera;
}

TEST(PhotoOrientation, PitchAndRollComeBack) {
  for (const double pitch_deg : {-60.0, -8.0, 0.0, 14.0, 70.0}) {
    for (const double roll_deg : {-40.0, 0.0, 3.0}) {
      const Eigen::Vector3d up =
          UpFromPitchAndRoll(RadFromDeg(pitch_deg), RadFromDeg(roll_deg));
      EXPECT_NEAR(up.norm(), 1, kRounding);
      EXPECT_NEAR(DegFromRad(PitchOf(up)), pitch_deg, 1e-9);
      EXPECT_NEAR(DegFromRad(RollOf(up)), roll_deg, 1e-9);
    }
  }
}

// What is level with the camera is seen on the horizon, and the axis has the heading.
TEST(PhotoOrientation, TheHorizonAndTheHeadingGiveTheRotationBack) {
  for (const double heading_deg : {0.0, 76.0, 200.0, 359.0}) {
    for (const double pitch_deg : {-20.0, 0.0, 9.0}) {
      for (const double roll_deg : {-5.0, 0.0, 12.0}) {
        const Camera camera = Held(heading_deg, pitch_deg, roll_deg);
        EXPECT_NEAR(camera.camera_from_world.linear().determinant(), 1, kRounding);
        EXPECT_NEAR(DegFromRad(AzimuthOf(camera.ForwardInWorld())), heading_deg, 1e-9);
        EXPECT_NEAR(DegFromRad(ElevationOf(camera.ForwardInWorld())), pitch_deg, 1e-9);
        const auto left = camera.Project(
            DirectionFromAzimuthElevation(RadFromDeg(heading_deg - 25), 0));
        const auto right = camera.Project(
            DirectionFromAzimuthElevation(RadFromDeg(heading_deg + 20), 0));
        ASSERT_TRUE(left && right);
        EXPECT_LT(left->x(), right->x());
        const Eigen::Vector3d up = UpFromHorizon(*right, *left, 3000, kCenter);
        const Eigen::Matrix3d found = RotationFromUp(up, RadFromDeg(heading_deg));
        EXPECT_LT((found - camera.camera_from_world.linear()).norm(), 1e-9);
      }
    }
  }
}

// A camera turned clockwise sees the horizon rise to its right.
TEST(PhotoOrientation, RollIsClockwise) {
  const Camera camera = Held(0, 0, 10);
  const auto right = camera.Project(DirectionFromAzimuthElevation(RadFromDeg(20), 0));
  EXPECT_LT(right->y(), kCenter.y());
}

TEST(PhotoOrientation, AHorizonBelowTheMiddleIsALookUp) {
  const Eigen::Vector3d up = UpFromHorizon({0, 1800}, {4000, 1800}, 3000, kCenter);
  EXPECT_NEAR(PitchOf(up), std::atan(300.0 / 3000), kRounding);
  EXPECT_NEAR(RollOf(up), 0, kRounding);
}

TEST(PhotoOrientation, RefusesWhatHasNoHeading) {
  EXPECT_THROW(RotationFromUp({0, -0.001, 1}, 0), std::logic_error);
  EXPECT_THROW(UpFromHorizon({5, 0}, {5, 100}, 3000, kCenter), std::logic_error);
}

}  // namespace
}  // namespace relight
