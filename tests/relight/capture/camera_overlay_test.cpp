// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/camera_overlay.h"

#include "relight/base/angles.h"
#include "tests/support/made_cameras.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

// 1.6 m above the ground, looks north-east and a little up; its lens bends.
Camera Above() {
  Camera camera = tests::LookingAt({0, 0, 1.6}, {10, 10, 2.2}, 1200, 900, 800);
  camera.lens.k1 = -0.1;
  return camera;
}

cv::Mat3b Grey() { return cv::Mat3b(900, 1200, cv::Vec3b(128, 128, 128)); }

// Is there a pixel of this colour within two pixels of `at`? Lines are anti-aliased.
bool Drawn(const cv::Mat3b& picture, const Eigen::Vector2d& at, const cv::Vec3b& color) {
  for (int row = static_cast<int>(at.y()) - 2; row <= at.y() + 2; ++row) {
    for (int column = static_cast<int>(at.x()) - 2; column <= at.x() + 2; ++column) {
      if (row < 0 || column < 0 || row >= picture.rows || column >= picture.cols)
        continue;
      if (cv::norm(picture(row, column), color, cv::NORM_L1) < 150) return true;
    }
  }
  return false;
}

bool InPicture(const Eigen::Vector2d& p) {
  return p.x() > 4 && p.y() > 4 && p.x() < 1196 && p.y() < 896;
}

TEST(CameraOverlay, TheHorizonLiesWhereTheCameraSeesIt) {
  const Camera camera = Above();
  const cv::Mat3b picture = CameraOverlay(Grey(), camera);
  int seen_count = 0;
  for (double azimuth_deg = 20.5; azimuth_deg < 80; azimuth_deg += 3) {
    const auto seen =
        camera.Project(camera.PositionInWorld() +
                       1e5 * DirectionFromAzimuthElevation(RadFromDeg(azimuth_deg), 0));
    if (!seen || !InPicture(*seen)) continue;
    EXPECT_TRUE(Drawn(picture, *seen, kHorizonColor)) << azimuth_deg;
    ++seen_count;
  }
  EXPECT_GT(seen_count, 12);
}

TEST(CameraOverlay, TheGridIsOfTenMetresOnTheGround) {
  const Camera camera = Above();
  CameraOverlayOptions options;
  options.ground_z_m = -0.4;
  options.trunk_foot_in_world = Eigen::Vector3d(-20, -20, -0.4);  // Behind: not drawn
  const cv::Mat3b picture = CameraOverlay(Grey(), camera, options);
  int on_lines = 0, off_lines = 0;
  for (double along_m = 6.5; along_m < 18; along_m += 1) {
    const auto on = camera.Project({10, along_m, -0.4});
    const auto off = camera.Project({along_m, along_m + 3, -0.4});
    if (on && InPicture(*on)) on_lines += Drawn(picture, *on, kGridColor) ? 1 : -100;
    const double to_ten = std::min(std::abs(along_m - 10), std::abs(along_m + 3 - 10));
    if (off && InPicture(*off) && to_ten > 1 && along_m < 9)
      off_lines += Drawn(picture, *off, kGridColor) ? 1 : 0;
  }
  EXPECT_GT(on_lines, 5);
  EXPECT_EQ(off_lines, 0);
}

TEST(CameraOverlay, TheSunInThePictureIsADisc) {
  const Camera camera = Above();
  CameraOverlayOptions options;
  options.sun_in_world = DirectionFromAzimuthElevation(RadFromDeg(55), RadFromDeg(20));
  const auto seen =
      camera.Project(camera.PositionInWorld() + 1e6 * *options.sun_in_world);
  ASSERT_TRUE(seen && InPicture(*seen));
  const cv::Mat3b picture = CameraOverlay(Grey(), camera, options);
  const cv::Mat1b same = [&] {
    cv::Mat1b mask;
    cv::inRange(picture,
                cv::Scalar(cv::Vec3d(kSunColor)),
                cv::Scalar(cv::Vec3d(kSunColor)),
                mask);
    return mask;
  }();
  for (const Eigen::Vector2d& offset :
       {Eigen::Vector2d(0, 0), {4, 0}, {-4, 0}, {0, 4}, {0, -4}}) {
    const Eigen::Vector2d p = *seen + offset;
    EXPECT_TRUE(same(static_cast<int>(p.y()), static_cast<int>(p.x()))) << offset;
  }
}

