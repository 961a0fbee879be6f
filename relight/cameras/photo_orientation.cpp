// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/photo_orientation.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <Eigen/Geometry>
#include <cmath>

namespace relight {

// (C3)
Eigen::Vector3d UpFromHorizon(const Eigen::Vector2d& a_px,
                              const Eigen::Vector2d& b_px,
                              double focal_px,
                              const Eigen::Vector2d& center_px) {
  Require(std::abs(a_px.x() - b_px.x()) >= 1, "a horizon's pixels lie side by side");
  const Eigen::Vector3d a = ((a_px - center_px) / focal_px).homogeneous();
  const Eigen::Vector3d b = ((b_px - center_px) / focal_px).homogeneous();
  const Eigen::Vector3d up = a.cross(b).normalized();
  return up.y() < 0 ? up : Eigen::Vector3d(-up);
}

Eigen::Vector3d UpFromPitchAndRoll(double pitch_rad, double roll_rad) {
  const double level = std::cos(pitch_rad);
  return {-level * std::sin(roll_rad), -level * std::cos(roll_rad), std::sin(pitch_rad)};
}

double PitchOf(const Eigen::Vector3d& up_in_camera) {
  return std::atan2(up_in_camera.z(), up_in_camera.head<2>().norm());
}

double RollOf(const Eigen::Vector3d& up_in_camera) {
  return std::atan2(-up_in_camera.x(), -up_in_camera.y());
}

// (C4)
Eigen::Matrix3d RotationFromUp(const Eigen::Vector3d& up_in_camera, double heading_rad) {
  const Eigen::Vector3d n = up_in_camera.normalized();
  const Eigen::Vector3d along = Eigen::Vector3d::UnitZ() - n.z() * n;
  Require(along.norm() > std::sin(RadFromDeg(1)), "a heading is that of a level look");
  const Eigen::Vector3d l = along.normalized();
  const Eigen::Vector3d ahead = DirectionFromAzimuthElevation(heading_rad, 0);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  return l.cross(n) * ahead.cross(up).transpose() + l * ahead.transpose() +
         n * up.transpose();
}

}  // namespace relight
