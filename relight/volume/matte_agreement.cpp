// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/matte_agreement.h"

#include "relight/volume/ray_traversal.h"
#include "relight/volume/visual_hull.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace relight {

double LostShare(std::span<const MatteView> views,
                 const Eigen::AlignedBox3d& bounds_in_world,
                 int kth_smallest) {
  constexpr int kCells = 32, kLongest_px = 96;
  constexpr double kHeld = 0.1;
  constexpr float kTree = 0.9f;
  const Footprints footprints =
      FootprintOpacity(EmptyGrid(bounds_in_world, kCells),
                       views,
                       {.kth_smallest = kth_smallest, .least_alpha = kHeld});
  int rays = 0, lost = 0;
  for (const MatteView& view : views) {
    const double shrink =
        std::max(1.0, std::max(view.alpha.cols, view.alpha.rows) / double{kLongest_px});
    const cv::Size size(
        std::max(1, static_cast<int>(std::lround(view.alpha.cols / shrink))),
        std::max(1, static_cast<int>(std::lround(view.alpha.rows / shrink))));
    cv::Mat1f alpha;
    cv::resize(view.alpha, alpha, size, 0, 0, cv::INTER_AREA);
    const Camera camera = view.camera.Resized(size.width, size.height);
    const Eigen::Vector3d eye = camera.PositionInWorld();
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        if (alpha(row, column) <= kTree) continue;
        bool held = false;
        TraverseRay(footprints.voxels,
                    {eye, camera.RayInWorld({column + 0.5, row + 0.5})},
                    0.0,
                    [&](std::size_t index, double, double) {
                      held = footprints.opacity[index] > 0;
                      return !held;
                    });
        ++rays;
        lost += held ? 0 : 1;
      }
    }
  }
  return rays > 0 ? static_cast<double>(lost) / rays : 0.0;
}

MatteAgreement AgreementOf(std::span<const MatteView> views, const Progress& progress) {
  constexpr std::size_t kFewest = 6;
  constexpr int kForgiving = 3;
  constexpr double kMuch = 0.02;  // Good mattes of rendered trees lose up to 0.002
  MatteAgreement agreement;
  if (views.size() < kFewest) return agreement;
  const Eigen::AlignedBox3d box =
      HullBounds(views, {.kth_smallest = kForgiving}, progress);
  agreement.lost = agreement.left = LostShare(views, box, 1);
  if (agreement.lost <= kMuch) return agreement;
  const double forgiven = LostShare(views, box, kForgiving);
  if (forgiven > agreement.lost / 2) return agreement;
  agreement.kth_smallest = kForgiving;
  agreement.left = forgiven;
  return agreement;
}

}  // namespace relight
