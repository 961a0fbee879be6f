// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/solar_position.h"

#include "relight/base/angles.h"
#include "tests/support/csv_table.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <cstdio>
#include <limits>

namespace relight {
namespace {

Instant Utc(const std::string& text) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  EXPECT_EQ(std::sscanf(text.c_str(),
                        "%d-%d-%dT%d:%d:%dZ",
                        &year,
                        &month,
                        &day,
                        &hour,
                        &minute,
                        &second),
            6);
  using namespace std::chrono;
  return sys_days(std::chrono::year(year) / month / day) + hours(hour) + minutes(minute) +
         seconds(second);
}

Eigen::Vector3d Towards(double zenith_deg, double azimuth_deg) {
  return DirectionFromAzimuthElevation(RadFromDeg(azimuth_deg),
                                       RadFromDeg(90 - zenith_deg));
}

// Two full ephemerides made the table; they part by at most 0.0001 degrees, and rows are
// rounded to 1e-7: 0.0005 degrees is a thousandth of the sun's width.
constexpr double kTolerance_deg = 0.0005;

TEST(SolarPosition, AgreesWithTheTableOfPositions) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/sunpos.csv");
  const auto rows = tests::ReadCsv(tests::SharedPath("reference/sky/sunpos.csv"));
  ASSERT_GE(rows.size(), 300u);
  double worst_deg = 0.0, worst_erfa_deg = 0.0;
  for (const auto& row : rows) {
    const SolarPosition sun =
        SolarPositionAt(Utc(row.Text("utc")),
                        {row["lat_deg"], row["lon_deg_east"], row["alt_m"]},
                        {.delta_t_s = row["delta_t_s"]});
    const double error_deg = DegFromRad(
        AngleBetween(sun.direction, Towards(row["zenith_deg"], row["azimuth_deg"])));
    EXPECT_LT(error_deg, kTolerance_deg) << row.Text("utc") << " " << row.Text("group");
    worst_deg = std::max(worst_deg, error_deg);
    worst_erfa_deg =
        std::max(worst_erfa_deg,
                 DegFromRad(AngleBetween(
                     sun.direction, Towards(row["zenith_erfa"], row["azimuth_erfa"]))));
  }
  RecordProperty("worst_deg", std::to_string(worst_deg));
  RecordProperty("worst_erfa_deg", std::to_string(worst_erfa_deg));
  std::printf(
      "worst %.6f deg, to the erfa columns %.7f deg\n", worst_deg, worst_erfa_deg);
}

// Brighton, 2015: delta_t was 67.7 s and UT1 - UTC below 0.6 s.
TEST(SolarPosition, IsWithinTheSecondOfUt1WhenNoDeltaTIsGiven) {
  const Instant instant = Utc("2015-05-01T12:00:00Z");
  const Place place{50.8, -0.1, 50.0};
  const double apart_deg = DegFromRad(
      AngleBetween(SolarPositionAt(instant, place).direction,
                   SolarPositionAt(instant, place, {.delta_t_s = 67.7}).direction));
  // The two share UT1 and part in TT by 67.7 - 67.184 s; the sun moves 0.041 arcsec/s
  EXPECT_LT(apart_deg, 1.0 * 0.05 / 3600);
}

// A place turned by one degree of longitude sees the sun of 4 minutes later, but for the
// 0.0027 degrees that the sun itself moves in 4 minutes.
TEST(SolarPosition, TurnsWithTheEarth) {
  const Instant instant = Utc("2011-09-23T10:00:00Z");
  const Eigen::Vector3d east = SolarPositionAt(instant, {43.6, 8.0, 0.0}).direction;
  const Eigen::Vector3d later =
      SolarPositionAt(instant + std::chrono::minutes(4), {43.6, 7.0, 0.0}).direction;
  EXPECT_LT(DegFromRad(AngleBetween(east, later)), 0.004);
  EXPECT_GT(DegFromRad(AngleBetween(east, later)), 0.0005);  // It does move
}

TEST(SolarPosition, GivesOneDirectionInTwoWays) {
  const SolarPosition sun =
      SolarPositionAt(Utc("2011-06-21T16:30:00Z"), {43.6, 7.0, 100.0});
  EXPECT_NEAR(AzimuthOf(sun.direction), sun.azimuth_rad, 1e-12);
  EXPECT_NEAR(ElevationOf(sun.direction), sun.elevation_rad, 1e-12);
  EXPECT_NEAR(sun.direction.norm(), 1.0, 1e-12);
}

TEST(SolarPosition, RefusesWhatItCannotKnow) {
  const Instant now = Utc("2011-06-21T16:30:00Z");
  EXPECT_THROW(SolarPositionAt(Utc("1850-01-01T00:00:00Z"), {}), InputError);
  EXPECT_THROW(SolarPositionAt(Utc("2100-01-01T00:00:00Z"), {}), InputError);
  EXPECT_THROW(SolarPositionAt(now, {91.0, 0.0, 0.0}), InputError);
  EXPECT_THROW(SolarPositionAt(now, {0.0, 190.0, 0.0}), InputError);
  EXPECT_THROW(SolarPositionAt(now, {std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}),
               InputError);
  EXPECT_NO_THROW(SolarPositionAt(Utc("1900-01-01T00:00:00Z"), {}));
  EXPECT_NO_THROW(SolarPositionAt(Utc("2099-12-31T23:59:59Z"), {}));
}

}  // namespace
}  // namespace relight
