// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/silhouette_volume.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

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

// A row's cross-section on the upright plane of the tree.
struct Ellipse {
  Eigen::Vector3d middle = {0, 0, 0};
  double half_width_m = 0, half_depth_m = 0;  // 0: the row is empty
};

// d of (V2), from top to foot.
void GiveDepth(const CrownOptions& shape, std::vector<Ellipse>& rows) {
  double widest_m = 0;
  for (const Ellipse& row : rows) widest_m = std::max(widest_m, row.half_width_m);
  int top = -1, base = -1;
  for (int y = 0; y < static_cast<int>(rows.size()); ++y) {
    const double half_width_m = rows[static_cast<std::size_t>(y)].half_width_m;
    if (half_width_m > 0 && top < 0) top = y;
    if (half_width_m > widest_m / 3) base = y;
  }
  for (int y = 0; y < static_cast<int>(rows.size()); ++y) {
    Ellipse& row = rows[static_cast<std::size_t>(y)];
    if (row.half_width_m == 0) continue;
    const double u = (base + 0.5 - y) / (base + 1.0 - top);  // A row's middle
    const double full_m = shape.depth_ratio * widest_m;
    if (y > base) {
      row.half_depth_m = row.half_width_m;
    } else if (shape.crown == Crown::kAuto) {
      row.half_depth_m = shape.depth_ratio * row.half_width_m;
    } else if (shape.crown == Crown::kRound) {
      row.half_depth_m = full_m * std::sqrt(std::max(0.0, 1 - std::pow(2 * u - 1, 2)));
    } else if (shape.crown == Crown::kCone) {
      row.half_depth_m = full_m * (1 - u);
    } else if (shape.crown == Crown::kVase) {
      row.half_depth_m = full_m * u;
    } else {
      row.half_depth_m = full_m;
    }
  }
}

}  // namespace

ExtinctionGrid SilhouetteVolume(const MatteView& view,
                                double tree_distance_m,
                                const SilhouetteOptions& options) {
  CheckFields(options.shape);
  RequireUsable({&view, 1});
  const Camera& camera = view.camera;
  const std::vector<RowExtent> rows = RowExtents(view.alpha, options.outline_alpha);

  // The upright plane that holds the tree's axis, however the camera is tilted
  const Eigen::Vector3d eye = camera.PositionInWorld();
  const Eigen::Vector3d forward = camera.ForwardInWorld();
  Eigen::Vector3d ahead(forward.x(), forward.y(), 0);
  if (ahead.norm() < 0.1) ahead = forward;  // Straight up or down there is none
  ahead.normalize();
  const auto on_plane =
      [&](const Eigen::Vector2d& pixel) -> std::optional<Eigen::Vector3d> {
    const Eigen::Vector3d ray = camera.RayInWorld(pixel);
    if (ray.dot(ahead) < 0.05) return std::nullopt;
    return Eigen::Vector3d(eye + tree_distance_m / ray.dot(ahead) * ray);
  };

  // Each row's ellipse on that plane
  std::vector<Ellipse> ellipses(rows.size());
  for (std::size_t row = 0; row < rows.size(); ++row) {
    if (rows[row].radius_px == 0) continue;
    const double y = static_cast<double>(row) + 0.5;
    const auto left = on_plane({rows[row].middle_px - rows[row].radius_px, y});
    const auto right = on_plane({rows[row].middle_px + rows[row].radius_px, y});
    const auto middle = on_plane({rows[row].middle_px, y});
    if (!left || !right || !middle) continue;
    ellipses[row] = {*middle, (*right - *left).norm() / 2};
  }
  GiveDepth(options.shape, ellipses);
  Eigen::AlignedBox3d box;
  for (const Ellipse& ellipse : ellipses) {
    if (ellipse.half_width_m == 0) continue;
    // Nearest and farthest on the middle's own ray, which may climb
    const double reach = std::min(ellipse.half_depth_m / tree_distance_m, 0.95);
    for (const double side : {-reach, reach})
      box.extend(Eigen::Vector3d(ellipse.middle + side * (ellipse.middle - eye)));
    const Eigen::Vector3d aside(ahead.y(), -ahead.x(), 0);
    box.extend(Eigen::Vector3d(ellipse.middle + ellipse.half_width_m * aside));
    box.extend(Eigen::Vector3d(ellipse.middle - ellipse.half_width_m * aside));
  }
  if (box.isEmpty()) {
    throw InputError(view.name + ": the matte holds no tree; make another");
  }
  // The nearer half of a circle is seen larger, so that its rows lean: one voxel of
  // margin
  const double margin = box.sizes().maxCoeff() / options.cells;
  box = Eigen::AlignedBox3d(box.min().array() - margin, box.max().array() + margin);

  Footprints footprints = FootprintOpacity(EmptyGrid(box, options.cells), {&view, 1});
  ExtinctionGrid grid{std::move(footprints.voxels), {}};
  grid.sigma_per_m.assign(grid.Size(), 0.0f);
  constexpr int kValues = 8 * BrickVoxels::kPerBrick;  // A task
  ParallelRanges(static_cast<int>(grid.Size()), kValues, [&](int begin, int end) {
    for (auto index = static_cast<std::size_t>(begin);
         index < static_cast<std::size_t>(end);
         ++index) {
      if (footprints.opacity[index] == 0) continue;
      const Eigen::Vector3i at = grid.VoxelAt(index);
      const Eigen::Vector3d center = grid.Center(at.x(), at.y(), at.z());
      const auto pixel = camera.Project(center);
      if (!pixel || pixel->y() < 0 || pixel->y() >= camera.height_px) continue;
      const Ellipse& ellipse = ellipses[static_cast<std::size_t>(pixel->y())];
      const Eigen::Vector3d from_eye = center - eye;
      const double ahead_m = from_eye.dot(ahead);
      if (ellipse.half_depth_m == 0 || ahead_m <= 0) continue;
      const Eigen::Vector3d seen = eye + tree_distance_m / ahead_m * from_eye;
      const double aside = (seen - ellipse.middle).norm() / ellipse.half_width_m;
      if (aside >= 1) continue;
      const double half_chord_m = ellipse.half_depth_m * std::sqrt(1 - aside * aside);
      if (std::abs(ahead_m - tree_distance_m) > half_chord_m) continue;

      // (V2) along the ray, which need not be level; a chord is at least a voxel long
      const double alpha = std::min<double>(footprints.opacity[index], options.alpha_max);
      const double chord_m =
          std::max(2 * half_chord_m * from_eye.norm() / ahead_m, grid.cell_m);
      grid.sigma_per_m[index] =
          static_cast<float>(-std::log1p(-alpha) / chord_m * options.scale);
    }
  });
  grid.DropEmptyBricks();
  return grid;
}

}  // namespace relight
