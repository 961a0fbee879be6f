// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/extinction_grid.h"

#include "relight/base/error.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace relight {

void ExtinctionGrid::Set(int x, int y, int z, float sigma) {
  Require(Contains(x, y, z), "a voxel of the box");
  if (sigma == 0 && BrickOf(x, y, z) < 0) return;
  const std::size_t index = Make(x, y, z);
  if (sigma_per_m.size() < Size()) sigma_per_m.resize(Size(), 0.0f);
  sigma_per_m[index] = sigma;
}

void ExtinctionGrid::DropEmptyBricks() {
  std::size_t kept = 0;
  for (std::size_t b = 0; b < brick_at.size(); ++b) {
    const auto from = sigma_per_m.begin() + static_cast<std::ptrdiff_t>(b * kPerBrick);
    const bool empty =
        std::all_of(from, from + kPerBrick, [](float sigma) { return sigma == 0; });
    const Eigen::Vector3i& at = brick_at[b];
    brick_of[PlaceOf(at.x() >> 3, at.y() >> 3, at.z() >> 3)] =
        empty ? -1 : static_cast<std::int32_t>(kept);
    if (empty) continue;
    std::copy_n(from,
                kPerBrick,
                sigma_per_m.begin() + static_cast<std::ptrdiff_t>(kept * kPerBrick));
    brick_at[kept++] = at;
  }
  brick_at.resize(kept);
  sigma_per_m.resize(Size());
  brick_at.shrink_to_fit();
  sigma_per_m.shrink_to_fit();
}

std::size_t ExtinctionGrid::Bytes() const {
  return BrickVoxels::Bytes() + sigma_per_m.capacity() * sizeof(float);
}

std::size_t OccupiedVoxels::Bytes() const {
  return of_cell.capacity() * sizeof(of_cell[0]) + cell.capacity() * sizeof(cell[0]);
}

ExtinctionGrid EmptyGrid(const Eigen::AlignedBox3d& bounds_in_world, int cells_longest) {
  if (cells_longest < 1 || cells_longest > 1024) {
    throw OptionError("cells must be 1 to 1024, got " + std::to_string(cells_longest));
  }
  const Eigen::Vector3d size_m = bounds_in_world.sizes();
  if (bounds_in_world.isEmpty() || !size_m.allFinite() || size_m.minCoeff() <= 0) {
    throw OptionError("the volume's box is empty or not finite");
  }
  const double cell_m = size_m.maxCoeff() / cells_longest;
  Eigen::Vector3i cells;
  for (int axis = 0; axis < 3; ++axis) {
    // A hair less than the quotient, so that a side of just n voxels gets n
    cells[axis] = std::max(1, static_cast<int>(std::ceil(size_m[axis] / cell_m - 1e-6)));
  }
  return {NoBricks(cells, bounds_in_world.min(), cell_m), {}};
}

OccupiedVoxels FindOccupied(const ExtinctionGrid& grid) {
  OccupiedVoxels occupied;
  occupied.of_cell.assign(grid.Size(), -1);
  const auto count = std::count_if(grid.sigma_per_m.begin(),
                                   grid.sigma_per_m.end(),
                                   [](float sigma) { return sigma > 0; });
  occupied.cell.reserve(static_cast<std::size_t>(count));
  ForEachVoxel(grid, [&](int x, int y, int z, std::size_t index) {
    if (grid.sigma_per_m[index] <= 0) return;
    occupied.of_cell[index] = static_cast<int>(occupied.cell.size());
    occupied.cell.emplace_back(x, y, z);
  });
  return occupied;
}

}  // namespace relight
