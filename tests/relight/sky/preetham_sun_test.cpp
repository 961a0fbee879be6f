// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/preetham_sun.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "tests/support/csv_table.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cstdio>

namespace relight {
namespace {

// The table has ten digits.
TEST(SunTransmittance, AgreesWithTheTableAtEveryWavelength) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/sun_transmittance.csv");
  const auto rows =
      tests::ReadCsv(tests::SharedPath("reference/sky/sun_transmittance.csv"));
  ASSERT_EQ(rows.size(), 1520u);
  for (const auto& row : rows) {
    const double wavelength_nm = row["lambda_nm"];
    const SunTransmittance tau =
        SunTransmittanceAt(wavelength_nm, row["turbidity"], row["m_kastenyoung1989"]);
    EXPECT_NEAR(tau.rayleigh, row["tau_rayleigh"], 1e-7);
    EXPECT_NEAR(tau.aerosol, row["tau_aerosol"], 1e-7);
    EXPECT_NEAR(tau.ozone, row["tau_ozone"], 1e-7);
    EXPECT_EQ(row["tau_gas"], 1.0);  // Why we have none
    EXPECT_NEAR(tau.water, row["tau_water"], 1e-7);
    EXPECT_EQ(SunRadianceAboveAtmosphere(wavelength_nm), row["L0_W_m2_nm_sr"]);
  }
}

// Spectrum, observer and quadrature are the table's, but for the last digits of its
// observer: 7e-6 where little light is left. Rec.709 is compared to the largest channel,
// for blue is a small difference of large numbers at dusk.
TEST(PreethamSun, AgreesWithTheTableOfIrradiances) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/sun_rgb.csv");
  const auto rows = tests::ReadCsv(tests::SharedPath("reference/sky/sun_rgb.csv"));
  int compared = 0;
  Eigen::Array3d worst_xyz = Eigen::Array3d::Zero(), worst_rgb = Eigen::Array3d::Zero();
  double worst_w = 0.0;
  for (const auto& row : rows) {
    const SunIrradiance sun =
        PreethamSunIrradianceAtAirMass(row["m"], {.turbidity = row["turbidity"]});
    const Eigen::Array3d xyz(row["E_X_lx"], row["E_Y_lx"], row["E_Z_lx"]);
    const Eigen::Array3d rgb(row["R_lin_sRGB"], row["G_lin_sRGB"], row["B_lin_sRGB"]);
    worst_xyz = worst_xyz.max((sun.xyz_lx / xyz - 1).abs());
    worst_rgb = worst_rgb.max((sun.rgb_lx - rgb).abs() / rgb.maxCoeff());
    worst_w =
        std::max(worst_w, std::abs(sun.visible_w_per_m2 / row["E_380_750_W_m2"] - 1));
    ++compared;
  }
  std::printf(
      "%d rows: X %.1e Y %.1e Z %.1e; R %.1e G %.1e B %.1e of the largest; W %.1e\n",
      compared,
      worst_xyz.x(),
      worst_xyz.y(),
      worst_xyz.z(),
      worst_rgb.x(),
      worst_rgb.y(),
      worst_rgb.z(),
      worst_w);
  EXPECT_GE(compared, 60);
  EXPECT_LT(worst_w, 1e-6);
  EXPECT_LT(worst_xyz.maxCoeff(), 2e-5);
  EXPECT_LT(worst_rgb.maxCoeff(), 2e-5);
}

TEST(PreethamSun, IsTheSumOfItsSpectrumWhenTheAirIsGone) {
  const SunIrradiance sun = PreethamSunIrradianceAtAirMass(0.0);
  // Of the solar constant, 1361 W/m2, 51.7 % lie below 750 nm and 7.0 % below 380 nm;
  // solar spectra of different years part by 1 %
  EXPECT_NEAR(sun.visible_w_per_m2 / 1361.0, 0.447, 0.01);
  for (const double wavelength_nm : {380.0, 555.0, 750.0}) {
    EXPECT_EQ(SunTransmittanceAt(wavelength_nm, 3.0, 0.0).Total(), 1.0);
  }
}

// exp(-k m): twice the air is the square; water, a band model, is not.
TEST(SunTransmittance, MultipliesAlongTheWay) {
  const SunTransmittance once = SunTransmittanceAt(470.0, 3.0, 1.5);
  const SunTransmittance twice = SunTransmittanceAt(470.0, 3.0, 3.0);
  EXPECT_NEAR(twice.rayleigh, once.rayleigh * once.rayleigh, 1e-14);
  EXPECT_NEAR(twice.aerosol, once.aerosol * once.aerosol, 1e-14);
  EXPECT_NEAR(twice.ozone, once.ozone * once.ozone, 1e-14);
}

TEST(PreethamSun, FadesAndReddensTowardsTheHorizonAndWithHaze) {
  Eigen::Array3d before = PreethamSunIrradianceAtAirMass(0.5).rgb_lx;
  for (const double elevation_deg : {80.0, 50.0, 30.0, 15.0, 8.0, 4.0}) {
    const Eigen::Vector3d sun =
        DirectionFromAzimuthElevation(1.0, RadFromDeg(elevation_deg));
    const Eigen::Array3d rgb = PreethamSunIrradiance(sun).rgb_lx;
    EXPECT_TRUE((rgb < before).all());
    EXPECT_LT(rgb.z() / rgb.x(), before.z() / before.x());
    EXPECT_TRUE((PreethamSunIrradiance(sun, {.turbidity = 6.0}).xyz_lx <
                 PreethamSunIrradiance(sun).xyz_lx)
                    .all());
    before = rgb;
  }
}

TEST(PreethamSun, EndsAtTheHorizon) {
  EXPECT_THROW(PreethamSunIrradiance({1.0, 0.0, 0.0}), InputError);
  EXPECT_THROW(PreethamSunIrradiance({1.0, 0.0, -0.1}), InputError);
  EXPECT_THROW(PreethamSunIrradiance({1.0, 0.0, 1.0}, {.turbidity = 20.0}), OptionError);
}

}  // namespace
}  // namespace relight
