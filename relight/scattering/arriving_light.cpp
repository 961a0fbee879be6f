// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/arriving_light.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/scattering/transmittance.h"
#include "relight/sh/sky_coefficients.h"

#include <cmath>

namespace relight {
namespace {

constexpr double kSunRadius_rad = 0.004652;  // Seen from the earth's mean distance

// tau(u, w_sun), of the centre or as the mean over the disc.                    (S2)
std::vector<float> SunTransmittance(const ExtinctionGrid& grid,
                                    const OccupiedVoxels& occupied,
                                    const Eigen::Vector3d& sun,
                                    int directions) {
  if (directions == 1) return TransmittanceAlong(grid, occupied, sun);
  // a is level, so that the pattern goes along with the sun without a turn
  const bool zenith = sun.head<2>().norm() < 1e-9;
  const Eigen::Vector3d a =
      zenith ? Eigen::Vector3d(Eigen::Vector3d::UnitX())
             : Eigen::Vector3d(Eigen::Vector3d::UnitZ().cross(sun).normalized());
  const Eigen::Vector3d b = sun.cross(a);
  constexpr double kGolden_rad = 2.399963229728653;  // pi (3 - sqrt 5)
  const RowExtents rows = FindRowExtents(grid);
  std::vector<float> mean(occupied.cell.size(), 0.0f);
  for (int i = 0; i < directions; ++i) {
    const double radius = std::tan(kSunRadius_rad) * std::sqrt((i + 0.5) / directions);
    const double turn_rad = i * kGolden_rad;
    const Eigen::Vector3d direction =
        sun + radius * (std::cos(turn_rad) * a + std::sin(turn_rad) * b);
    const std::vector<float> tau =
        TransmittanceAlong(grid, occupied, rows, direction.normalized());
    const float share = 1.0f / static_cast<float>(directions);
    for (std::size_t v = 0; v < mean.size(); ++v) mean[v] += share * tau[v];
  }
  return mean;
}

}  // namespace

ArrivingLight LightArriving(const ExtinctionGrid& grid,
                            const OccupiedVoxels& occupied,
                            const SkyTransmittance& sky_transmittance,
                            const Daylight& daylight,
                            const ArrivingLightOptions& options) {
  CheckFields(options);
  const std::size_t voxels = occupied.cell.size();
  Require(!sky_transmittance.coefficients.empty() &&
              sky_transmittance.coefficients.front().size() == voxels,
          "the sky's transmittance belongs to this volume");
  const std::vector<Eigen::Array3f> dark(voxels, Eigen::Array3f::Zero());
  ArrivingLight light{dark, dark, dark};

  // The sun, attenuated on its way in
  if ((daylight.sun_irradiance > 0).any()) {
    const std::vector<float> tau =
        SunTransmittance(grid, occupied, daylight.sun_direction, options.sun_directions);
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
