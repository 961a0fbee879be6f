// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/ground_bounce.h"

#include "relight/scattering/swept_transmittance.h"
#include "relight/sh/quadrature.h"

#include <cmath>
#include <limits>
#include <numbers>

namespace relight {

std::vector<Eigen::Array3f> GroundBounce(const ExtinctionGrid& grid,
                                         const OccupiedVoxels& occupied,
                                         const Eigen::Array3d& unshadowed,
                                         const ShareOfGroundLight& share,
                                         double ground_z_m) {
  constexpr int kDirections = 128;  // Half of them down
  std::vector<Eigen::Vector3d> down;
  for (const Eigen::Vector3d& direction : SphereDirections(kDirections)) {
    if (direction.z() < 0) down.push_back(direction);
  }
  const std::vector<float> weight_sr(
      down.size(), static_cast<float>(4 * std::numbers::pi / kDirections));
  std::vector<Eigen::Array3f> light(occupied.cell.size());
  for (int c = 0; c < 3; ++c) {
    // w tau s = w exp(-(D - ln s)): the ground's shade is one more depth on the way
    const FurtherDepth shade = [&](const Eigen::Vector3d& d, std::span<float> depth) {
      for (std::size_t v = 0; v < depth.size(); ++v) {
        const Eigen::Vector3i& at = occupied.cell[v];
        const Eigen::Vector3d center = grid.Center(at.x(), at.y(), at.z());
        const double above_m = center.z() - ground_z_m;
        depth[v] += above_m <= 0
                        ? std::numeric_limits<float>::infinity()
                        : -std::log(share((center - above_m / d.z() * d).head<2>())[c]);
      }
    };
    const std::vector<float> sent =
        ProjectSwept(grid, occupied, down, weight_sr, {}, shade).front();
    for (std::size_t v = 0; v < light.size(); ++v) {
      light[v][c] = static_cast<float>(unshadowed[c]) * sent[v];
    }
  }
  return light;
}

}  // namespace relight
