// SPDX-License-Identifier: Apache-2.0
#pragma once

// Extinction of the tree's volume on a regular grid of cubic voxels: sigma [1/m],
// constant in each voxel (docs/conventions.md#world). Stored instead of [Reche04]'s
// opacity per cell, so that it keeps its meaning when the voxel size changes
// (docs/decisions/0001):
//
//   t = exp(-sigma * cell_m),   sigma = -ln(1 - alpha) / cell_m           (V1)

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace relight {

struct ExtinctionGrid {
  Eigen::Vector3i cells = {0, 0, 0};     // Voxels along x, y, z.
  Eigen::Vector3d origin_m = {0, 0, 0};  // Lower corner of voxel (0, 0, 0), ENU.
  double cell_m = 0.0;                   // Edge of a voxel.
  std::vector<float> sigma_per_m;        // x fastest; size cells.prod(), all >= 0.

  std::size_t Count() const {
    return static_cast<std::size_t>(cells.x()) * static_cast<std::size_t>(cells.y()) *
           static_cast<std::size_t>(cells.z());
  }
  std::size_t Index(int x, int y, int z) const {
    return static_cast<std::size_t>(x) +
           static_cast<std::size_t>(cells.x()) *
               (static_cast<std::size_t>(y) +
                static_cast<std::size_t>(cells.y()) * static_cast<std::size_t>(z));
  }
  Eigen::Vector3d Center(int x, int y, int z) const {
    return origin_m + cell_m * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
  }
  Eigen::AlignedBox3d Bounds() const {
    return {origin_m, origin_m + cell_m * cells.cast<double>()};
  }
};

// An empty grid that covers `bounds_in_world`: `cells_longest` voxels along its longest
// side, as many whole voxels as needed along the others. Throws OptionError outside
// 1 … 1024 voxels or for an empty box.
ExtinctionGrid EmptyGrid(const Eigen::AlignedBox3d& bounds_in_world, int cells_longest);

// The non-empty voxels of a grid, in the grid's order.
struct OccupiedVoxels {
  std::vector<int> of_cell;  // Per voxel of the grid: its number here, or -1.
  std::vector<Eigen::Vector3i> cell;
};
OccupiedVoxels FindOccupied(const ExtinctionGrid& grid);

}  // namespace relight
