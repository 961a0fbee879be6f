// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/arriving_light.h"

#include "relight/base/error.h"
#include "relight/base/parallel.h"
#include "relight/scattering/sweep_kernels.h"
#include "relight/scattering/transmittance.h"
#include "relight/sh/sky_coefficients.h"

#include <algorithm>
#include <cmath>

namespace relight {
namespace {

static_assert(sizeof(Eigen::Array3f) == 3 * sizeof(float), "colours lie side by side");

constexpr double kSunRadius_rad = 0.004652;  // Seen from the earth's mean distance

// To the sun's centre, or over its disc.                                        (S2)
std::vector<Eigen::Vector3d> OverDisc(const Eigen::Vector3d& sun, int directions) {
  if (directions == 1) return {sun};
  // a is level, so that the pattern goes along with the sun without a turn
  const bool zenith = sun.head<2>().norm() < 1e-9;
  const Eigen::Vector3d a =
      zenith ? Eigen::Vector3d(Eigen::Vector3d::UnitX())
             : Eigen::Vector3d(Eigen::Vector3d::UnitZ().cross(sun).normalized());
  const Eigen::Vector3d b = sun.cross(a);
  constexpr double kGolden_rad = 2.399963229728653;  // pi (3 - sqrt 5)
  std::vector<Eigen::Vector3d> disc;
  for (int i = 0; i < directions; ++i) {
    const double radius = std::tan(kSunRadius_rad) * std::sqrt((i + 0.5) / directions);
    const double turn_rad = i * kGolden_rad;
    const Eigen::Vector3d direction =
        sun + radius * (std::cos(turn_rad) * a + std::sin(turn_rad) * b);
    disc.push_back(direction.normalized());
  }
  return disc;
}

}  // namespace

double TransmittanceOfDepth(double depth, double clumping) {
  if (clumping <= 0) return std::exp(-depth);
  return std::pow(1 + clumping * depth, -1 / clumping);
}

std::vector<float> SunTransmittance(const ExtinctionGrid& grid,
                                    const OccupiedVoxels& occupied,
                                    const Eigen::Vector3d& sun_direction,
                                    const ArrivingLightOptions& options,
                                    const Occluder* occluder) {
  CheckFields(options);
  const std::vector<Eigen::Vector3d> disc =
      OverDisc(sun_direction, options.sun_directions);
  std::vector<float> tau = MeanTransmittanceAlong(grid, occupied, disc);
  if (options.own_shade < 1) {  // (S3)
    const double half_m = grid.cell_m / 2 / sun_direction.cwiseAbs().maxCoeff();
    for (std::size_t v = 0; v < tau.size(); ++v) {
      const Eigen::Vector3i& at = occupied.cell[v];
      const double sigma = grid.sigma_per_m[grid.Index(at.x(), at.y(), at.z())];
      const double own = std::exp((1 - options.own_shade) * half_m * sigma);
      tau[v] = std::min(1.0f, tau[v] * static_cast<float>(own));
    }
  }
  if (options.clumping > 0) {
    for (float& t : tau) {
      t = static_cast<float>(TransmittanceOfDepth(-std::log(t), options.clumping));
    }
  }
  if (occluder == nullptr || occluder->empty()) return tau;
  constexpr int kVoxels = 1024;  // A task
  ParallelRanges(static_cast<int>(tau.size()), kVoxels, [&](int begin, int end) {
    for (auto v = static_cast<std::size_t>(begin); v < static_cast<std::size_t>(end);
         ++v) {
      const Eigen::Vector3i& at = occupied.cell[v];
      const Eigen::Vector3d center = grid.Center(at.x(), at.y(), at.z());
      double left = 0;
      for (const Eigen::Vector3d& direction : disc) {
        left += occluder->Transmittance(center, direction);
      }
      tau[v] *= static_cast<float>(left / static_cast<double>(disc.size()));
    }
  });
  return tau;
}

// sum_lm L_lm c_lm(u)                                             [Cabral11, Eq. 17]
std::vector<Eigen::Array3f> SkyLight(const SkyTransmittance& sky_transmittance,
                                     const ShCoefficients& sky) {
  const std::size_t voxels = sky_transmittance.voxels;
  std::vector<Eigen::Array3f> light(voxels);
  const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> radiance =
      sky.cast<float>();
  ParallelRanges(static_cast<int>(voxels), 4096, [&](int begin, int end) {
    ColorProduct(sky_transmittance.half.data() + begin,
                 voxels,
                 radiance.data(),
                 static_cast<std::size_t>(radiance.rows()),
                 light[static_cast<std::size_t>(begin)].data(),
                 static_cast<std::size_t>(end - begin));
  });
  return light;
}

ArrivingLight LightArriving(const ExtinctionGrid& grid,
                            const OccupiedVoxels& occupied,
                            const SkyTransmittance& sky_transmittance,
                            const Daylight& daylight,
                            const ArrivingLightOptions& options,
                            const Occluder* occluder) {
  CheckFields(options);
  const std::size_t voxels = occupied.cell.size();
  Require(sky_transmittance.bands > 0 && sky_transmittance.voxels == voxels,
          "the sky's transmittance belongs to this volume");
  const std::vector<Eigen::Array3f> dark(voxels, Eigen::Array3f::Zero());
  ArrivingLight light{dark, {}, dark};

  // The sun, attenuated on its way in
  if ((daylight.sun_irradiance > 0).any()) {
    const std::vector<float> tau =
        SunTransmittance(grid, occupied, daylight.sun_direction, options, occluder);
    const Eigen::Array3f sun = daylight.sun_irradiance.cast<float>();
    for (std::size_t v = 0; v < voxels; ++v) light.sun[v] = sun * tau[v];
  }

  light.sky =
      SkyLight(sky_transmittance, SkyCoefficients(daylight, sky_transmittance.bands));
  return light;
}

}  // namespace relight
