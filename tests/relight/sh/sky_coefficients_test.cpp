// SPDX-License-Identifier: Apache-2.0
#include "relight/sh/sky_coefficients.h"

#include "relight/base/angles.h"
#include "tests/support/csv_table.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

namespace relight {
namespace {

using std::numbers::pi;

// White furnace: a sky of radiance L all round has one coefficient, and lights level
// ground with pi L.
TEST(SkyCoefficients, AWhiteFurnaceIsWhite) {
  const Eigen::Array3d radiance(2.0, 3.0, 5.0);
  const Daylight furnace = UniformDaylight(radiance, /*full_sphere=*/true);
  const ShCoefficients c = SkyCoefficients(furnace);
  EXPECT_EQ(c.rows(), 36);
  EXPECT_TRUE(c.row(0).transpose().array().isApprox(radiance * std::sqrt(4 * pi), 1e-12));
  EXPECT_LT(c.bottomRows(35).cwiseAbs().maxCoeff(), 1e-11);  // Rounding of 9216 terms
  EXPECT_TRUE(HorizontalSkyIrradiance(furnace).isApprox(pi * radiance, 1e-12));
}

// Half a sphere: sqrt(pi) L, then the odd bands on the axis; c_1,0 = sqrt(3 pi) / 2 L.
TEST(SkyCoefficients, AUniformSkyHasItsClosedForm) {
  const Daylight sky = UniformDaylight(Eigen::Array3d::Ones());
  const ShCoefficients c = SkyCoefficients(sky);
  EXPECT_NEAR(c(ShIndex(0, 0), 0), std::sqrt(pi), 1e-12);
  EXPECT_NEAR(c(ShIndex(1, 0), 0), std::sqrt(3 * pi) / 2, 1e-12);
  EXPECT_NEAR(c(ShIndex(2, 0), 0), 0.0, 1e-12);
  EXPECT_TRUE(HorizontalSkyIrradiance(sky).isApprox(Eigen::Array3d::Constant(pi), 1e-12));
}

// The table is of the same model with its authors' coefficients; ours are compared to the
// largest of the channel, c_0,0. What remains is the cusp of the sky at the sun, which
// 1e-4 leaves room for: 6 bands err by a hundred times as much.
TEST(SkyCoefficients, AgreesWithTheTableOfPreethamsSky) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/preetham_sh36.csv");
  const auto rows = tests::ReadCsv(tests::SharedPath("reference/sky/preetham_sh36.csv"));
  ASSERT_GE(rows.size(), 30u);
  double worst = 0.0, worst_horizontal = 0.0;
  for (const auto& row : rows) {
    // The table has the sun on +x, azimuth 90 degrees
    const PreethamSky sky(
        DirectionFromAzimuthElevation(pi / 2, RadFromDeg(90 - row["sun_zenith_deg"])),
        {.turbidity = row["turbidity"], .coefficients = PreethamCoefficients::kProgram});
    const int channel = std::string("XYZ").find(row.Text("channel"));
    const auto klx = [&](const Eigen::Vector3d& d) { return sky.Xyz(d)(channel) / 1000; };
    const Eigen::VectorXd c = ProjectOnSh(klx);
    for (int l = 0; l < 6; ++l) {
      for (int m = -l; m <= l; ++m) {
        const double expected = row["c_" + std::to_string(l) + "_" + std::to_string(m)];
        worst = std::max(worst, std::abs(c(ShIndex(l, m)) - expected) / c(0));
      }
    }
    double horizontal_klx = 0.0;
    for (const auto& [direction, weight_sr] : SphereQuadrature()) {
      horizontal_klx += weight_sr * std::max(0.0, direction.z()) * klx(direction);
    }
    worst_horizontal =
        std::max(worst_horizontal,
                 std::abs(horizontal_klx / row["horizontal_illuminance_klx"] - 1));
  }
  std::printf("worst coefficient %.1e of c_00, horizontal illuminance %.1e\n",
              worst,
              worst_horizontal);
  EXPECT_LT(worst, 1e-4);
  EXPECT_LT(worst_horizontal, 1e-4);
}

// Daylight's own coefficients, turned with the sun.
TEST(SkyCoefficients, TurnWithTheSun) {
  const auto day_at = [](double azimuth_deg) {
    const double azimuth_rad = RadFromDeg(azimuth_deg), elevation_rad = RadFromDeg(30.0);
    return MakeDaylight({azimuth_rad,
                         elevation_rad,
                         DirectionFromAzimuthElevation(azimuth_rad, elevation_rad)});
  };
  const ShCoefficients south = SkyCoefficients(day_at(180.0));
  const ShCoefficients south_west = SkyCoefficients(day_at(225.0));
  // Azimuth runs clockwise, the turn about +z counterclockwise. 45 degrees are 12 steps
  // of the quadrature, so only rounding is left.
  EXPECT_LT((TurnedAboutZ(south, -RadFromDeg(45.0)) - south_west).cwiseAbs().maxCoeff(),
            1e-10 * south.cwiseAbs().maxCoeff());
  EXPECT_EQ(SkyCoefficients(day_at(180.0), 2), south.topRows(4));
}

// The quadrature has converged: four times the directions change nothing that matters.
TEST(SkyCoefficients, DoNotDependOnTheQuadrature) {
  const PreethamSky sky(DirectionFromAzimuthElevation(1.0, RadFromDeg(25.0)));
  const ShCoefficients usual = ProjectColorOnSh(sky);
  const ShCoefficients fine =
      ProjectColorOnSh(sky, kSkyBands, {.heights_per_side = 96, .azimuths = 192});
  const double change = (usual - fine).cwiseAbs().maxCoeff() / fine.cwiseAbs().maxCoeff();
  std::printf("change %.1e\n", change);
  EXPECT_LT(change, 1e-4);  // A tenth of what the table asks for
}

}  // namespace
}  // namespace relight
