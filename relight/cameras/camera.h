// SPDX-License-Identifier: Apache-2.0
#pragma once

// A photo's camera: pose, focal lengths and lens distortion, in the photo's own pixels.
//
// Axes and pixel centres: docs/conventions.md#pixels. With x, y on the plane z = 1 and
// r^2 = x^2 + y^2, a lens is one of COLMAP's FULL_OPENCV family, of which its
// SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL and OPENCV are special cases,
//
//   q  = (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
//   x' = x q + 2 p1 x y + p2 (r^2 + 2 x^2)
//   y' = y q + 2 p2 x y + p1 (r^2 + 2 y^2)                               (C1)
//
// or of its OPENCV_FISHEYE family, of which SIMPLE_RADIAL_FISHEYE and RADIAL_FISHEYE are
// special cases: with t = atan r,
//
//   (x', y') = (x, y) t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8) / r      (C2)
//
// and u = fx x' + cx, v = fy y' + cy. Rays are made through the lens, so that no picture
// is resampled and results are in the photo's own, distorted pixels.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace relight {

enum class LensModel {
  kBrown,    // (C1)
  kFisheye,  // (C2), which has no k5, k6, p1, p2.
};

struct Lens {
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0;
  double k3 = 0.0, k4 = 0.0, k5 = 0.0, k6 = 0.0;
  LensModel model = LensModel::kBrown;

  bool operator==(const Lens&) const = default;
  bool IsPinhole() const { return *this == Lens{}; }
};

struct Camera {
  int width_px = 0;
  int height_px = 0;
  Eigen::Vector2d focal_px = {1, 1};
  Eigen::Vector2d center_px = {0, 0};
  Lens lens;
  Eigen::Isometry3d camera_from_world = Eigen::Isometry3d::Identity();

  Eigen::Vector3d PositionInWorld() const;
  // Where the camera looks, ENU unit vector.
  Eigen::Vector3d ForwardInWorld() const;
  // Unit vector in the world of the ray through `pixel` (a pixel's centre is at +0.5).
  Eigen::Vector3d RayInWorld(const Eigen::Vector2d& pixel) const;
  // Where a point of the world is seen; nothing when it is not in front of the camera, or
  // so far off the axis that the lens' formula folds back.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& point_in_world) const;
  // The same camera for the photo resized to `width` x `height`.
  Camera Resized(int width, int height) const;
  // The same camera for the stored picture turned upright by its EXIF orientation: 3, 6
  // and 8 turn, 1 does not; mirrored ones (2, 4, 5, 7) no camera writes.
  Camera Upright(int orientation) const;
};

// A ray in the world, for many pixels of one camera: nothing but products inside.
struct Ray {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  // Unit length.
};

}  // namespace relight
