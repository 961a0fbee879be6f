// SPDX-License-Identifier: Apache-2.0
#pragma once

// The voxels of a regular grid that may hold tree, in bricks of 8 x 8 x 8, and the rays'
// way through them. What is not in a brick takes no memory; values live in arrays of
// Size() entries beside it.

#include "relight/cameras/camera.h"
#include "relight/volume/extinction_grid.h"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace relight {

struct BrickVoxels {
  static constexpr int kEdge = 8, kPerBrick = kEdge * kEdge * kEdge;

  Eigen::Vector3i cells = {0, 0, 0};  // As of the ExtinctionGrid that it stands for.
  Eigen::Vector3d origin_m = {0, 0, 0};
  double cell_m = 0.0;
  Eigen::Vector3i bricks = {0, 0, 0};  // Along x, y, z.
  std::vector<std::int32_t>
      brick_of;  // Per place of a brick, x fastest: its number or -1
  std::vector<Eigen::Vector3i> brick_at;  // Its lowest voxel.

  std::size_t Size() const { return brick_at.size() * kPerBrick; }

  static int Local(int x, int y, int z) { return (z & 7) << 6 | (y & 7) << 3 | (x & 7); }
  std::int32_t BrickOf(int x, int y, int z) const {
    return brick_of[static_cast<std::size_t>(
        ((z >> 3) * bricks.y() + (y >> 3)) * bricks.x() + (x >> 3))];
  }
  // Where the voxel's value is; -1 outside the grid and where there is no brick.
  std::ptrdiff_t Find(int x, int y, int z) const {
    if (x < 0 || y < 0 || z < 0 || x >= cells.x() || y >= cells.y() || z >= cells.z())
      return -1;
    const std::int32_t brick = BrickOf(x, y, z);
    return brick < 0 ? -1
                     : static_cast<std::ptrdiff_t>(brick) * kPerBrick + Local(x, y, z);
  }
};

// An empty frame for the grid's voxels: no brick yet.
inline BrickVoxels NoBricks(const ExtinctionGrid& like) {
  BrickVoxels voxels;
  voxels.cells = like.cells;
  voxels.origin_m = like.origin_m;
  voxels.cell_m = like.cell_m;
  voxels.bricks = (like.cells.array() + 7) / 8;
  voxels.brick_of.assign(static_cast<std::size_t>(voxels.bricks.prod()), -1);
  return voxels;
}

// Calls visit(index of the value, length in voxel edges) for each voxel of a brick that
// the ray crosses, in order. [Amanatides87], as TraverseRay.
template <class Visit>
void TraverseBricks(const BrickVoxels& voxels, const Ray& ray, Visit&& visit) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  // In voxel edges
  const Eigen::Vector3d origin = (ray.origin - voxels.origin_m) / voxels.cell_m;
  double enter = 0, leave = kFar;
  for (int axis = 0; axis < 3; ++axis) {
    const double slope = ray.direction[axis];
    const double low = -origin[axis], high = voxels.cells[axis] - origin[axis];
    if (std::abs(slope) < 1e-12) {
      if (low > 0 || high < 0) return;
      continue;
    }
    enter = std::max(enter, std::min(low / slope, high / slope));
    leave = std::min(leave, std::max(low / slope, high / slope));
  }
  if (!(enter < leave)) return;
  int cell[3], step[3];
  double next[3], stride[3];
  for (int axis = 0; axis < 3; ++axis) {
    const double slope = ray.direction[axis];
    const double at = origin[axis] + enter * slope;
    cell[axis] = std::clamp(static_cast<int>(std::floor(at)), 0, voxels.cells[axis] - 1);
    step[axis] = slope > 0 ? 1 : -1;
    const bool is_level = std::abs(slope) < 1e-12;
    next[axis] =
        is_level ? kFar : (cell[axis] + (slope > 0 ? 1 : 0) - origin[axis]) / slope;
    stride[axis] = is_level ? kFar : 1 / std::abs(slope);
  }
  double at = enter;
  std::int32_t brick = voxels.BrickOf(cell[0], cell[1], cell[2]);
  for (;;) {
    const int axis =
        next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : (next[1] < next[2] ? 1 : 2);
    const double exit = std::min(next[axis], leave);
    if (exit > at) {
      if (brick >= 0) {
        visit(static_cast<std::size_t>(brick) * BrickVoxels::kPerBrick +
                  static_cast<std::size_t>(BrickVoxels::Local(cell[0], cell[1], cell[2])),
              static_cast<float>(exit - at));
      }
      at = exit;
    }
    const int before = cell[axis];
    cell[axis] += step[axis];
    if (cell[axis] < 0 || cell[axis] >= voxels.cells[axis] || at >= leave) return;
    next[axis] += stride[axis];
    if ((before ^ cell[axis]) >> 3) brick = voxels.BrickOf(cell[0], cell[1], cell[2]);
  }
}

}  // namespace relight
