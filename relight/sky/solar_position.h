// SPDX-License-Identifier: Apache-2.0
#pragma once

// Direction to the centre of the sun, topocentric and true (no refraction).
//
//   [ERFA] docs/bibliography.md#erfa   IAU 2006/2000A precession and nutation, epv00
//
// p_sun  = unit(sun - observer), barycentric, and turned by the annual and diurnal
//          aberration of the moving observer                               (K1)
// (az, z) = (p_sun in the true frame of date) turned by the earth rotation angle
//          to the observer's meridian and horizon                          (K2)
//
// Time: UT1 turns the earth, TT moves it about the sun, delta_t = TT - UT1. Without
// delta_t we set UT1 = UTC, which leap seconds keep within 0.9 s: at most 0.9 s x 15
// arcsec/s = 0.00375 degrees of azimuth on the equator of the sky, a hundredth of the
// sun's width. Polar motion (0.0001 degrees) is left out.

#include "relight/base/field.h"
#include "relight/base/instant.h"

#include <Eigen/Core>

#include <optional>

namespace relight {

struct SolarOptions {
  // TT - UT1. When given, the instant is read as UT1; else as UTC, with UT1 = UTC.
  std::optional<double> delta_t_s = {};
};

template <class Visitor>
void Describe(SolarOptions& o, Visitor&& field) {
  field(o.delta_t_s, {"delta-t", "s", "TT - UT1; left out, UT1 is taken as UTC"});
}

struct SolarPosition {
  double azimuth_rad = 0.0;    // Clockwise from true north, [0, 2 pi).
  double elevation_rad = 0.0;  // Of the centre, above the horizon; negative at night.
  Eigen::Vector3d direction;   // The same as a unit vector, ENU.
};

// Throws InputError for a year outside 1900 to 2099 and a place that is not on earth.
SolarPosition SolarPositionAt(Instant instant,
                              const Place& place,
                              const SolarOptions& options = {});

}  // namespace relight
