// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/air_mass.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <cmath>
#include <numbers>
#include <sstream>

namespace relight {

// m(z) = 1 / (cos z + 0.50572 (96.07995 - z)^-1.6364)                 [KastenYoung89]
double AirMass(double zenith_rad) {
  const double z_deg = DegFromRad(zenith_rad);
  if (!(z_deg >= 0.0 && z_deg <= 91.0)) {
    std::ostringstream text;
    text << "the sun " << z_deg
         << " degrees from the zenith has no air mass, which ends at 91; choose an hour "
            "between sunrise and sunset";
    throw InputError(text.str());
  }
  return 1.0 / (std::cos(zenith_rad) + 0.50572 * std::pow(96.07995 - z_deg, -1.6364));
}

double AirMassOfSun(const Eigen::Vector3d& sun_in_world) {
  const double elevation_rad = ElevationOf(sun_in_world);
  if (!(elevation_rad > 0.0)) {
    std::ostringstream text;
    text << "the sun is at " << DegFromRad(elevation_rad)
         << " degrees and gives no light; choose an hour between sunrise and sunset";
    throw InputError(text.str());
  }
  return AirMass(std::numbers::pi / 2 - elevation_rad);
}

}  // namespace relight
