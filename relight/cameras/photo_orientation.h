// SPDX-License-Identifier: Apache-2.0
#pragma once

// How one photo was held: from its horizon or its upright lines, and its heading.
//
// A pixel (u, v) lies on the ray r = ((u - cx)/f, (v - cy)/f, 1) in camera axes
// (docs/conventions.md#world). Two pixels a, b of the horizon span the level plane
// through the camera, so that the world's up is, in camera axes,
//
//   n = +-(r_a x r_b) / |r_a x r_b|,   n_y < 0                           (C3)
//
// and with the camera's axis c = (0, 0, 1) of heading h, and l the level direction that
// the camera looks along,
//
//   l = (c - (c.n) n) / |c - (c.n) n|
//   R = (l x n) east'^T + l ahead^T + n up^T                             (C4)
//
// with ahead = (sin h, cos h, 0), up = (0, 0, 1) and east' = ahead x up in the world.
// Upright lines meet in the pixel of n, wherever that is
// (relight/cameras/vertical_lines.h).

#include <Eigen/Core>

namespace relight {

// (C3): up in camera axes. The two pixels lie at least a pixel apart, and one not above
// the other: Throws std::logic_error else.
Eigen::Vector3d UpFromHorizon(const Eigen::Vector2d& a_px,
                              const Eigen::Vector2d& b_px,
                              double focal_px,
                              const Eigen::Vector2d& center_px);

// Up of a camera that is turned: `pitch_rad` above the horizon, then clockwise by
// `roll_rad` as seen from behind it.
Eigen::Vector3d UpFromPitchAndRoll(double pitch_rad, double roll_rad);
double PitchOf(const Eigen::Vector3d& up_in_camera);
double RollOf(const Eigen::Vector3d& up_in_camera);

// (C4): the rotation of camera_from_world. Heading is that of the camera's axis; a camera
// that looks within a degree of straight up or down has none: Throws std::logic_error.
Eigen::Matrix3d RotationFromUp(const Eigen::Vector3d& up_in_camera, double heading_rad);

}  // namespace relight
