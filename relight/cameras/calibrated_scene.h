// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a program that calibrates photos hands over, whatever its file format: cameras of
// named views and the points that they have in common.

#include "relight/base/instant.h"
#include "relight/cameras/camera.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace relight {

struct NamedCamera {
  std::string view;  // The image's name without folders and extension.
  Camera camera;
};

struct ScenePoint {
  Eigen::Vector3d position;
  int views = 0;  // That see it; 0: not known.
};

struct CalibratedScene {
  std::vector<NamedCamera> cameras = {};  // In the order of their views' names.
  std::vector<ScenePoint> points = {};
  // Set when the file says where on Earth its world is: then the world is ENU metres
  // around this place. Else its frame and unit are the program's own.
  std::optional<Place> enu_origin = {};
  std::vector<std::string> notes = {};  // What had to be assumed, one sentence each.
};

// Upright sizes of the photos by view name, for formats that do not hold them.
struct PhotoSize {
  int width_px = 0;
  int height_px = 0;
};
using PhotoSizes = std::map<std::string, PhotoSize>;

// Puts cameras into the order of their views. Throws InputError that names `file`: no
// camera, two of one view, a name that leads out of a folder, numbers that are not finite
// or sizes and focal lengths that are not positive.
void FinishScene(CalibratedScene& scene, const std::string& file);

}  // namespace relight
