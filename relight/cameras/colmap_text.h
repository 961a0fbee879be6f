// SPDX-License-Identifier: Apache-2.0
#pragma once

// COLMAP's text model: cameras.txt and images.txt (points3D.txt is not read). The world
// is taken as ENU metres (docs/conventions.md#world); COLMAP's pixel convention is ours.
//
//   cameras.txt   CAMERA_ID MODEL WIDTH HEIGHT PARAMS…
//   images.txt    IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then a line of points

#include "relight/cameras/camera.h"

#include <filesystem>
#include <string>
#include <vector>

namespace relight {

struct NamedCamera {
  std::string view;  // The image's name without folders and extension.
  Camera camera;
};

// Cameras in the order of their views' names. `folder` holds both files.
// Throws InputError with file, line and remedy: a file missing, a line that does not
// parse, an unknown model, two images of one view's name, a name that leads out.
std::vector<NamedCamera> ReadColmapText(const std::filesystem::path& folder);

// Writes both files (and an empty points3D.txt) into `folder`, which is made.
void WriteColmapText(const std::filesystem::path& folder,
                     const std::vector<NamedCamera>& cameras);

}  // namespace relight
