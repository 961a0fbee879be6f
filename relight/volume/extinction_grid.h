// SPDX-License-Identifier: Apache-2.0
#pragma once

// Extinction of the tree's volume on a regular grid of cubic voxels: sigma [1/m],
// constant in each voxel (docs/conventions.md#world). Stored instead of [Reche04]'s
// opacity per cell, so that it keeps its meaning when the voxel size changes
// (docs/decisions/0001):
//
//   t = exp(-sigma * cell_m),   sigma = -ln(1 - alpha) / cell_m           (V1)

#include "relight/volume/brick_voxels.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

namespace relight {

// 0 where there is no brick, so that memory grows with what is occupied, not with the
// box.
struct ExtinctionGrid : BrickVoxels {
  std::vector<float> sigma_per_m;  // Size() of them, all >= 0.

  // Of any voxel, 0 outside the box as well.
  float At(int x, int y, int z) const {
    const std::ptrdiff_t index = Find(x, y, z);
    return index < 0 ? 0.0f : sigma_per_m[static_cast<std::size_t>(index)];
  }
  // Throws std::logic_error outside the box.
  void Set(int x, int y, int z, float sigma);
  // Adds to what is there.
  void Add(int x, int y, int z, float sigma) { Set(x, y, z, At(x, y, z) + sigma); }
  // Gives back what bricks without any extinction take.
  void DropEmptyBricks();
  // Of memory.
  std::size_t Bytes() const;
};

// An empty grid that covers `bounds_in_world`: `cells_longest` voxels along its longest
// side, as many whole voxels as needed along the others. Throws OptionError outside
// 1 … 1024 voxels or for an empty box.
ExtinctionGrid EmptyGrid(const Eigen::AlignedBox3d& bounds_in_world, int cells_longest);

// The non-empty voxels of a grid, in the order of its box: x fastest, then y, then z.
struct OccupiedVoxels {
  std::vector<int> of_cell;  // Per value of the grid: its number here, or -1.
  std::vector<Eigen::Vector3i> cell;

  std::size_t Bytes() const;  // Of memory.
};
OccupiedVoxels FindOccupied(const ExtinctionGrid& grid);

}  // namespace relight
