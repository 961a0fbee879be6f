// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/densification.h"

#include <array>

namespace relight {

std::size_t Densify(ExtinctionGrid& grid) {
  const ExtinctionGrid before = grid;
  const auto sigma_at = [&](const Eigen::Vector3i& at) {
    return before.At(at.x(), at.y(), at.z());
  };
  BrickVoxels given = NoBricks(grid.cells, grid.origin_m, grid.cell_m);
  std::vector<float> sum;
  std::vector<int> givers;
  for (const Eigen::Vector3i& center : FindOccupied(before).cell) {
    // Count the neighbours
    int neighbours = -1;  // The voxel itself is met too
    for (int dz = -1; dz <= 1; ++dz) {
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          neighbours += sigma_at(center + Eigen::Vector3i(dx, dy, dz)) > 0;
        }
      }
    }
    if (neighbours >= 8) continue;

    // Mean of the axial ones that are there, for those that are not
    std::array<Eigen::Vector3i, 6> axial;
    float total = 0.0f;
    int present = 0;
    for (std::size_t side = 0; side < 6; ++side) {
      axial[side] = center;
      axial[side][static_cast<Eigen::Index>(side / 2)] += side % 2 == 0 ? 1 : -1;
      const float sigma = sigma_at(axial[side]);
      total += sigma;
      present += sigma > 0;
    }
    if (present == 0) continue;
    for (const Eigen::Vector3i& at : axial) {
      if (!grid.Contains(at.x(), at.y(), at.z()) || sigma_at(at) > 0) continue;
      const std::size_t index = given.Make(at.x(), at.y(), at.z());
      sum.resize(given.Size(), 0.0f);
      givers.resize(given.Size(), 0);
      sum[index] += total / static_cast<float>(present);
      ++givers[index];
    }
  }
  std::size_t filled = 0;
  ForEachVoxel(given, [&](int x, int y, int z, std::size_t index) {
    if (givers[index] == 0) return;
    grid.Set(x, y, z, sum[index] / static_cast<float>(givers[index]));
    ++filled;
  });
  return filled;
}

}  // namespace relight
