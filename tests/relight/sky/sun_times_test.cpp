// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/sun_times.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/sky/solar_position.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

using namespace std::chrono;

double ElevationDeg(Instant instant, const Place& place) {
  return DegFromRad(SolarPositionAt(instant, place).elevation_rad);
}

// The sun climbs at most 15 degrees an hour, so 1 ms of bisection is 4e-6 degrees.
constexpr double kAtHorizon_deg = 1e-5;

TEST(SunTimes, TheSunIsOnTheHorizonAtSunriseAndSunset) {
  const Place nice{43.7, 7.25, 10.0}, sydney{-33.9, 151.2, 0.0},
      quito{-0.2, -78.5, 2850.0};
  for (const Place& place : {nice, sydney, quito}) {
    for (const unsigned month : {1u, 4u, 9u, 12u}) {
      const SunTimes times = SunTimesOf(year(2011) / month / 23, place);
      ASSERT_TRUE(times.sunrise && times.sunset);
      EXPECT_NEAR(ElevationDeg(*times.sunrise, place), 0.0, kAtHorizon_deg);
      EXPECT_NEAR(ElevationDeg(*times.sunset, place), 0.0, kAtHorizon_deg);
      EXPECT_LT(*times.sunrise, times.noon);
      EXPECT_LT(times.noon, *times.sunset);
      EXPECT_GT(ElevationDeg(times.noon, place),
                ElevationDeg(times.noon + minutes(5), place));
      EXPECT_GT(ElevationDeg(times.noon, place),
                ElevationDeg(times.noon - minutes(5), place));
    }
  }
}

// At an equinox the geometric day is 12 hours everywhere, within the 0.4 degrees that the
// declination may be off at that day's noon: 4 minutes at 60 degrees of latitude.
TEST(SunTimes, TheDayOfTheEquinoxHasTwelveHours) {
  for (const double latitude_deg : {-60.0, -30.0, 0.0, 45.0, 60.0}) {
    const SunTimes times = SunTimesOf(year(2011) / 9 / 23, {latitude_deg, 20.0, 0.0});
    EXPECT_NEAR(
        duration<double>(*times.sunset - *times.sunrise).count(), 12 * 3600.0, 240.0);
  }
}

TEST(SunTimes, PolarDayAndNightHaveNoSunriseNorSunset) {
  const Place tromso{69.65, 18.95, 0.0};
  for (const auto date : {year(2011) / 6 / 21, year(2011) / 12 / 21}) {
    const SunTimes times = SunTimesOf(date, tromso);
    EXPECT_FALSE(times.sunrise.has_value());
    EXPECT_FALSE(times.sunset.has_value());
  }
  EXPECT_GT(ElevationDeg(SunTimesOf(year(2011) / 6 / 21, tromso).noon, tromso), 40.0);
}

TEST(SunTimes, NoonIsTheDaysOwnOnBothSidesOfTheDateLine) {
  for (const double longitude_deg : {-179.5, 179.5}) {
    const SunTimes times = SunTimesOf(year(2011) / 3 / 1, {10.0, longitude_deg, 0.0});
    const auto local =
        times.noon + duration_cast<milliseconds>(duration<double>(longitude_deg * 240.0));
    EXPECT_EQ(year_month_day(floor<days>(local)), year(2011) / 3 / 1);
  }
}

TEST(SunTimes, RefusesADayThatIsNone) {
  EXPECT_THROW(SunTimesOf(year(2011) / 2 / 30, {}), InputError);
}

}  // namespace
}  // namespace relight
