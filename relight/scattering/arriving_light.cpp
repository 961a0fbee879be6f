// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/arriving_light.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/scattering/transmittance.h"
#include "relight/sh/sky_coefficients.h"

namespace relight {

ArrivingLight LightArriving(const ExtinctionGrid& grid,
                            const OccupiedVoxels& occupied,
                            const SkyTransmittance& sky_transmittance,
                            const Daylight& daylight) {
  const std::size_t voxels = occupied.cell.size();
  Require(!sky_transmittance.coefficients.empty() &&
              sky_transmittance.coefficients.front().size() == voxels,
          "the sky's transmittance belongs to this volume");
  const std::vector<Eigen::Array3f> dark(voxels, Eigen::Array3f::Zero());
  ArrivingLight light{dark, dark, dark};

  // The sun, attenuated on its way in
  if ((daylight.sun_irradiance > 0).any()) {
    const std::vector<float> tau =
        TransmittanceAlong(grid, occupied, daylight.sun_direction);
    const Eigen::Array3f sun = daylight.sun_irradiance.cast<float>();
    for (std::size_t v = 0; v < voxels; ++v) light.sun[v] = sun * tau[v];
  }

  // The sky: sum_lm L_lm c_lm [Cabral11, Eq. 17]
  const ShCoefficients sky = SkyCoefficients(daylight, sky_transmittance.bands);
  ParallelRanges(static_cast<int>(voxels), 4096, [&](int begin, int end) {
    for (Eigen::Index i = 0; i < sky.rows(); ++i) {
      const std::vector<float>& c =
          sky_transmittance.coefficients[static_cast<std::size_t>(i)];
      const Eigen::Array3f radiance = sky.row(i).transpose().array().cast<float>();
      for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end);
           ++v) {
        light.sky[v] += radiance * c[v];
      }
    }
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end);
         ++v) {
      light.sky[v] = light.sky[v].max(0.0f);
    }
  });
  return light;
}

}  // namespace relight
