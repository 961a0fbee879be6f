// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/atmosphere.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "tests/support/csv_table.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <map>
#include <tuple>
#include <vector>

namespace relight {
namespace {

Eigen::Vector3d At(double elevation_deg, double azimuth_deg) {
  return DirectionFromAzimuthElevation(RadFromDeg(azimuth_deg),
                                       RadFromDeg(elevation_deg));
}

double Luminance(const Eigen::Array3d& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// One factor a dome is free: what is compared is where a sky is bright.
TEST(Atmosphere, RelativeLuminancesAreThoseOfTracedPaths) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/hosek.csv");
  const auto rows = tests::ReadCsv(tests::SharedPath("reference/sky/hosek.csv"));
  std::map<std::pair<double, double>, Atmosphere> airs;
  std::map<std::tuple<double, double, double>, std::vector<double>> domes;
  for (const auto& row : rows) {
    const double turbidity = row["turbidity"], sun_deg = 90 - row["sun_zenith_deg"];
    if (turbidity > 6 || sun_deg < 10) continue;
    const double albedo = row["albedo"];
    auto air = airs.find({turbidity, albedo});
    if (air == airs.end()) {
      air = airs.emplace(std::pair(turbidity, albedo),
                         Atmosphere({.turbidity = turbidity, .ground_albedo = albedo}))
                .first;
    }
    const double luminance = Luminance(air->second.SkyRadiance(
        At(sun_deg, 20),
        At(90 - row["view_zenith_deg"], 20 + row["azimuth_view_minus_sun_deg"])));
    domes[{turbidity, albedo, sun_deg}].push_back(
        std::log(luminance / row["luminance_cd_m2"]));
  }
  ASSERT_GE(domes.size(), 40u);
  double square = 0, worst = 0;
  int count = 0;
  for (const auto& [key, logs] : domes) {
    double mean = 0, of_dome = 0;
    for (const double x : logs) mean += x / static_cast<double>(logs.size());
    for (const double x : logs) of_dome += (x - mean) * (x - mean);
    square += of_dome;
    count += static_cast<int>(logs.size());
    const double rms = std::sqrt(of_dome / static_cast<double>(logs.size()));
    worst = std::max(worst, rms);
    std::printf("T %.1f albedo %.1f sun %2.0f: rms %.3f, level %.2f\n",
                std::get<0>(key),
                std::get<1>(key),
                std::get<2>(key),
                rms,
                std::exp(mean));
  }
  std::printf("all %.3f, worst dome %.3f\n", std::sqrt(square / count), worst);
  EXPECT_LE(std::sqrt(square / count), 0.20);
  EXPECT_LE(worst, 0.25);
}

TEST(Atmosphere, IsFiniteAndPositiveFromTheZenithToSixDegreesBelowTheHorizon) {
  for (const double turbidity : {1.7, 3.0, 10.0}) {
    const Atmosphere air({.turbidity = turbidity});
    for (const double sun_deg : {90.0, 45.0, 10.0, 1.0, 0.1, -0.1, -2.0, -6.0}) {
      const Eigen::Array3d sun = air.SunIrradiance(At(sun_deg, 0));
      EXPECT_TRUE(sun.isFinite().all());
      EXPECT_GE(Luminance(sun), 0);
      for (double elevation_deg = 0; elevation_deg <= 90; elevation_deg += 10) {
        for (const double azimuth_deg : {0.0, 60.0, 180.0}) {
          const Eigen::Array3d sky =
              air.SkyRadiance(At(sun_deg, 0), At(elevation_deg, azimuth_deg));
          EXPECT_TRUE(sky.isFinite().all());
          EXPECT_GT(Luminance(sky), 0) << turbidity << " " << sun_deg;
        }
      }
    }
    EXPECT_TRUE((air.SkyRadiance(At(30, 0), At(-1, 0)) == 0).all());
  }
}

TEST(Atmosphere, GoesThroughSunsetSmoothly) {
  const Atmosphere air;
  const auto sky = [&](double sun_deg) {
    return Luminance(air.SkyRadiance(At(sun_deg, 0), At(40, 90)));
  };
  // About sunset a clear sky darkens by some 10 % in 0.2 degrees, not by a step
  EXPECT_NEAR(sky(-0.1) / sky(0.1), 1.0, 0.2);
  EXPECT_NEAR(sky(-0.001) / sky(0.001), 1.0, 0.002);
  EXPECT_LT(sky(-0.1), sky(0.1));
  // The sun's disc sets: what is left of it falls evenly
  double before = Luminance(air.SunIrradiance(At(0.5, 0)));
  for (double sun_deg = 0.45; sun_deg > -0.4; sun_deg -= 0.05) {
    const double now = Luminance(air.SunIrradiance(At(sun_deg, 0)));
    EXPECT_LE(now, before);
    EXPECT_LT(before - now, 0.3 * Luminance(air.SunIrradiance(At(0.5, 0))));
    before = now;
  }
  EXPECT_EQ(before, 0.0);
  EXPECT_GT(ElevationOf(SeenPartOfSun(At(-0.1, 0))), 0);
  EXPECT_NEAR(ElevationOf(SeenPartOfSun(At(0.2664, 0))), RadFromDeg(0.2664), 1e-5);
  EXPECT_EQ(SeenPartOfSun(At(20, 0)), At(20, 0));
}

TEST(Atmosphere, NightFallsAndTheSkyTurnsBlueOverARedHorizon) {
  const Atmosphere air;
  double before = 1e9;
  for (double sun_deg = 4; sun_deg >= -6; sun_deg -= 1) {
    const double now = Luminance(air.SkyRadiance(At(sun_deg, 0), At(60, 90)));
    EXPECT_LT(now, before) << sun_deg;
    before = now;
  }
  const Eigen::Array3d low_sun = air.SunIrradiance(At(1, 0));
  EXPECT_GT(low_sun[0], 2 * low_sun[1]);  // Deep orange
  const Eigen::Array3d high_sun = air.SunIrradiance(At(60, 0));
  EXPECT_NEAR(high_sun[0] / high_sun[1], 1.1, 0.15);  // Nearly white
  const Eigen::Array3d glow = air.SkyRadiance(At(-3, 0), At(2, 0));
  const Eigen::Array3d above = air.SkyRadiance(At(-3, 0), At(70, 180));
  EXPECT_GT(glow[0], glow[2]);    // Orange where the sun went
  EXPECT_GT(above[2], above[0]);  // Blue overhead
}

TEST(Atmosphere, HazeTakesFromTheSunAndTheGroundGivesToTheSky) {
  const Atmosphere clear({.turbidity = 2}), hazy({.turbidity = 6});
  const Eigen::Vector3d sun = At(40, 0);
  EXPECT_LT(Luminance(hazy.SunIrradiance(sun)), Luminance(clear.SunIrradiance(sun)));
  EXPECT_GT(Luminance(hazy.SkyRadiance(sun, At(20, 90))),
            Luminance(clear.SkyRadiance(sun, At(20, 90))));
  const Atmosphere dark({.ground_albedo = 0}), snow({.ground_albedo = 0.8});
  EXPECT_GT(Luminance(snow.SkyRadiance(sun, At(60, 90))),
            1.05 * Luminance(dark.SkyRadiance(sun, At(60, 90))));
  EXPECT_THROW(Atmosphere({.turbidity = 0.5}), OptionError);
}

}  // namespace
}  // namespace relight
