// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/cabral2011_sun.h"

#include "relight/sky/air_mass.h"

namespace relight {

// alpha N_max exp(-beta m^k)                                          [Cabral11, Eq. 10]
Eigen::Array3d Cabral2011SunIrradianceAtAirMass(double air_mass,
                                                const Cabral2011SunOptions& options) {
  const Eigen::Array3d alpha_n_max_lx(135640.0, 124968.0, 128673.0);
  const Eigen::Array3d beta(0.3570, 0.4621, 0.6718);
  const Eigen::Array3d k =
      options.sunset_correction ? Eigen::Array3d(2.5, 2.0, 2.0) : Eigen::Array3d::Ones();
  return alpha_n_max_lx * (-beta * k.unaryExpr([&](double power) {
                            return std::pow(air_mass, power);
                          })).exp();
}

Eigen::Array3d Cabral2011SunIrradiance(const Eigen::Vector3d& sun_in_world,
                                       const Cabral2011SunOptions& options) {
  return Cabral2011SunIrradianceAtAirMass(AirMassOfSun(sun_in_world), options);
}

}  // namespace relight
