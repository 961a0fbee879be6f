// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/visual_hull.h"

#include "relight/base/error.h"
#include "relight/cameras/number_text.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

namespace relight {
namespace {

struct Outline {
  Eigen::Vector2d center_px;
  double radius_px = 0;  // Half the diagonal of the matte's box
};

Outline OutlineOf(const MatteView& view) {
  int left = view.alpha.cols, right = -1, top = view.alpha.rows, bottom = -1;
  for (int row = 0; row < view.alpha.rows; ++row) {
    for (int column = 0; column < view.alpha.cols; ++column) {
      if (view.alpha(row, column) < 0.5f) continue;
      left = std::min(left, column);
      right = std::max(right, column);
      top = std::min(top, row);
      bottom = std::max(bottom, row);
    }
  }
  if (right < 0) {
    throw InputError(
        view.name +
        ": the matte holds no tree (no pixel above 0.5); make another, or take the "
        "photo out of the capture");
  }
  return {{(left + right + 1) / 2.0, (top + bottom + 1) / 2.0},
          std::hypot(right - left + 1, bottom - top + 1) / 2};
}

// The sphere around the point nearest to the central rays:
// minimise sum_v |(I - d d^T)(p - c)|^2.
std::pair<Eigen::Vector3d, double> RoughSphere(std::span<const MatteView> views) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_side = Eigen::Vector3d::Zero();
  std::vector<Outline> outlines;
  for (const MatteView& view : views) {
    outlines.push_back(OutlineOf(view));
    const Eigen::Vector3d d = view.camera.RayInWorld(outlines.back().center_px);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    normal += across;
    right_side += across * view.camera.PositionInWorld();
  }
  if (normal.determinant() < 1e-6) {
    throw InputError(
        "the photos all look the same way, so that the tree's depth is unknown; add "
        "photos from "
        "other sides");
  }
  const Eigen::Vector3d center = normal.inverse() * right_side;
  double radius_m = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const double distance_m = (center - views[v].camera.PositionInWorld()).norm();
    radius_m = std::max(
        radius_m,
        outlines[v].radius_px * distance_m / views[v].camera.focal_px.minCoeff());
  }
  return {center, radius_m};
}

std::string CornersText(const Eigen::AlignedBox3d& box) {
  std::ostringstream text;
  text.precision(4);
  const char* before = "";
  for (const Eigen::Vector3d& corner : {box.min(), box.max()}) {
    for (const double x : {corner.x(), corner.y(), corner.z()}) {
      text << before << x;
      before = ",";
    }
  }
  return text.str();
}

}  // namespace

Eigen::AlignedBox3d HullBounds(std::span<const MatteView> views,
                               const HullOptions& options,
                               const Progress& progress) {
  if (views.size() < 2) throw InputError("a visual hull needs two views or more");
  RequireUsable(views);
  const auto [center, radius_m] = RoughSphere(views);
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(1.2 * radius_m);
  Eigen::AlignedBox3d box(center - reach, center + reach);
  constexpr int kPasses = 3, kCells = 64;
  for (int pass = 0; pass < kPasses; ++pass) {
    const ExtinctionGrid grid = EmptyGrid(box, kCells);
    const Footprints footprints = FootprintOpacity(
        grid,
        views,
        {.kth_smallest = options.kth_smallest, .least_alpha = options.least_alpha},
        progress.Part(1.0 * pass / kPasses, (pass + 1.0) / kPasses));
    Eigen::AlignedBox3d found;
    ForEachVoxel(footprints.voxels, [&](int x, int y, int z, std::size_t index) {
      if (footprints.opacity[index] > 0) found.extend(grid.Center(x, y, z));
    });
    if (found.isEmpty()) {
      throw InputError(
          "no point of space is tree in all mattes: cameras and mattes do not belong "
          "together, or "
          "one matte misses the tree; forgive bad mattes with --kth-smallest 3");
    }
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(1.5 * grid.cell_m);
    box = Eigen::AlignedBox3d(found.min() - margin, found.max() + margin);
  }
  return box;
}

VoxelBox PartWithin(const Eigen::AlignedBox3d& box,
                    int cells_longest,
                    const Eigen::AlignedBox3d& hull) {
  const ExtinctionGrid all = EmptyGrid(box, cells_longest);
  const Eigen::Array3d low = ((hull.min() - all.origin_m) / all.cell_m).array().floor();
  const Eigen::Array3d high = ((hull.max() - all.origin_m) / all.cell_m).array().ceil();
  const Eigen::Array3i from = low.max(0.0).min(1e4).cast<int>();
  const Eigen::Array3i to =
      high.max(0.0).min(all.cells.cast<double>().array()).cast<int>();
  if (!(from < to).all()) {
    throw InputError("the box that is given holds nothing of the tree, which is within " +
                     CornersText(hull) + "; give --box around it, or none");
  }
  return {{all.origin_m + all.cell_m * from.cast<double>().matrix(),
           all.origin_m + all.cell_m * to.cast<double>().matrix()},
          (to - from).maxCoeff()};
}

Eigen::AlignedBox3d BoxFromText(const std::string& corners) {
  std::string blanks = corners;
  std::replace(blanks.begin(), blanks.end(), ',', ' ');
  const auto numbers = NumbersFrom(blanks);
  Eigen::AlignedBox3d box;
  if (numbers && numbers->size() == 6) {
    box.extend(Eigen::Vector3d(numbers->data()));
    box.extend(Eigen::Vector3d(numbers->data() + 3));
  }
  if (box.isEmpty() || !(box.sizes().minCoeff() > 0)) {
    throw OptionError("box must be two opposite corners X,Y,Z,X,Y,Z [m], got \"" +
                      corners + "\"");
  }
  return box;
}

}  // namespace relight
