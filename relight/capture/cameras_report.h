// SPDX-License-Identifier: Apache-2.0
#pragma once

// One HTML page, in one file, to judge a capture's cameras by: how its frame is known, a
// sheet of all photos with what became of each, a map from above with the sun at capture,
// what is left over of GPS and compasses, and each photo with horizon, north, ground and
// shadow drawn on it.

#include "relight/base/progress.h"
#include "relight/capture/capture_cameras.h"

#include <string>

namespace relight {

// Reads every photo. Throws InputError, Cancelled. The same bytes for the same capture.
std::string CamerasReport(const Capture& capture,
                          const CamerasSummary& summary,
                          const Progress& progress = {});

}  // namespace relight
