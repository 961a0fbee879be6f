// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/densification.h"

#include <array>

namespace relight {

std::size_t Densify(ExtinctionGrid& grid) {
  const ExtinctionGrid before = grid;
  const auto sigma_at = [&](const Eigen::Vector3i& at) {
    const bool inside =
        (at.array() >= 0).all() && (at.array() < grid.cells.array()).all();
    return inside ? before.sigma_per_m[before.Index(at.x(), at.y(), at.z())] : 0.0f;
  };
  std::vector<float> sum(grid.Count(), 0.0f);
  std::vector<int> givers(grid.Count(), 0);
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
      const bool inside =
          (at.array() >= 0).all() && (at.array() < grid.cells.array()).all();
      if (!inside || sigma_at(at) > 0) continue;
      const std::size_t index = grid.Index(at.x(), at.y(), at.z());
      sum[index] += total / static_cast<float>(present);
      ++givers[index];
    }
  }
  std::size_t filled = 0;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    if (givers[i] == 0) continue;
    grid.sigma_per_m[i] = sum[i] / static_cast<float>(givers[i]);
    ++filled;
  }
  return filled;
}

}  // namespace relight
