// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/leaf_phase.h"

#include "relight/sh/sky_coefficients.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace relight {

double LeafPhase(double cosine, double transmitted_share) {
  using std::numbers::pi;
  const double cos_b = -std::clamp(cosine, -1.0, 1.0);
  const double b = std::acos(cos_b);
  const double p = 8 / (3 * pi) * (std::sin(b) - b * cos_b) +
                   8.0 / 3 * transmitted_share * cos_b;  // (S11)
  return std::max(0.0, p);
}

void ScatterTowards(const Eigen::Vector3d& eye,
                    double transmitted_share,
                    const ExtinctionGrid& grid,
                    const OccupiedVoxels& occupied,
                    const SkyTransmittance& sky_transmittance,
                    const Daylight& daylight,
                    ArrivingLight& light) {
  for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
    const Eigen::Vector3i& at = occupied.cell[v];
    const Eigen::Vector3d to_eye =
        (eye - grid.Center(at.x(), at.y(), at.z())).normalized();
    light.sun[v] *= static_cast<float>(
        LeafPhase(to_eye.dot(daylight.sun_direction), transmitted_share));
  }
  const Eigen::Vector3d to_eye = (eye - grid.Bounds().center()).normalized();
  light.sky = SkyLight(
      sky_transmittance,
      SkyCoefficients(
          daylight, sky_transmittance.bands, [&](const Eigen::Vector3d& direction) {
            return LeafPhase(to_eye.dot(direction), transmitted_share);
          }));
}

}  // namespace relight
