// SPDX-License-Identifier: Apache-2.0
#pragma once

// A sun where a test wants it.

#include "relight/base/angles.h"
#include "relight/sky/daylight.h"
#include "relight/sky/solar_position.h"

namespace relight::tests {

inline SolarPosition SunAt(double azimuth_deg, double elevation_deg) {
  SolarPosition sun;
  sun.azimuth_rad = RadFromDeg(azimuth_deg);
  sun.elevation_rad = RadFromDeg(elevation_deg);
  sun.direction = DirectionFromAzimuthElevation(sun.azimuth_rad, sun.elevation_rad);
  return sun;
}

inline Daylight DaylightAt(double azimuth_deg,
                           double elevation_deg,
                           const DaylightOptions& options = {}) {
  return MakeDaylight(SunAt(azimuth_deg, elevation_deg), options);
}

}  // namespace relight::tests
