// SPDX-License-Identifier: Apache-2.0
#include "relight/sh/sky_coefficients.h"

#include <algorithm>

namespace relight {

// L_lm = integral of L_sky(omega) Y_lm(omega) d omega                           (H7)
ShCoefficients SkyCoefficients(const Daylight& daylight, int bands) {
  return ProjectColorOnSh(
      [&](const Eigen::Vector3d& direction) { return daylight.SkyRadiance(direction); },
      bands);
}

// E_h = integral of L_sky(omega) max(0, omega_z) d omega                        (H8)
Eigen::Array3d HorizontalSkyIrradiance(const Daylight& daylight) {
  Eigen::Array3d irradiance = Eigen::Array3d::Zero();
  for (const auto& [direction, weight_sr] : SphereQuadrature()) {
    irradiance +=
        weight_sr * std::max(0.0, direction.z()) * daylight.SkyRadiance(direction);
  }
  return irradiance;
}

}  // namespace relight
