// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/solar_position.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"

#include <erfa.h>

#include <chrono>
#include <sstream>

namespace relight {
namespace {

constexpr double kUnixEpochJd = 2440587.5;
constexpr double kSecondsPerDay = 86400.0;

// A Julian date in two parts, as ERFA wants it: midnight, and the fraction of the day.
struct JulianDate {
  double day = 0.0;
  double fraction = 0.0;
};

JulianDate JulianDateOf(Instant instant) {
  const auto midnight = std::chrono::floor<std::chrono::days>(instant);
  const std::chrono::duration<double> since_midnight = instant - midnight;
  return {kUnixEpochJd + midnight.time_since_epoch().count(),
          since_midnight.count() / kSecondsPerDay};
}

void CheckYear(Instant instant) {
  const std::chrono::year_month_day date(std::chrono::floor<std::chrono::days>(instant));
  const int year = static_cast<int>(date.year());
  if (year >= 1900 && year <= 2099) return;
  std::ostringstream text;
  text
      << "the year " << year
      << " is outside 1900 to 2099, for which the sun's place is known; correct the date";
  throw InputError(text.str());
}

void CheckPlace(const Place& place) {
  const bool on_earth = std::abs(place.latitude_deg) <= 90.0 &&
                        std::abs(place.longitude_deg) <= 180.0 &&
                        std::abs(place.altitude_m) <= 1e5;
  if (on_earth) return;  // Written so that NaN is refused too
  std::ostringstream text;
  text << "the place " << place.latitude_deg << "," << place.longitude_deg << " at "
       << place.altitude_m
       << " m is not on earth; give latitude -90 to 90 and longitude -180 to 180 degrees";
  throw InputError(text.str());
}

// TT of an instant that is UT1 (delta_t given) or UTC.
JulianDate TerrestrialTime(const JulianDate& clock, const SolarOptions& options) {
  if (options.delta_t_s.has_value()) {
    return {clock.day, clock.fraction + *options.delta_t_s / kSecondsPerDay};
  }
  JulianDate tai, tt;
  const int status = eraUtctai(clock.day, clock.fraction, &tai.day, &tai.fraction);
  Require(status >= 0, "a checked year has a count of leap seconds");
  eraTaitt(tai.day, tai.fraction, &tt.day, &tt.fraction);
  return tt;
}

}  // namespace

SolarPosition SolarPositionAt(Instant instant,
                              const Place& place,
                              const SolarOptions& options) {
  CheckYear(instant);
  CheckPlace(place);
  CheckFields(options);
  const JulianDate ut1 = JulianDateOf(instant);
  const JulianDate tt = TerrestrialTime(ut1, options);

  // Earth about the sun and about the barycentre [au]; TDB - TT < 2 ms is left out
  double earth_from_sun[2][3], earth_from_barycentre[2][3];
  eraEpv00(tt.day, tt.fraction, earth_from_sun, earth_from_barycentre);

  // The observer: precession and nutation, earth rotation, place on the ellipsoid
  double precession_nutation[3][3], x, y;
  eraPnm06a(tt.day, tt.fraction, precession_nutation);
  eraBpn2xy(precession_nutation, &x, &y);
  const double cio_locator = eraS06(tt.day, tt.fraction, x, y);
  const double rotation_angle = eraEra00(ut1.day, ut1.fraction);
  eraASTROM observer;
  eraApco(tt.day,
          tt.fraction,
          earth_from_barycentre,
          earth_from_sun[0],
          x,
          y,
          cio_locator,
          rotation_angle,
          RadFromDeg(place.longitude_deg),
          RadFromDeg(place.latitude_deg),
          place.altitude_m,
          0.0,
          0.0,
          eraSp00(tt.day, tt.fraction),
          0.0,
          0.0,
          &observer);

  // Sun from the observer, then aberration (K1)
  double sun_from_observer[3], distance_au, natural[3], proper[3];
  for (int i = 0; i < 3; ++i) {
    const double sun = earth_from_barycentre[0][i] - earth_from_sun[0][i];
    sun_from_observer[i] = sun - observer.eb[i];
  }
  eraPn(sun_from_observer, &distance_au, natural);
  eraAb(natural, observer.v, distance_au, observer.bm1, proper);

  // Frame of date, then the observer's horizon (K2)
  double of_date[3], ra_rad, dec_rad;
  eraRxp(observer.bpn, proper, of_date);
  eraC2s(of_date, &ra_rad, &dec_rad);
  double azimuth_rad, zenith_rad, hour_angle_rad, observed_dec_rad, observed_ra_rad;
  eraAtioq(eraAnp(ra_rad),
           dec_rad,
           &observer,
           &azimuth_rad,
           &zenith_rad,
           &hour_angle_rad,
           &observed_dec_rad,
           &observed_ra_rad);

  const double elevation_rad = std::numbers::pi / 2 - zenith_rad;
  return {.azimuth_rad = azimuth_rad,
          .elevation_rad = elevation_rad,
          .direction = DirectionFromAzimuthElevation(azimuth_rad, elevation_rad)};
}

}  // namespace relight
