// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/level_camera.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <algorithm>
#include <cmath>

namespace relight {

double FocalPixelsFrom35mm(double focal_35mm_mm, int width_px, int height_px) {
  constexpr double kFullFrameDiagonal_mm = 43.266615305567875;  // hypot(36, 24)
  const double wide = std::max(width_px, height_px),
               narrow = std::min(width_px, height_px);
  const double diagonal_px = wide > 1.6 * narrow   ? 5.0 / 4 * wide
                             : wide < 1.2 * narrow ? 5.0 / 3 * narrow
                                                   : std::hypot(wide, narrow);
  return focal_35mm_mm * diagonal_px / kFullFrameDiagonal_mm;
}

LevelCamera MakeLevelCamera(int width_px,
                            int height_px,
                            double focal_px,
                            double heading_rad,
                            const Eigen::Vector2d& foot_px,
                            double top_px,
                            const LevelCameraOptions& options) {
  Require(width_px > 0 && height_px > 0 && focal_px > 0,
          "a photo has a size and a focal length");
  Require(top_px < foot_px.y(), "the tree's top is above its foot");

  // Distance: given, or such that foot to top is the crown's height
  LevelCamera result;
  result.distance_m = options.distance_m > 0
                          ? options.distance_m
                          : options.crown_m * focal_px / (foot_px.y() - top_px);
  result.tree_height_m = (foot_px.y() - top_px) * result.distance_m / focal_px;

  Camera& camera = result.camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.focal_px = {focal_px, focal_px};

  // Eye height puts the horizon's row; the photo may have been cropped or the camera
  // tilted, and a shift of the principal point keeps uprights upright in both cases
  camera.center_px = {width_px / 2.0,
                      foot_px.y() - options.height_m * focal_px / result.distance_m};

  // x right, y down, z forward, in ENU
  Eigen::Matrix3d rotation;
  const Eigen::Vector3d forward = DirectionFromAzimuthElevation(heading_rad, 0);
  rotation.row(0) = DirectionFromAzimuthElevation(heading_rad + std::numbers::pi / 2, 0);
  rotation.row(1) = -Eigen::Vector3d::UnitZ();
  rotation.row(2) = forward;

  // The foot, in the camera's frame, is the world's origin
  const Eigen::Vector3d foot(
      (foot_px.x() - camera.center_px.x()) * result.distance_m / focal_px,
      options.height_m,
      result.distance_m);
  camera.camera_from_world.linear() = rotation;
  camera.camera_from_world.translation() = foot;
  return result;
}

}  // namespace relight
