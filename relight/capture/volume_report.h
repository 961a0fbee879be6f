// SPDX-License-Identifier: Apache-2.0
#pragma once

// One HTML page, in one file, to judge a capture's volume by: slices, what each camera
// sees of it beside the view's matte, where the two part, and how the fit went.

#include "relight/base/progress.h"
#include "relight/capture/capture.h"

#include <string>

namespace relight {

// Reads volume.vdb and the mattes of the views it is made from. Throws InputError,
// Cancelled. The same bytes for the same capture.
std::string VolumeReport(const Capture& capture,
                         const CaptureOptions& options,
                         const Progress& progress = {});

}  // namespace relight
