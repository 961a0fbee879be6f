// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cameras of RealityCapture (RealityScan): a table "Internal/External camera parameters"
// (.csv), or an XMP file beside each photo.
//
//   #name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2
//
//   <rdf:Description xcr:DistortionModel="brown3" xcr:FocalLength35mm="24.4"
//       xcr:Skew="0" xcr:AspectRatio="1" xcr:PrincipalPointU="0" xcr:PrincipalPointV="0">
//     <xcr:Rotation>nine numbers</xcr:Rotation> <xcr:Position>three</xcr:Position>
//     <xcr:DistortionCoeficients>k1 k2 k3 k4 t1 t2</xcr:DistortionCoeficients> …
//
// each of which may be an attribute or an element. In XMP, Rotation takes the world to
// the camera (x right, y down, z forward), rows first, and Position is the camera's. In
// the table, with the camera's axes x right, y up, z backwards,
//
//   R_world_from_camera = Rz(-heading) Rx(pitch) Ry(roll)
//
// With l the longer side of the photo, f the focal length of 35 mm film (36 mm along l),
// and U, V (px, py) the principal point,
//
//   q = 1 + k1 r^2 + k2 r^4 + k3 r^6 + k4 r^8
//   u = w/2 + l (U + f/36 x'),   v = h/2 + l (V + f/36 a y')
//
// Documented by its makers: XMP, but for the next sentence. Inferred: t1 is p2 of (C1)
// and t2 is p1, as two other importers have it while two have it the other way; a note
// says so when they are not zero. Checked on one published camera: the angles. Inferred
// from published tables: px and py are shares of l, and not millimetres as f is.

#include "relight/cameras/camera_parts.h"

#include <filesystem>

namespace relight {

// `path`: the table; a folder with XMP files, or else with a single .csv; or one XMP
// file. XMP files without a pose, such as other programs leave, are left out with a note.
// The frame is the one that was exported: metres, but not known to be ENU. Throws
// InputError with file, place and remedy: a column or field missing or no number, a
// distortion model other than perspective and brown (division), a skew, a photo's size
// that is not known, and as FinishScene does.
CalibratedScene ReadRealityCapture(const std::filesystem::path& path,
                                   const PhotoSizes& photos,
                                   UnknownPhotos unknown = UnknownPhotos::kRefuse);

}  // namespace relight
