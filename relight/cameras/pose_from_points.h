// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where a photo was taken from, and how it was held, from points whose places on Earth
// and whose pixels are known.
//
//   camera_from_world = argmin sum_i |u_i - Project(X_i)|^2               (C6)
//
// with u_i a pixel and X_i its place, from four points on, on one plane or not: the
// start is OpenCV's SQPNP, for points of one plane also IPPE with its two answers; each
// is refined by Levenberg's and Marquardt's method, and of those that see all points and
// stand above the lowest of them the best is taken.
//
// From six points that are not on one plane the focal length can be asked for as well: it
// is searched for between half and four times the photo's diagonal.

#include "relight/base/instant.h"
#include "relight/cameras/camera.h"

#include <span>
#include <string>
#include <vector>

namespace relight {

struct GroundPoint {
  Eigen::Vector2d pixel = {0, 0};
  Eigen::Vector3d position = {0, 0, 0};  // ENU, m (docs/conventions.md#world).
};

// ENU metres of places around `origin`, each `height_m` above the ground there; the
// ground is level, and the origin's altitude is of no matter.
Eigen::Vector3d EnuFromPlace(const Place& place, double height_m, const Place& origin);
// The place below or above a point of that world.
Place PlaceFromEnu(const Eigen::Vector3d& position, const Place& origin);

struct PoseFromPoints {
  Camera camera;
  std::vector<double> residual_px;  // Of each point, in their order.
  double rms_px = 0.0;
  double position_error_m = 0.0;  // Standard error that pixels off by rms_px make.
  bool focal_found = false;
  std::vector<std::string> notes;
};

// `camera` has size, centre and focal length; its pose is ignored. `find_focal`: its
// focal length is a guess, to be mended when the points allow. Points are named in
// messages as "point 1". Throws InputError: fewer than four points, two at one place or
// pixel, all on a line, or a pose that they do not fix.
PoseFromPoints FindPose(std::span<const GroundPoint> points,
                        const Camera& camera,
                        bool find_focal);

}  // namespace relight
