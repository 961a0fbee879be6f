// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/cabral2011_sun.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/sky/air_mass.h"
#include "relight/sky/preetham_sun.h"
#include "tests/support/csv_table.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace relight {
namespace {

// How well one exponential fits Preetham's sun: at the table's air masses, which end at
// 3.8, between them, and from there to air mass 5.
constexpr double kFit = 0.003;
constexpr double kFitBetween = 0.004;
constexpr double kFitTo5 = 0.02;

TEST(Cabral2011Sun, FitsTheTableOfPreethamsSun) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/sun_rgb.csv");
  int compared = 0;
  double worst = 0.0;
  for (const auto& row : tests::ReadCsv(tests::SharedPath("reference/sky/sun_rgb.csv"))) {
    if (row["turbidity"] != 4.2 || row["m"] > 5.0) continue;
    const Eigen::Array3d rgb(row["R_lin_sRGB"], row["G_lin_sRGB"], row["B_lin_sRGB"]);
    worst = std::max(
        worst, (Cabral2011SunIrradianceAtAirMass(row["m"]) / rgb - 1).abs().maxCoeff());
    ++compared;
  }
  std::printf("%d rows, worst %.5f\n", compared, worst);
  EXPECT_GE(compared, 6);
  EXPECT_LT(worst, kFit);
}

// The same against our own sun, at all air masses between the table's.
TEST(Cabral2011Sun, FitsPreethamsSunOfTheSameAir) {
  for (double m = 1.0; m <= 5.0; m += 0.25) {
    const Eigen::Array3d preetham =
        PreethamSunIrradianceAtAirMass(m, {.turbidity = 4.2}).rgb_lx;
    EXPECT_LT((Cabral2011SunIrradianceAtAirMass(m) / preetham - 1).abs().maxCoeff(),
              m <= 3.8 ? kFitBetween : kFitTo5)
        << m;
  }
}

// ln(E_corrected / E) = beta (m - m^k): nothing at m = 1, and by the paper's k beyond.
TEST(Cabral2011Sun, TheSunsetCorrectionRaisesTheAirMassToItsPower) {
  const Cabral2011SunOptions corrected{.sunset_correction = true};
  EXPECT_TRUE((Cabral2011SunIrradianceAtAirMass(1.0, corrected) ==
               Cabral2011SunIrradianceAtAirMass(1.0))
                  .all());
  const Eigen::Array3d by_square = Cabral2011SunIrradianceAtAirMass(9.0);
  const Eigen::Array3d square = Cabral2011SunIrradianceAtAirMass(3.0, corrected);
  EXPECT_NEAR(square.y() / by_square.y(), 1.0, 1e-12);  // 3^2 = 9
  EXPECT_NEAR(square.z() / by_square.z(), 1.0, 1e-12);
  EXPECT_NEAR(
      square.x() / Cabral2011SunIrradianceAtAirMass(std::pow(3.0, 2.5)).x(), 1.0, 1e-12);
}

TEST(Cabral2011Sun, TakesTheAirMassOfItsDirection) {
  const double zenith_rad = RadFromDeg(65.0);
  const Eigen::Vector3d sun =
      DirectionFromAzimuthElevation(2.0, std::numbers::pi / 2 - zenith_rad);
  EXPECT_TRUE(Cabral2011SunIrradiance(sun).isApprox(
      Cabral2011SunIrradianceAtAirMass(AirMass(zenith_rad)),
      1e-12));  // Rounding of angles
  EXPECT_THROW(Cabral2011SunIrradiance({0.0, 1.0, 0.0}), InputError);
}

}  // namespace
}  // namespace relight
