// SPDX-License-Identifier: Apache-2.0

// Daylight where and when the sun does something else than at home.

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/sky/daylight.h"
#include "relight/sky/sun_times.h"

#include <gtest/gtest.h>

#include <cmath>

namespace relight {
namespace {

using namespace std::chrono;

Instant At(int year, unsigned month_, unsigned day_, double hours_utc) {
  return time_point_cast<milliseconds>(
      sys_days(std::chrono::year(year) / month(month_) / day(day_)) +
      milliseconds(static_cast<long long>(hours_utc * 3600e3)));
}

const Eigen::Vector3d kSomewhere =
    DirectionFromAzimuthElevation(RadFromDeg(310), RadFromDeg(35));

TEST(DaylightOfPlaces, TheSameSunGivesTheSameLight) {
  // A quarter of the Earth apart, six hours later: the sun has gone on by the change of
  // its declination and of the equation of time alone, less than 0.15 degrees in March
  const SolarPosition east = SolarPositionAt(At(2024, 3, 22, 9), {48, 30, 0});
  const SolarPosition west = SolarPositionAt(At(2024, 3, 22, 15), {48, -60, 0});
  EXPECT_LT(DegFromRad(AngleBetween(east.direction, west.direction)), 0.15);
  for (const SkyModel model : {SkyModel::kPreetham, SkyModel::kAtmosphere}) {
    const Daylight a = MakeDaylight(east, {.model = model});
    const Daylight b = MakeDaylight(west, {.model = model});
    // 0.15 degrees of a sun 40 high: 0.3 % of its sine, less of the light
    EXPECT_TRUE(a.sun_irradiance.isApprox(b.sun_irradiance, 3e-3));
    EXPECT_TRUE(a.SkyRadiance(kSomewhere).isApprox(b.SkyRadiance(kSomewhere), 1e-2));
  }
}

TEST(DaylightOfPlaces, TheSouthHasTheNorthsLightFromTheOtherSide) {
  const Place north{48, 0, 0}, south{-48, 0, 0};
  const SunTimes june = SunTimesOf(2024y / June / 20d, north);
  const SunTimes december = SunTimesOf(2024y / December / 21d, south);
  const SolarPosition a = SolarPositionAt(june.noon, north);
  const SolarPosition b = SolarPositionAt(december.noon, south);
  EXPECT_NEAR(DegFromRad(a.azimuth_rad), 180, 0.1);
  EXPECT_NEAR(std::abs(WrapDeg180(DegFromRad(b.azimuth_rad))), 0, 0.1);
  EXPECT_NEAR(DegFromRad(a.elevation_rad), DegFromRad(b.elevation_rad), 0.02);
  const Daylight in_june = MakeDaylight(a), in_december = MakeDaylight(b);
  EXPECT_TRUE(in_june.sun_irradiance.isApprox(in_december.sun_irradiance, 1e-3));
  const Eigen::Vector3d mirrored(kSomewhere.x(), -kSomewhere.y(), kSomewhere.z());
  EXPECT_TRUE(
      in_june.SkyRadiance(kSomewhere).isApprox(in_december.SkyRadiance(mirrored), 5e-3));
}

TEST(DaylightOfPlaces, ThePolarDayHasLightAllRound) {
  const Place cape{71.2, 25.8, 0};
  const SunTimes times = SunTimesOf(2024y / June / 21d, cape);
  EXPECT_FALSE(times.sunrise.has_value() || times.sunset.has_value());
  double least = 90, most = 0;
  for (int hour = 0; hour < 24; ++hour) {
    const SolarPosition sun = SolarPositionAt(At(2024, 6, 21, hour), cape);
    least = std::min(least, DegFromRad(sun.elevation_rad));
    most = std::max(most, DegFromRad(sun.elevation_rad));
    for (const SkyModel model : {SkyModel::kPreetham, SkyModel::kAtmosphere}) {
      const Daylight day = MakeDaylight(sun, {.model = model});
      EXPECT_TRUE((day.sun_irradiance.isFinite() && day.sun_irradiance >= 0).all());
      EXPECT_GT(day.SkyRadiance({0, 0, 1})[1], 0);
    }
  }
  EXPECT_GT(least, 4);  // 23.4 - (90 - 71.2)
  EXPECT_NEAR(most, 90 - 71.2 + 23.4, 0.5);
}

TEST(DaylightOfPlaces, TheEquatorHasTheSunOverhead) {
  const Place quito{0, -78.5, 0};
  const SunTimes times = SunTimesOf(2024y / March / 20d, quito);
  const SolarPosition sun = SolarPositionAt(times.noon, quito);
  EXPECT_GT(DegFromRad(sun.elevation_rad), 89.5);
  for (const SkyModel model :
       {SkyModel::kPreetham, SkyModel::kCabral2011, SkyModel::kAtmosphere}) {
    const Daylight day = MakeDaylight(sun, {.model = model});
    // Within a degree of the zenith the sky is the same all round
    const Eigen::Array3d north = day.SkyRadiance(DirectionFromAzimuthElevation(0, 0.7));
    const Eigen::Array3d east =
        day.SkyRadiance(DirectionFromAzimuthElevation(RadFromDeg(90), 0.7));
    EXPECT_TRUE(north.isApprox(east, 0.03)) << static_cast<int>(model);
  }
}

TEST(DaylightOfPlaces, ATenthOfADegreeOfSunsetIsNoStep) {
  const auto at = [](double elevation_deg) {
    const double elevation_rad = RadFromDeg(elevation_deg);
    return SolarPosition{
        4.7, elevation_rad, DirectionFromAzimuthElevation(4.7, elevation_rad)};
  };
  const DaylightOptions air{.model = SkyModel::kAtmosphere};
  const Daylight above = MakeDaylight(at(0.1), air), on = MakeDaylight(at(0), air),
                 below = MakeDaylight(at(-0.1), air);
  for (const double elevation_deg : {0.5, 10.0, 60.0}) {
    const Eigen::Vector3d dir =
        DirectionFromAzimuthElevation(2.0, RadFromDeg(elevation_deg));
    const double a = above.SkyRadiance(dir)[1], b = on.SkyRadiance(dir)[1],
                 c = below.SkyRadiance(dir)[1];
    // Dusk halves the light in about a degree: some 7 % in a tenth, and evenly
    EXPECT_GT(a, b);
    EXPECT_GT(b, c);
    EXPECT_LT(a / b, 1.15);
    EXPECT_NEAR((a / b) / (b / c), 1, 0.05);
  }
  EXPECT_GT(above.sun_irradiance[0], on.sun_irradiance[0]);
  EXPECT_GT(on.sun_irradiance[0], below.sun_irradiance[0]);
  EXPECT_GT(below.sun_irradiance[0], 0);  // A third of the disc is still up
  for (const SkyModel model :
       {SkyModel::kPreetham, SkyModel::kCie, SkyModel::kCabral2011}) {
    EXPECT_NO_THROW(MakeDaylight(at(0.1), {.model = model}));
    EXPECT_THROW(MakeDaylight(at(-0.1), {.model = model}), InputError);
  }
}

TEST(DaylightOfPlaces, TheGroundsAlbedoLightensTheAtmosphereAlone) {
  const SolarPosition sun = SolarPositionAt(At(2024, 6, 21, 11), {48, 2, 0});
  const auto zenith = [&](std::optional<double> albedo) {
    return MakeDaylight(sun, {.model = SkyModel::kAtmosphere, .ground_albedo = albedo})
        .SkyRadiance({0, 0, 1})[2];
  };
  EXPECT_EQ(zenith({}), zenith(0.2));
  EXPECT_GT(zenith(0.8), zenith(0.2));  // Snow
  EXPECT_LT(zenith(0.0), zenith(0.2));
  EXPECT_THROW(MakeDaylight(sun, {.ground_albedo = 0.5}), OptionError);
}

}  // namespace
}  // namespace relight
