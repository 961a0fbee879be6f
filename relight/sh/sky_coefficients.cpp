// SPDX-License-Identifier: Apache-2.0
#include "relight/sh/sky_coefficients.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <variant>

namespace relight {
namespace {

// A panorama's pixels, each with its solid angle: all of them count, however few pixels a
// bright cloud has.
template <class Take>
void ForEachPixelOf(const PanoramaSky& sky, const Take& take) {
  const Eigen::AngleAxisd turn(-sky.heading_rad, Eigen::Vector3d::UnitZ());
  const Eigen::Matrix3d world_from_panorama = turn.toRotationMatrix();
  ForEachSkyPixel(sky.panorama->sky,
                  [&](const Eigen::Vector3d& direction,
                      double weight_sr,
                      const Eigen::Array3d& color) {
                    take(world_from_panorama * direction,
                         Eigen::Array3d(weight_sr * sky.cd_per_m2 * color));
                  });
}

}  // namespace

// L_lm = integral of L_sky(omega) Y_lm(omega) d omega                           (H7)
ShCoefficients SkyCoefficients(
    const Daylight& daylight,
    int bands,
    const std::function<double(const Eigen::Vector3d&)>& weight) {
  const auto share = [&](const Eigen::Vector3d& direction) {
    return weight ? weight(direction) : 1.0;
  };
  if (const auto* panorama = std::get_if<PanoramaSky>(&daylight.sky)) {
    ShCoefficients coefficients = ShCoefficients::Zero(ShCount(bands), 3);
    ForEachPixelOf(*panorama,
                   [&](const Eigen::Vector3d& direction, const Eigen::Array3d& color) {
                     coefficients += SphericalHarmonics(direction, bands) *
                                     (share(direction) * color).matrix().transpose();
                   });
    return coefficients;
  }
  return ProjectColorOnSh(
      [&](const Eigen::Vector3d& direction) -> Eigen::Array3d {
        return share(direction) * daylight.SkyRadiance(direction);
      },
      bands);
}

// E_h = integral of L_sky(omega) max(0, omega_z) d omega                        (H8)
Eigen::Array3d HorizontalSkyIrradiance(const Daylight& daylight) {
  Eigen::Array3d irradiance = Eigen::Array3d::Zero();
  if (const auto* panorama = std::get_if<PanoramaSky>(&daylight.sky)) {
    ForEachPixelOf(*panorama,
                   [&](const Eigen::Vector3d& direction, const Eigen::Array3d& color) {
                     irradiance += std::max(0.0, direction.z()) * color;
                   });
    return irradiance;
  }
  for (const auto& [direction, weight_sr] : SphereQuadrature()) {
    irradiance +=
        weight_sr * std::max(0.0, direction.z()) * daylight.SkyRadiance(direction);
  }
  return irradiance;
}

}  // namespace relight
