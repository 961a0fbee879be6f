// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/calibrated_scene.h"

#include "relight/base/error.h"
#include "relight/cameras/view_name.h"

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

bool IsUsable(const Camera& camera) {
  const Lens& lens = camera.lens;
  const bool lens_is_finite = std::isfinite(lens.k1) && std::isfinite(lens.k2) &&
                              std::isfinite(lens.k3) && std::isfinite(lens.k4) &&
                              std::isfinite(lens.k5) && std::isfinite(lens.k6) &&
                              std::isfinite(lens.p1) && std::isfinite(lens.p2);
  return lens_is_finite && camera.focal_px.allFinite() && camera.center_px.allFinite() &&
         camera.camera_from_world.matrix().allFinite() && camera.width_px > 0 &&
         camera.height_px > 0 && camera.focal_px.minCoeff() > 0;
}

}  // namespace

void FinishScene(CalibratedScene& scene, const std::string& file) {
  if (scene.cameras.empty()) {
    throw InputError(file + ": no camera in it; no photo was registered in this model");
  }
  std::sort(scene.cameras.begin(),
            scene.cameras.end(),
            [](const NamedCamera& a, const NamedCamera& b) { return a.view < b.view; });
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
    const auto& [view, camera] = scene.cameras[i];
    RequireInsideCapture(view, file);
    if (!IsUsable(camera)) {
      throw InputError(file + ": the camera of " + view +
                       " has sizes or focal lengths that are not positive, or numbers "
                       "that are none; export it again");
    }
    if (i > 0 && scene.cameras[i - 1].view == view) {
      throw InputError(file + ": a second image of the name " + view +
                       " (extensions and folders do not count); rename one of the "
                       "photos");
    }
  }
  std::erase_if(scene.points,
                [](const ScenePoint& point) { return !point.position.allFinite(); });
}

}  // namespace relight
