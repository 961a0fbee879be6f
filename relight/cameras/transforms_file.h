// SPDX-License-Identifier: Apache-2.0
#pragma once

// transforms.json of nerfstudio and instant-ngp, and the transforms_train.json of
// Blender's synthetic scenes.
//
//   {"camera_model": "OPENCV", "w": 480, "h": 600, "fl_x": 1100, "fl_y": 1110,
//    "cx": 240, "cy": 300, "k1": -0.1, "k2": 0.02, "p1": 0, "p2": 0,
//    "frames": [{"file_path": "images/a.jpg", "transform_matrix": [[…], …]}, …]}
//
// transform_matrix takes the camera to the world, rows first, with the axes of OpenGL:
// x right, y up, z backwards. cx and cy are counted from the picture's corner. What
// stands at a frame goes before what stands at the top. A focal length is fl_x, or x_fov
// (degrees), or camera_angle_x (radians): f = w/2 / tan(angle/2); fl_y is fl_x and the
// centre the middle when left out, as for Blender, which has no w and h either.
//
// OPENCV (also PINHOLE, SIMPLE_PINHOLE, or no camera_model) is (C1) with a polynomial
// for q, whose k4 belongs to r^8; OPENCV_FISHEYE (or "is_fisheye": true) is (C2). All of
// this is what the readers of nerfstudio and instant-ngp do. applied_transform and
// applied_scale say how the world was turned before: they are not undone.

#include "relight/cameras/camera_parts.h"

#include <filesystem>

namespace relight {

// `path`: the file, or a folder with transforms.json or transforms_train.json. Throws
// InputError with file, place and remedy: no JSON, a field missing or of another type, a
// camera model or a lens that is not read, a photo's size that is neither in the file nor
// known, and as FinishScene does.
CalibratedScene ReadTransforms(const std::filesystem::path& path,
                               const PhotoSizes& photos,
                               UnknownPhotos unknown = UnknownPhotos::kRefuse);

// Writes `file` for nerfstudio; a view's name becomes file_path as it stands. Throws
// InputError for a lens that the format has no place for (k4, k5 or k6 of (C1)), for
// cameras of both families of lenses, and when the file cannot be written.
void WriteTransforms(const std::filesystem::path& file, const CalibratedScene& scene);

}  // namespace relight
