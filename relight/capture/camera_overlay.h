// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a camera believes, drawn on its photo, so that an error is seen at once: the
// horizon with the winds, true north, a grid of 10 m on the ground, the sun, and the
// shadow that an upright pole at the trunk's foot would cast. When horizon, sun or shadow
// of the photo lie elsewhere, the camera or the time is wrong.

#include "relight/cameras/camera.h"

#include <opencv2/core.hpp>

#include <optional>
#include <string>

namespace relight {

struct CameraOverlayOptions {
  double ground_z_m = 0.0;
  std::optional<Eigen::Vector3d> sun_in_world;         // Unit vector, ENU.
  std::optional<Eigen::Vector3d> trunk_foot_in_world;  // Else as DefaultTrunkFoot.
  double trunk_height_m = 5.0;
  std::string caption;  // At the bottom, in ASCII; empty: none.
  int longest_px = 1600;
};

// Colours of what is drawn, R, G, B; each has a dark outline.
inline const cv::Vec3b kHorizonColor{255, 230, 90}, kNorthColor{255, 90, 80},
    kGridColor{220, 245, 255}, kSunColor{255, 170, 20}, kTrunkColor{110, 255, 130},
    kShadowColor{90, 150, 255};

// Where the ray through a pixel meets the ground; nothing above the horizon, or further
// away than 2 km.
std::optional<Eigen::Vector3d> GroundAt(const Camera& camera,
                                        const Eigen::Vector2d& pixel,
                                        double ground_z_m);

// 10 m ahead of the camera; where that is out of the picture, the ground low in the
// picture's middle. Nothing when the camera does not stand above ground that it sees.
std::optional<Eigen::Vector3d> DefaultTrunkFoot(const Camera& camera, double ground_z_m);

// Where the shadow of a pole's top falls on its ground, no further than 200 m; nothing
// when the sun is not up.
std::optional<Eigen::Vector3d> ShadowTip(const Eigen::Vector3d& foot_in_world,
                                         double height_m,
                                         const Eigen::Vector3d& sun_in_world);

// `display_rgb` is of the camera's proportions; `camera`'s world is ENU
// (docs/conventions.md#world). The copy is `longest_px` at most on its longer side, lines
// follow the lens. The same bytes for the same input.
cv::Mat3b CameraOverlay(const cv::Mat3b& display_rgb,
                        const Camera& camera,
                        const CameraOverlayOptions& options = {});

}  // namespace relight
