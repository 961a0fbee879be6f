// SPDX-License-Identifier: Apache-2.0
#pragma once

// The voxels a ray crosses, in order, and the exact length in each, after [Amanatides87]
// (docs/bibliography.md#amanatides87).

#include "relight/cameras/camera.h"
#include "relight/volume/extinction_grid.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace relight {

// Calls visit(index of the value, entry [m from the ray's origin], length [m]) for each
// voxel from `start_m` on that is in a brick; visit answers false to stop. Voxels of no
// length are passed over. Where all of the box is in bricks, the sum of the lengths is
// the length of the ray inside the box.
template <class Visit>
void TraverseRay(const BrickVoxels& voxels,
                 const Ray& ray,
                 double start_m,
                 Visit&& visit) {
  constexpr double kFar = std::numeric_limits<double>::infinity();

  // Enter and leave the box, slab by slab
  double enter = start_m, leave = kFar;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = voxels.origin_m[axis] - ray.origin[axis];
    const double high = low + voxels.cell_m * voxels.cells[axis];
    const double slope = ray.direction[axis];
    if (std::abs(slope) < 1e-12) {
      if (low > 0 || high < 0) return;
      continue;
    }
    enter = std::max(enter, std::min(low / slope, high / slope));
    leave = std::min(leave, std::max(low / slope, high / slope));
  }
  if (!(enter < leave)) return;

  // First voxel, and where its faces are. An axis has its numbers apart from the others',
  // so that all of them stay in registers
  struct Axis {
    double to_exit_m = kFar;   // Ray parameter of the next face
    double per_cell_m = kFar;  // From one face to the next
    int cell = 0, step = 1, cells = 0;
    int edge = 0;               // The cell that is no more in this brick, or in the box
    std::ptrdiff_t stride = 0;  // Of values in a brick
  };
  const auto start = [&](int axis) {
    Axis a;
    const double slope = ray.direction[axis];
    const double at =
        (ray.origin[axis] + enter * slope - voxels.origin_m[axis]) / voxels.cell_m;
    a.cells = voxels.cells[axis];
    a.cell = std::clamp(static_cast<int>(std::floor(at)), 0, a.cells - 1);
    a.step = slope > 0 ? 1 : -1;
    a.edge = slope > 0 ? std::min((a.cell | 7) + 1, a.cells) : (a.cell & ~7) - 1;
    a.stride = a.step * (std::ptrdiff_t{1} << 3 * axis);
    if (std::abs(slope) < 1e-12) return a;
    const double face = voxels.origin_m[axis] +
                        voxels.cell_m * (a.cell + (slope > 0 ? 1 : 0)) - ray.origin[axis];
    a.to_exit_m = face / slope;
    a.per_cell_m = voxels.cell_m / std::abs(slope);
    return a;
  };
  Axis x = start(0), y = start(1), z = start(2);

  // Walk from face to face
  const auto index_here = [&] {
    return static_cast<std::ptrdiff_t>(voxels.BrickOf(x.cell, y.cell, z.cell)) *
               BrickVoxels::kPerBrick +
           BrickVoxels::Local(x.cell, y.cell, z.cell);
  };
  std::ptrdiff_t index = index_here();  // Below 0 where there is no brick
  double at = enter;
  const auto goes_on = [&](Axis& a) {
    const double exit = std::min(a.to_exit_m, leave);
    if (exit > at) {
      if (index >= 0 && !visit(static_cast<std::size_t>(index), at, exit - at)) {
        return false;
      }
      at = exit;
    }
    a.to_exit_m += a.per_cell_m;
    a.cell += a.step;
    index += a.stride;
    if (a.cell != a.edge) return true;
    if (a.cell < 0 || a.cell >= a.cells) return false;
    a.edge = a.step > 0 ? std::min(a.cell + BrickVoxels::kEdge, a.cells)
                        : a.cell - BrickVoxels::kEdge;
    index = index_here();
    return true;
  };
  for (bool on = true; on;) {
    if (x.to_exit_m < y.to_exit_m && x.to_exit_m < z.to_exit_m) {
      on = goes_on(x);
    } else if (y.to_exit_m < z.to_exit_m) {
      on = goes_on(y);
    } else {
      on = goes_on(z);
    }
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
