// SPDX-License-Identifier: Apache-2.0
#pragma once

// Bundler's file of cameras and points, "Bundle file v0.3" (.out), as Bundler, VisualSFM,
// Metashape and COLMAP write it.
//
//   # Bundle file v0.3
//   CAMERAS POINTS
//   f k1 k2, three rows of R, a row of t       of each camera
//   x y z, r g b, N and N x (camera key x y)   of each point
//
// A camera looks along its -z, y is up, and P = R X + t. With p = -(P.x, P.y) / P.z,
//
//   p' = f (1 + k1 |p|^2 + k2 |p|^4) p
//
// from the middle of the picture, y up. That is documented. That the middle is (w/2, h/2)
// with a pixel's centre at +0.5 is inferred: programs differ by half a pixel. A camera of
// f = 0 was not registered.
//
// Names stand in a second file, a line each: "photos/a.jpg", or "photos/a.jpg 0 532.5".
// For NAME.out it is the first of NAME.list.txt (COLMAP), NAME.out.list.txt and list.txt
// in its folder, or list.txt in the folder above (Bundler).

#include "relight/cameras/camera_parts.h"

#include <filesystem>

namespace relight {

// `path`: the .out file, or a folder with bundle.out or a single .out. Throws InputError
// with file, place and remedy: no list of names, a file cut off, a line that does not
// parse, a photo's size that is not known, and as FinishScene does.
CalibratedScene ReadBundler(const std::filesystem::path& path,
                            const PhotoSizes& photos,
                            UnknownPhotos unknown = UnknownPhotos::kRefuse);

}  // namespace relight
