// SPDX-License-Identifier: Apache-2.0
#pragma once

// Where the tree stands in a scene that is in ENU metres already, so that its foot can be
// made the origin.
//
// Across the ground it is the point that the cameras look at, x nearest to their view
// axes (p_i, d_i), Tukey-weighted so that some may look past it:
//
//   minimise  sum_i rho(|(I - d_i d_i^T)(x - p_i)|)                       (C8)
//
// The ground is the plane of most sparse points, at most 15 degrees steep, with hardly
// any point below it. Without one it is 1.6 m below the cameras, and said to be.

#include "relight/cameras/calibrated_scene.h"

#include <optional>
#include <string>

namespace relight {

struct TreePlace {
  Eigen::Vector3d foot = Eigen::Vector3d::Zero();  // On the ground.
  bool is_looked_at = false;                       // The cameras look at one place.
  double axes_error_m = 0.0;  // How far their axes pass by it, in the median.
  int ground_points = 0;      // That lie on the ground; 0: it was not seen.
  double ground_error_m = 0.0;
  double slope_rad = 0.0;
  std::string ground_from;  // "1203 points", "eye height".
};

// Where cameras look in parallel or past each other, as from a drone over a park, `foot`
// is below their middle. Never throws.
TreePlace FindTreePlace(const CalibratedScene& scene);

}  // namespace relight
