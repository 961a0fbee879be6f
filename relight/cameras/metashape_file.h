// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cameras of Agisoft Metashape and PhotoScan, as "Export Cameras" writes them in
// Agisoft's own XML.
//
//   document/chunk/sensors/sensor id type      resolution, calibration class="adjusted"
//   document/chunk/cameras/(group/)camera      sensor_id, component_id, label, transform
//   document/chunk/components/component id     transform: rotation, translation, scale
//   document/chunk/reference                   a coordinate system, as WKT
//
// A camera's transform is 4 x 4, rows first, and takes the camera (x right, y down, z
// forward) to the chunk. With s, R and t of its component, or else of the chunk,
//
//   x_world = s R x_chunk + t
//
// where the world is geocentric (ECEF) when the reference is a geographic or projected
// system. Then it is turned to ENU around the middle of the cameras, taking its ellipsoid
// for WGS84's; a local reference stays as it is. With x, y on the plane z = 1,
//
//   x' = x (1 + K1 r^2 + K2 r^4 + K3 r^6 + K4 r^8)
//          + (P1 (r^2 + 2 x^2) + 2 P2 x y) (1 + P3 r^2 + P4 r^4)
//   y' = y (…) + (P2 (r^2 + 2 y^2) + 2 P1 x y) (…)
//   u = w/2 + cx + x' (f + B1) + y' B2,   v = h/2 + cy + y' f
//
// so that P1 is p2 of (C1) and P2 is p1. For a fisheye, x and y are first multiplied by
// atan(r) / r: (C2). All of this is Agisoft's manual or seen in files. Inferred:
// PhotoScan before 1.2 (fx, fy and skew in place of f, B1 and B2) counts cx and cy from
// the corner, and has P1 and P2 in the order of (C1).

#include "relight/cameras/calibrated_scene.h"

#include <filesystem>

namespace relight {

// `path`: the file, or a folder with a single .xml of cameras. The photos' sizes are in
// the file; `photos` only tells which were turned after. Cameras that were not aligned,
// and those of components other than the largest, are left out with a note. Throws
// InputError with file, place and remedy: no XML, a part missing or no number, a sensor
// that no Camera can be (its K4 beyond what (C1) follows, P3, P4 or B2 that move a point
// of the frame by 0.01 pixels or more, spherical, cylindrical, equisolid, or with
// corrections), and as FinishScene does.
CalibratedScene ReadMetashape(const std::filesystem::path& path,
                              const PhotoSizes& photos = {});

}  // namespace relight
