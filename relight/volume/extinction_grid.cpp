// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/extinction_grid.h"

#include "relight/base/error.h"

#include <cmath>
#include <string>

namespace relight {

ExtinctionGrid EmptyGrid(const Eigen::AlignedBox3d& bounds_in_world, int cells_longest) {
  if (cells_longest < 1 || cells_longest > 1024) {
    throw OptionError("cells must be 1 to 1024, got " + std::to_string(cells_longest));
  }
  const Eigen::Vector3d size_m = bounds_in_world.sizes();
  if (bounds_in_world.isEmpty() || !size_m.allFinite() || size_m.minCoeff() <= 0) {
    throw OptionError("the volume's box is empty or not finite");
  }
  ExtinctionGrid grid;
  grid.origin_m = bounds_in_world.min();
  grid.cell_m = size_m.maxCoeff() / cells_longest;
  for (int axis = 0; axis < 3; ++axis) {
    // A hair less than the quotient, so that a side of just n voxels gets n
    grid.cells[axis] =
        std::max(1, static_cast<int>(std::ceil(size_m[axis] / grid.cell_m - 1e-6)));
  }
  grid.sigma_per_m.assign(grid.Count(), 0.0f);
  return grid;
}

OccupiedVoxels FindOccupied(const ExtinctionGrid& grid) {
  OccupiedVoxels occupied;
  occupied.of_cell.assign(grid.Count(), -1);
  std::size_t index = 0;
  for (int z = 0; z < grid.cells.z(); ++z) {
    for (int y = 0; y < grid.cells.y(); ++y) {
      for (int x = 0; x < grid.cells.x(); ++x, ++index) {
        if (grid.sigma_per_m[index] <= 0) continue;
        occupied.of_cell[index] = static_cast<int>(occupied.cell.size());
        occupied.cell.emplace_back(x, y, z);
      }
    }
  }
  return occupied;
}

}  // namespace relight
