// SPDX-License-Identifier: Apache-2.0
#pragma once

// Cameras of a capture: found by COLMAP or imported, put on the Earth, and kept as a
// COLMAP text model in cameras/ with cameras/frame.json, which says how its frame is
// known.

#include "relight/base/progress.h"
#include "relight/cameras/georeference.h"
#include "relight/cameras/run_colmap.h"
#include "relight/cameras/tree_place.h"
#include "relight/capture/capture.h"

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// As on the command line.
struct CamerasRequest {
  std::optional<std::filesystem::path> import;  // Left out: COLMAP is run, or cameras
                                                // that are there are kept: TurnsKept().
  std::string import_format;                    // Empty: guessed.
  bool matching_only = false;  // Leave out what is only in the model or the capture.
  bool keep_frame = false;     // Its world is east, north, up in metres already.
  std::optional<std::string> heading;          // "VIEW=DEG", or "DEG" of the first view.
  std::optional<std::string> up;               // "X,Y,Z" in the model's own frame.
  std::vector<std::string> scale_from;         // VIEW, VIEW, LENGTH_m.
  std::vector<std::string> north_from_shadow;  // VIEW, "x1,y1", "x2,y2".
  std::optional<std::string> origin;  // "X,Y,Z" in the world that comes out, mostly the
                                      // tree's foot, to be made its origin.
  GeoreferenceOptions georeference;
  ColmapOptions colmap;
  bool force = false;  // Run COLMAP whatever is there.
};

// Whether the request puts the cameras that the capture has on the Earth anew, rather
// than finding others: something of their frame is said, and no import is.
bool TurnsKept(const Capture& capture, const CamerasRequest& request);

struct CamerasSummary {
  CalibratedScene scene;  // As written: ENU metres, the tree's foot at the origin.
  std::optional<Georeference> georeference;  // Unset: nothing said where, frame kept.
  TreePlace tree;
  std::vector<std::string> missing;  // Photos without a camera.
  std::string made_by;               // "COLMAP", "metashape import of FILE".
  std::vector<std::string> notes;    // One sentence each.
};

// What is going to be done, in words, and about how long it takes.
struct CamerasPlan {
  std::string what;
  double expected_s = 0.0;
};
CamerasPlan PlanCameras(const Capture& capture, const CamerasRequest& request);

// Makes cameras/. Photos' EXIF gives places and headings, turned to true north. Cameras
// are brought to the upright photo's own size. Cameras that are kept stay as they stand
// to each other; of their frame, north, up, scale and origin, what the request does not
// say stays as well. Imported cameras are not replaced by COLMAP's without `force`.
// Throws InputError with what is missing and the option that tells it, OptionError for
// texts that cannot be read, Cancelled; then cameras/ is as it was.
CamerasSummary MakeCameras(const Capture& capture,
                           const CamerasRequest& request,
                           const Progress& progress = {});

// What the last MakeCameras found, as it is kept in cameras/. Throws InputError as
// CamerasOf does. A frame.json that was changed or taken away is no error: what it would
// say is left out.
CamerasSummary KeptCameras(const Capture& capture);

// The whole of cameras/: points and the origin's place, too. Throws InputError as
// CamerasOf (relight/capture/capture.h) does.
CalibratedScene SceneOf(const Capture& capture);

// Gaps between neighbours around the tree that are wider than `least_rad`, as one walks
// around it clockwise: the views on both sides, and the gap.
struct ViewGap {
  std::string from, to;
  double gap_rad = 0.0;
};
std::vector<ViewGap> GapsAround(const CalibratedScene& scene,
                                const Eigen::Vector3d& foot,
                                double least_rad);

}  // namespace relight
