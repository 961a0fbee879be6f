// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cameras and directions for tests.

#include "relight/base/angles.h"
#include "relight/cameras/camera.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

namespace relight::tests {

inline Eigen::Vector3d RandomDirection(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
}

// A camera at `eye` that looks at `target`, its x axis level.
inline Camera LookingAt(const Eigen::Vector3d& eye,
                        const Eigen::Vector3d& target,
                        int width_px,
                        int height_px,
                        double focal_px) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const bool upright = std::abs(forward.z()) > 0.999;
  const Eigen::Vector3d up =
      upright ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d right = forward.cross(up).normalized();
  Camera camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.focal_px = {focal_px, focal_px};
  camera.center_px = {width_px / 2.0, height_px / 2.0};
  Eigen::Matrix3d rotation;
  rotation.row(0) = right;
  rotation.row(1) = forward.cross(right);  // Down
  rotation.row(2) = forward;
  camera.camera_from_world.linear() = rotation;
  camera.camera_from_world.translation() = -(rotation * eye);
  return camera;
}

// `count` square cameras on a circle around `target`, every third one looking up at it
// and every third one down.
inline std::vector<Camera> RingOfCameras(const Eigen::Vector3d& target,
                                         double distance_m,
                                         int count,
                                         int size_px,
                                         double focal_px) {
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const double azimuth_rad = 2 * std::numbers::pi * i / count;
    const double elevation_rad = RadFromDeg(20.0 * (i % 3 - 1));
    const Eigen::Vector3d away =
        DirectionFromAzimuthElevation(azimuth_rad, elevation_rad);
    cameras.push_back(
        LookingAt(target + distance_m * away, target, size_px, size_px, focal_px));
  }
  return cameras;
}

}  // namespace relight::tests
