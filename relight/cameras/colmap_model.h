// SPDX-License-Identifier: Apache-2.0
#pragma once

// COLMAP's model, text (cameras.txt, images.txt, points3D.txt) or binary (.bin), of 3.8
// and later. COLMAP's pixel convention is ours. Points may be missing.
//
//   cameras   CAMERA_ID MODEL WIDTH HEIGHT PARAMS…
//   images    IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then its points
//   points3D  POINT3D_ID X Y Z R G B ERROR, then its track
//
// Camera models: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV,
// OPENCV_FISHEYE, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE (relight/cameras/camera.h).

#include "relight/cameras/calibrated_scene.h"

#include <filesystem>

namespace relight {

// `folder` holds the files; of text and binary the text is read. Throws InputError with
// file, place and remedy: a file missing or cut off, a line that does not parse, a model
// that is not read, and as FinishScene does.
CalibratedScene ReadColmap(const std::filesystem::path& folder);

// Writes the text model into `folder`, which is made.
void WriteColmap(const std::filesystem::path& folder, const CalibratedScene& scene);

}  // namespace relight