// Behind on the left: the arrow is on the picture's left half.
TEST(CameraOverlay, TheSunOutsideIsAnArrowTowardsIt) {
  CameraOverlayOptions options;
  options.sun_in_world =
      DirectionFromAzimuthElevation(RadFromDeg(45 - 120), RadFromDeg(15));
  const cv::Mat3b picture = CameraOverlay(Grey(), Above(), options);
  cv::Mat1b mask;
  cv::inRange(
      picture, cv::Scalar(cv::Vec3d(kSunColor)), cv::Scalar(cv::Vec3d(kSunColor)), mask);
  EXPECT_GT(cv::countNonZero(mask.colRange(0, 600)), 100);
  EXPECT_EQ(cv::countNonZero(mask.colRange(600, 1200)), 0);
}

TEST(CameraOverlay, TheShadowFallsAwayFromTheSun) {
  const Eigen::Vector3d sun =
      DirectionFromAzimuthElevation(RadFromDeg(135), RadFromDeg(45));
  // As long as the pole is high, towards 315 degrees
  const Eigen::Vector3d tip = ShadowTip({3, 4, 0}, 5, sun).value();
  EXPECT_NEAR(
      (tip - Eigen::Vector3d(3 - 5 * std::sqrt(0.5), 4 + 5 * std::sqrt(0.5), 0)).norm(),
      0,
      1e-12);
  EXPECT_FALSE(ShadowTip({3, 4, 0}, 5, {0, 1, 0}));
  EXPECT_NEAR(ShadowTip({0, 0, 0}, 5, {0, 1, 1e-6}).value().norm(), 200, 1e-9);

  const Camera camera = Above();
  CameraOverlayOptions options;
  options.sun_in_world = sun;
  options.trunk_foot_in_world = Eigen::Vector3d(7, 6, 0);
  const cv::Mat3b picture = CameraOverlay(Grey(), camera, options);
  const Eigen::Vector3d end = ShadowTip({7, 6, 0}, 5, sun).value();
  for (const double t : {0.3, 0.6, 0.9}) {
    const auto seen = camera.Project(Eigen::Vector3d(7, 6, 0) * (1 - t) + end * t);
    ASSERT_TRUE(seen && InPicture(*seen));
    EXPECT_TRUE(Drawn(picture, *seen, kShadowColor)) << t;
    const auto pole = camera.Project({7, 6, 5 * t});
    EXPECT_TRUE(Drawn(picture, *pole, kTrunkColor)) << t;
  }
}

TEST(CameraOverlay, IsACopyOfAScreensSize) {
  const cv::Mat3b photo(3000, 4000, cv::Vec3b(200, 210, 220));
  const Camera camera = Above().Resized(4000, 3000);
  const cv::Mat3b first = CameraOverlay(photo, camera),
                  second = CameraOverlay(photo, camera);
  EXPECT_EQ(first.size(), cv::Size(1600, 1200));
  EXPECT_EQ(cv::norm(first, second, cv::NORM_INF), 0);
  EXPECT_EQ(photo(1500, 2000), cv::Vec3b(200, 210, 220));
}

TEST(CameraOverlay, GroundIsBelowTheHorizon) {
  const Camera camera = Above();
  EXPECT_FALSE(GroundAt(camera, {600, 10}, 0));
  const auto ground = GroundAt(camera, {700, 800}, 0);
  ASSERT_TRUE(ground);
  EXPECT_NEAR(ground->z(), 0, 1e-12);
  EXPECT_LT((camera.Project(*ground).value() - Eigen::Vector2d(700, 800)).norm(), 1e-6);
  EXPECT_NEAR(DefaultTrunkFoot(camera, 0)->head<2>().norm(), 10, 1e-9);
  EXPECT_FALSE(DefaultTrunkFoot(camera, 5));
}

}  // namespace
}  // namespace relight
