// SPDX-License-Identifier: Apache-2.0
#pragma once

// The voxels a ray crosses, in order, and the exact length in each, after [Amanatides87]
// (docs/bibliography.md#amanatides87).

#include "relight/cameras/camera.h"
#include "relight/volume/extinction_grid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace relight {

// Calls visit(voxel index, entry [m from the ray's origin], length [m]) for each voxel
// from `start_m` on; visit answers false to stop. Voxels of no length are passed over.
// The sum of the lengths is the length of the ray inside the grid.
template <class Visit>
void TraverseRay(const ExtinctionGrid& grid,
                 const Ray& ray,
                 double start_m,
                 Visit&& visit) {
  constexpr double kFar = std::numeric_limits<double>::infinity();

  // Enter and leave the box, slab by slab
  double enter = start_m, leave = kFar;
  std::array<double, 3> to_exit_m{};   // Ray parameter of the next face of each axis
  std::array<double, 3> per_cell_m{};  // From one face to the next
  std::array<int, 3> cell{}, step{};
  for (int axis = 0; axis < 3; ++axis) {
    const double low = grid.origin_m[axis] - ray.origin[axis];
    const double high = low + grid.cell_m * grid.cells[axis];
    const double slope = ray.direction[axis];
    if (std::abs(slope) < 1e-12) {
      if (low > 0 || high < 0) return;
      continue;
    }
    enter = std::max(enter, std::min(low / slope, high / slope));
    leave = std::min(leave, std::max(low / slope, high / slope));
  }
  if (!(enter < leave)) return;

  // First voxel, and where its faces are
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double slope = ray.direction[a];
    const double at = (ray.origin[a] + enter * slope - grid.origin_m[a]) / grid.cell_m;
    cell[axis] = std::clamp(static_cast<int>(std::floor(at)), 0, grid.cells[a] - 1);
    step[axis] = slope > 0 ? 1 : -1;
    if (std::abs(slope) < 1e-12) {
      to_exit_m[axis] = per_cell_m[axis] = kFar;
      continue;
    }
    const double face = grid.origin_m[a] +
                        grid.cell_m * (cell[axis] + (slope > 0 ? 1 : 0)) - ray.origin[a];
    to_exit_m[axis] = face / slope;
    per_cell_m[axis] = grid.cell_m / std::abs(slope);
  }

  // Walk from face to face
  const std::array<std::ptrdiff_t, 3> stride = {
      1, grid.cells.x(), static_cast<std::ptrdiff_t>(grid.cells.x()) * grid.cells.y()};
  auto index = static_cast<std::ptrdiff_t>(grid.Index(cell[0], cell[1], cell[2]));
  double at = enter;
  for (;;) {
    const std::size_t axis = to_exit_m[0] < to_exit_m[1]
                                 ? (to_exit_m[0] < to_exit_m[2] ? 0 : 2)
                                 : (to_exit_m[1] < to_exit_m[2] ? 1 : 2);
    const double exit = std::min(to_exit_m[axis], leave);
    if (exit > at) {
      if (!visit(static_cast<std::size_t>(index), at, exit - at)) return;
      at = exit;
    }
    cell[axis] += step[axis];
    if (cell[axis] < 0 || cell[axis] >= grid.cells[static_cast<Eigen::Index>(axis)])
      return;
    index += step[axis] * stride[axis];
    to_exit_m[axis] += per_cell_m[axis];
  }
}

// Optical depth from `ray.origin` through the grid.
inline double OpticalDepth(const ExtinctionGrid& grid, const Ray& ray) {
  double depth = 0.0;
  TraverseRay(grid, ray, 0.0, [&](std::size_t voxel, double, double length_m) {
    depth += length_m * grid.sigma_per_m[voxel];
    return true;
  });
  return depth;
}

}  // namespace relight
