// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/cie_sky.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "tests/support/csv_table.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

Eigen::Vector3d Towards(double zenith_deg, double azimuth_deg) {
  return DirectionFromAzimuthElevation(RadFromDeg(azimuth_deg),
                                       RadFromDeg(90 - zenith_deg));
}

TEST(CieSky, AgreesWithTheTableOfTheFifteenTypes) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/cie_sky.csv");
  const auto rows = tests::ReadCsv(tests::SharedPath("reference/sky/cie_sky.csv"));
  ASSERT_GE(rows.size(), 900u);
  double worst = 0;
  for (const auto& row : rows) {
    const CieSky sky(Towards(row["sun_zenith_deg"], 30.0),
                     static_cast<int>(row["cie_type"]));
    const double relative =
        sky(Towards(row["view_zenith_deg"], 30.0 + row["azimuth_view_minus_sun_deg"]));
    worst = std::max(worst, std::abs(relative / row["L_over_Lz"] - 1));
  }
  std::printf("worst relative difference %.2e\n", worst);
  EXPECT_LT(worst, 1e-6);  // The digits of the table
}

TEST(CieSky, IsOneAtTheZenithAndFiniteAndPositiveOverTheDome) {
  for (int type = 1; type <= 15; ++type) {
    for (const double sun_deg : {0.0, 30.0, 60.0, 90.0, 96.0}) {
      const CieSky sky(Towards(sun_deg, 100.0), type);
      EXPECT_NEAR(sky(Eigen::Vector3d::UnitZ()), 1.0, 1e-12);
      for (double zenith_deg = 0; zenith_deg <= 90; zenith_deg += 5) {
        for (double azimuth_deg = 0; azimuth_deg < 360; azimuth_deg += 20) {
          const double value = sky(Towards(std::min(zenith_deg, 89.999), azimuth_deg));
          EXPECT_TRUE(std::isfinite(value) && value > 0)
              << type << " " << sun_deg << " " << zenith_deg;
        }
      }
      EXPECT_EQ(sky(Towards(91, 0)), 0.0);
    }
  }
}

TEST(CieSky, OvercastIsBrightestAtTheZenithAndAUniformOneIsUniform) {
  const CieSky overcast(Towards(40, 0), kCieOvercast), uniform(Towards(40, 0), 5);
  for (double zenith_deg = 10; zenith_deg < 90; zenith_deg += 10) {
    EXPECT_LT(overcast(Towards(zenith_deg, 70)), overcast(Towards(zenith_deg - 10, 70)));
    EXPECT_EQ(uniform(Towards(zenith_deg, 70)), 1.0);
  }
}

TEST(CieSky, RefusesOtherTypes) {
  EXPECT_THROW(CieSky(Eigen::Vector3d::UnitZ(), 0), OptionError);
  EXPECT_THROW(CieSky(Eigen::Vector3d::UnitZ(), 16), OptionError);
}

}  // namespace
}  // namespace relight
