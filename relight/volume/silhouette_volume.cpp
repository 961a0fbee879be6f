// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/silhouette_volume.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

struct RowExtent {
  double middle_px = 0, radius_px = 0;  // radius 0: the row is empty
};

std::vector<RowExtent> RowExtents(const cv::Mat1f& alpha, double outline_alpha) {
  std::vector<RowExtent> rows(static_cast<std::size_t>(alpha.rows));
  for (int row = 0; row < alpha.rows; ++row) {
    int left = -1, right = -1;
    for (int column = 0; column < alpha.cols; ++column) {
      if (alpha(row, column) < outline_alpha) continue;
      if (left < 0) left = column;
      right = column;
    }
    if (left >= 0) {
      rows[static_cast<std::size_t>(row)] = {(left + right + 1) / 2.0,
                                             (right - left + 1) / 2.0};
    }
  }
  return rows;
}

}  // namespace

ExtinctionGrid SilhouetteVolume(const MatteView& view,
                                double tree_distance_m,
                                const SilhouetteOptions& options) {
  RequireUsable({&view, 1});
  const Camera& camera = view.camera;
  const std::vector<RowExtent> rows = RowExtents(view.alpha, options.outline_alpha);

  // Camera axes in the world, and the plane that holds the tree's axis
  const Eigen::Matrix3d world_from_camera = camera.camera_from_world.linear().transpose();
  const Eigen::Vector3d right = world_from_camera.col(0), down = world_from_camera.col(1);
  const Eigen::Vector3d forward = world_from_camera.col(2);
  const Eigen::Vector3d eye = camera.PositionInWorld();
  const auto metres = [&](double px) {
    return px * tree_distance_m / camera.focal_px.x();
  };

  // Box around all rows' circles
  Eigen::AlignedBox3d box;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (rows[row].radius_px == 0) continue;
    const double y_m = (static_cast<double>(row) + 0.5 - camera.center_px.y()) *
                       tree_distance_m / camera.focal_px.y();
    const Eigen::Vector3d axis =
        eye + tree_distance_m * forward + y_m * down +
        metres(rows[row].middle_px - camera.center_px.x()) * right;
    const double radius_m = metres(rows[row].radius_px);
    for (const double side : {-1.0, 1.0}) {
      box.extend(axis + side * radius_m * right);
      box.extend(axis + side * radius_m * forward);
    }
  }
  if (box.isEmpty()) {
    throw InputError(view.name + ": the matte holds no tree; make another");
  }
  // The nearer half of a circle is seen larger, so that its rows lean: one voxel of
  // margin
  const double margin = box.sizes().maxCoeff() / options.cells;
  box = Eigen::AlignedBox3d(box.min().array() - margin, box.max().array() + margin);

  ExtinctionGrid grid = EmptyGrid(box, options.cells);
  const std::vector<float> opacity = FootprintOpacity(grid, {&view, 1}, 1);
  ParallelRanges(grid.cells.z(), 1, [&](int begin, int end) {
    for (int z = begin; z < end; ++z) {
      for (int y = 0; y < grid.cells.y(); ++y) {
        for (int x = 0; x < grid.cells.x(); ++x) {
          const Eigen::Vector3d center = grid.Center(x, y, z);
          const auto pixel = camera.Project(center);
          if (!pixel || pixel->y() < 0 || pixel->y() >= camera.height_px) continue;
          const RowExtent& extent = rows[static_cast<std::size_t>(pixel->y())];
          const double aside_m = metres(pixel->x() - extent.middle_px);
          const double half_chord2 =
              std::pow(metres(extent.radius_px), 2) - aside_m * aside_m;
          const double depth_m = (center - eye).dot(forward) - tree_distance_m;
          if (half_chord2 <= 0 || depth_m * depth_m > half_chord2) continue;

          // (V2); a chord is at least a voxel long
          const std::size_t index = grid.Index(x, y, z);
          const double alpha = std::min<double>(opacity[index], options.alpha_max);
          const double chord_m = std::max(2 * std::sqrt(half_chord2), grid.cell_m);
          grid.sigma_per_m[index] =
              static_cast<float>(-std::log1p(-alpha) / chord_m * options.scale);
        }
      }
    }
  });
  return grid;
}

}  // namespace relight
