// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/hot_spot.h"

#include "relight/base/parallel.h"

#include <algorithm>
#include <cmath>

namespace relight {

void AddHotSpot(const ExtinctionGrid& grid,
                const OccupiedVoxels& occupied,
                const Daylight& daylight,
                const Eigen::Vector3d& eye,
                double gap_length_m,
                ArrivingLight& light) {
  if (gap_length_m <= 0 || !(daylight.sun_irradiance > 0).any()) return;
  const Eigen::Array3f sun = daylight.sun_irradiance.cast<float>();
  ParallelRanges(static_cast<int>(occupied.cell.size()), 4096, [&](int begin, int end) {
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end);
         ++v) {
      const Eigen::Vector3i& at = occupied.cell[v];
      const double sigma = grid.sigma_per_m[grid.Index(at.x(), at.y(), at.z())];
      const Eigen::Vector3d to_eye =
          (eye - grid.Center(at.x(), at.y(), at.z())).normalized();
      const double apart = (to_eye - daylight.sun_direction).norm();
      // 30 is more than any way through a tree takes
      const double shared = std::min(30.0, sigma * gap_length_m / std::max(apart, 1e-6));
      light.sun[v] = (light.sun[v] * static_cast<float>(std::exp(shared))).min(sun);
    }
  });
}

}  // namespace relight
