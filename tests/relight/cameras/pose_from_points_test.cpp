// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/pose_from_points.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "tests/support/made_cameras.h"

#include <gtest/gtest.h>

#include <random>

namespace relight {
namespace {

const Eigen::Vector3d kEye(3, -12, 1.7);

Camera True() { return tests::LookingAt(kEye, {0, 10, 3}, 4000, 3000, 2900); }

// Points as `camera` sees them, with clicks off by up to `noise_px` a side.
std::vector<GroundPoint> Seen(const Camera& camera,
                              const std::vector<Eigen::Vector3d>& places,
                              double noise_px = 0) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> off(-noise_px, noise_px);
  std::vector<GroundPoint> points;
  for (const Eigen::Vector3d& place : places) {
    const Eigen::Vector2d pixel = camera.Project(place).value();
    points.push_back({{pixel.x() + off(random), pixel.y() + off(random)}, place});
  }
  return points;
}

const std::vector<Eigen::Vector3d> kOnGround = {
    {-3, 0, 0}, {4, 2, 0}, {-6, 15, 0}, {5, 20, 0}};
const std::vector<Eigen::Vector3d> kAround = {
    {-3, 0, 0}, {4, 2, 1}, {-6, 15, 4}, {5, 20, 0}, {0, 30, 9}, {7, 25, 6}, {-2, 8, 2.5}};

Camera WithoutPose(double focal_px) {
  Camera camera = True();
  camera.focal_px = {focal_px, focal_px};
  camera.camera_from_world = Eigen::Isometry3d::Identity();
  return camera;
}

void ExpectPose(const Camera& found, double apart_m, double apart_deg) {
  EXPECT_LT((found.PositionInWorld() - kEye).norm(), apart_m);
  const Eigen::AngleAxisd turn(found.camera_from_world.linear() *
                               True().camera_from_world.linear().transpose());
  EXPECT_LT(DegFromRad(std::abs(turn.angle())), apart_deg);
}

TEST(PoseFromPoints, FourPointsOnTheGroundGiveThePoseBack) {
  const PoseFromPoints pose = FindPose(Seen(True(), kOnGround), WithoutPose(2900), false);
  ExpectPose(pose.camera, 1e-4, 1e-4);  // Where Levenberg and Marquardt's steps end
  EXPECT_LT(pose.rms_px, 1e-3);
  EXPECT_TRUE(pose.notes.empty());
  EXPECT_FALSE(pose.focal_found);
}

TEST(PoseFromPoints, PointsAtAnyHeightGiveThePoseBack) {
  const PoseFromPoints pose = FindPose(Seen(True(), kAround), WithoutPose(2900), false);
  ExpectPose(pose.camera, 1e-4, 1e-4);
}

TEST(PoseFromPoints, ClicksAreOffByAPixelOrTwo) {
  const PoseFromPoints pose =
      FindPose(Seen(True(), kAround, 2), WithoutPose(2900), false);
  ExpectPose(pose.camera, 0.1, 0.1);  // Two pixels of 2900 are 0.04 deg
  EXPECT_GT(pose.rms_px, 0.1);
  EXPECT_LT(pose.rms_px, 3);
  EXPECT_GT(pose.position_error_m, 0.002);
  EXPECT_LT(pose.position_error_m, 0.2);
}

TEST(PoseFromPoints, TheFocalLengthIsFoundWhenThePointsTellIt) {
  const PoseFromPoints pose = FindPose(Seen(True(), kAround, 1), WithoutPose(2000), true);
  EXPECT_TRUE(pose.focal_found);
  EXPECT_NEAR(pose.camera.focal_px.x(), 2900, 60);  // 2 %: clicks are off by a pixel
  const PoseFromPoints flat = FindPose(Seen(True(), kOnGround), WithoutPose(2000), true);
  EXPECT_FALSE(flat.focal_found);
  EXPECT_EQ(flat.camera.focal_px.x(), 2000);
}

TEST(PoseFromPoints, AWrongPointIsNamed) {
  std::vector<GroundPoint> points = Seen(True(), kAround);
  points[3].pixel.x() += 400;
  const PoseFromPoints pose = FindPose(points, WithoutPose(2900), false);
  ASSERT_FALSE(pose.notes.empty());
  std::string all;
  for (const std::string& note : pose.notes) all += note + "\n";
  EXPECT_NE(all.find("point 4"), std::string::npos) << all;
}

TEST(PoseFromPoints, RefusesWhatFixesNoPose) {
  const auto message = [](const std::vector<GroundPoint>& points) {
    try {
      FindPose(points, WithoutPose(2900), false);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no refusal");
  };
  std::vector<GroundPoint> points = Seen(True(), kOnGround);
  EXPECT_NE(message({points.begin(), points.begin() + 3}).find("four or more"),
            std::string::npos);
  EXPECT_NE(message(Seen(True(), {{-2, 0, 0}, {-1, 4, 0}, {0, 8, 0}, {1, 12, 0}}))
                .find("places lie on one line"),
            std::string::npos);
  points[2].position = points[1].position;
  EXPECT_NE(message(points).find("point 2 and point 3 are one place"), std::string::npos);
  points = Seen(True(), kOnGround);
  for (GroundPoint& point : points) point.pixel.y() = 1500;
  EXPECT_NE(message(points).find("pixels lie on one line"), std::string::npos);
}

TEST(PoseFromPoints, PlacesAreMetresAroundTheFirst) {
  const Place origin{48.8566, 2.3522, 35};
  // One thousandth of a degree of latitude: 111.2 m at 49 deg north
  const Eigen::Vector3d north = EnuFromPlace({48.8576, 2.3522, 0}, 2.5, origin);
  EXPECT_NEAR(north.x(), 0, 1e-6);
  EXPECT_NEAR(north.y(), 111.2, 0.05);
  EXPECT_EQ(north.z(), 2.5);
  const Eigen::Vector3d east = EnuFromPlace({48.8566, 2.3532, 0}, 0, origin);
  EXPECT_NEAR(east.x(), 73.4, 0.1);
  const Place back = PlaceFromEnu(north, origin);
  EXPECT_NEAR(back.latitude_deg, 48.8576, 1e-9);
  EXPECT_NEAR(back.longitude_deg, 2.3522, 1e-9);
}

}  // namespace
}  // namespace relight
