// SPDX-License-Identifier: Apache-2.0
#pragma once

// The camera of one photo alone: held level at eye height, nothing known but a focal
// length and a heading. The tree's foot is at the world's origin.

#include "relight/cameras/camera.h"

#include <optional>

namespace relight {

// A 4:3 phone's main camera, 35 mm equivalent: taken when EXIF has no focal length.
inline constexpr double kPhoneFocal35mm_mm = 26.0;

// Of a camera held before the eyes, above the ground.
inline constexpr double kEyeHeight_m = 1.6;

// Focal length in pixels from the 35 mm equivalent, which is defined by the diagonal
// (43.27 mm) of the frame (CIPA DCG-001). A picture wider than 8:5 is taken to be a 4:3
// frame whose long edges were cut off, as phones and drones do it, and one squarer than
// 6:5 one whose short edges were: their equivalent is that of the whole frame.
double FocalPixelsFrom35mm(double focal_35mm_mm, int width_px, int height_px);

struct LevelCameraOptions {
  double height_m = kEyeHeight_m;  // Of the camera above the tree's foot.
  double distance_m =
      0;  // To the tree's foot, along the ground; 0: from the crown's height.
  double crown_m = 8.0;  // Height of the crown when no distance is given.
};

struct LevelCamera {
  Camera camera;
  double distance_m = 0.0;
  double tree_height_m = 0.0;  // From the foot to the matte's top.
};

// A level camera at `heading_rad` whose photo shows the tree's foot at `foot_px` and its
// top at `top_px` (pixels from the photo's upper left corner). With the distance not
// given the tree is crown_m high. The foot is put at the world's origin; on a level
// camera it lies height_m below the horizon: the horizon row follows from that, whatever
// the photo was cropped to or however slightly it was tilted, and uprights stay upright.
LevelCamera MakeLevelCamera(int width_px,
                            int height_px,
                            double focal_px,
                            double heading_rad,
                            const Eigen::Vector2d& foot_px,
                            double top_px,
                            const LevelCameraOptions& options = {});

}  // namespace relight
