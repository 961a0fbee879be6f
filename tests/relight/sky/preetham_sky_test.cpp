// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/preetham_sky.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/sky/rec709.h"
#include "tests/support/csv_table.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace relight {
namespace {

Eigen::Vector3d Towards(double zenith_deg, double azimuth_deg) {
  return DirectionFromAzimuthElevation(RadFromDeg(azimuth_deg),
                                       RadFromDeg(90 - zenith_deg));
}

// The table has nine digits, in columns of the paper's coefficients and of the program's.
TEST(PreethamSky, AgreesWithTheTableOfLuminancesAndColours) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/preetham.csv");
  const auto rows = tests::ReadCsv(tests::SharedPath("reference/sky/preetham.csv"));
  ASSERT_GE(rows.size(), 900u);
  struct Columns {
    PreethamCoefficients coefficients;
    std::string Y, x, y, Yz, xz, yz;
  };
  const Columns paper{PreethamCoefficients::kPaper,
                      "Y_paper_kcd_m2",
                      "x_paper",
                      "y_paper",
                      "Yz_paper",
                      "xz_paper",
                      "yz_paper"};
  const Columns program{
      PreethamCoefficients::kProgram, "Y_kcd_m2", "x", "y", "Yz_kcd_m2", "xz", "yz"};
  for (const Columns& of : {paper, program}) {
    double worst_Y = 0.0, worst_xy = 0.0;
    for (const auto& row : rows) {
      const PreethamSky sky(
          Towards(row["sun_zenith_deg"], 40.0),
          {.turbidity = row["turbidity"], .coefficients = of.coefficients});
      const auto [Y, x, y] = sky.Color(
          Towards(row["view_zenith_deg"], 40.0 + row["azimuth_view_minus_sun_deg"]));
      worst_Y = std::max(worst_Y, std::abs(Y / (1000 * row[of.Y]) - 1));
      worst_xy = std::max({worst_xy, std::abs(x - row[of.x]), std::abs(y - row[of.y])});
      EXPECT_NEAR(sky.zenith().luminance_cd_per_m2 / (1000 * row[of.Yz]), 1.0, 1e-7);
      EXPECT_NEAR(sky.zenith().x, row[of.xz], 1e-7);
      EXPECT_NEAR(sky.zenith().y, row[of.yz], 1e-7);
    }
    std::printf("%s: worst Y %.2e, x and y %.2e\n", of.Y.c_str(), worst_Y, worst_xy);
    EXPECT_LT(worst_Y, 1e-7);
    EXPECT_LT(worst_xy, 1e-7);
  }
}

// So that no sky we can make is clamped in XYZ, and none divides by y = 0.
TEST(PreethamSky, HasProperColoursInItsWholeRange) {
  for (const double turbidity : {1.7, 2.0, 3.0, 4.2, 6.0, 8.0, 10.0}) {
    for (const double sun_zenith_deg : {0.0, 20.0, 45.0, 70.0, 85.0, 89.9, 89.999}) {
      const PreethamSky sky(Towards(sun_zenith_deg, 0.0), {.turbidity = turbidity});
      for (double zenith_deg = 0.0; zenith_deg <= 90.0; zenith_deg += 3.0) {
        for (double azimuth_deg = 0.0; azimuth_deg <= 180.0; azimuth_deg += 10.0) {
          const auto [Y, x, y] = sky.Color(Towards(zenith_deg, azimuth_deg));
          EXPECT_GT(Y, 0.0);
          EXPECT_GT(x, 0.1);
          EXPECT_GT(y, 0.1);
          EXPECT_LT(x + y, 1.0);
        }
      }
    }
  }
}

TEST(PreethamSky, IsTheSameOnBothSidesOfTheSun) {
  const PreethamSky sky(Towards(50.0, 120.0));
  for (const double off_deg : {10.0, 70.0, 150.0}) {
    EXPECT_TRUE(sky(Towards(60.0, 120.0 + off_deg))
                    .isApprox(sky(Towards(60.0, 120.0 - off_deg)), 1e-12));  // Rounding
  }
}

TEST(PreethamSky, IsBlackBelowTheHorizonAndNotAtIt) {
  const PreethamSky sky(Towards(50.0, 120.0));
  EXPECT_TRUE((sky(Towards(90.001, 30.0)) == 0.0).all());
  EXPECT_TRUE((sky.Xyz(-Eigen::Vector3d::UnitZ()) == 0.0).all());
  EXPECT_GT(sky(Eigen::Vector3d::UnitX()).y(), 0.0);
}

TEST(PreethamSky, RadianceIsTheLuminanceInRec709) {
  const PreethamSky sky(Towards(35.0, 200.0), {.turbidity = 2.5});
  const Eigen::Vector3d direction = Towards(70.0, 80.0);
  EXPECT_TRUE(XyzFromRec709(sky(direction)).isApprox(sky.Xyz(direction), 1e-12));
  EXPECT_NEAR(sky.Xyz(direction).y(), sky.Color(direction).luminance_cd_per_m2, 1e-9);
}

// A clear sky has colours beyond Rec.709 under a setting sun; only kRec709 cuts them.
TEST(PreethamSky, ClampsWhereItIsToldTo) {
  const Eigen::Vector3d sun = Towards(89.9, 90.0);
  const PreethamSky wide(sun, {.turbidity = 2.0});
  const PreethamSky cut(sun, {.turbidity = 2.0, .clamp = SkyClamp::kRec709});
  double lowest = 0.0;
  for (double zenith_deg = 0.0; zenith_deg <= 90.0; zenith_deg += 2.0) {
    for (double azimuth_deg = 0.0; azimuth_deg < 360.0; azimuth_deg += 15.0) {
      const Eigen::Vector3d direction = Towards(zenith_deg, azimuth_deg);
      lowest = std::min(lowest, wide(direction).minCoeff());
      EXPECT_TRUE((cut(direction) == wide(direction).max(0.0)).all());
    }
  }
  EXPECT_LT(lowest, 0.0);
}

TEST(PreethamSky, SaysWhereItEnds) {
  EXPECT_THROW(PreethamSky(Towards(90.5, 0.0)), InputError);
  EXPECT_THROW(PreethamSky(Towards(20.0, 0.0), {.turbidity = 1.2}), OptionError);
  EXPECT_THROW(PreethamSky(Towards(20.0, 0.0), {.turbidity = 11.5}), OptionError);
}

}  // namespace
}  // namespace relight
