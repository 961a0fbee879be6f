// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/daylight.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/sky/cabral2011_sun.h"
#include "relight/sky/preetham_sun.h"
#include "tests/support/made_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace relight {
namespace {

using tests::SunAt;

const Eigen::Vector3d kUp(0.3, 0.4, std::sqrt(0.75)), kDown(0.6, 0.0, -0.8);

TEST(Daylight, Cabral2011IsItsSunWithTheClampedSkyOfTurbidity42) {
  const SolarPosition sun = SunAt(140.0, 35.0);
  const Daylight day = MakeDaylight(sun, {.model = SkyModel::kCabral2011});
  EXPECT_TRUE((day.sun_irradiance == Cabral2011SunIrradiance(sun.direction)).all());
  const PreethamSky sky(sun.direction, {.turbidity = 4.2, .clamp = SkyClamp::kRec709});
  EXPECT_TRUE((day.SkyRadiance(kUp) == sky(kUp)).all());
  EXPECT_TRUE((day.SkyRadiance(kDown) == 0.0).all());
  EXPECT_EQ(day.sun_direction, sun.direction.normalized());

  const Daylight dusk = MakeDaylight(
      sun, {.model = SkyModel::kCabral2011, .turbidity = 4.2, .sunset_correction = true});
  EXPECT_TRUE((dusk.sun_irradiance < day.sun_irradiance).all());
}

TEST(Daylight, PreethamHasOneTurbidityForSunAndSky) {
  const SolarPosition sun = SunAt(140.0, 35.0);
  for (const double turbidity : {2.0, 3.0, 5.5}) {
    const Daylight day = MakeDaylight(sun, {.turbidity = turbidity});
    const Eigen::Array3d irradiance =
        PreethamSunIrradiance(sun.direction, {.turbidity = turbidity}).rgb_lx;
    EXPECT_TRUE((day.sun_irradiance == irradiance).all());
    const PreethamSky sky(sun.direction, {.turbidity = turbidity});
    EXPECT_TRUE((day.SkyRadiance(kUp) == sky(kUp)).all());
  }
  EXPECT_TRUE((MakeDaylight(sun).sun_irradiance ==
               MakeDaylight(sun, {.turbidity = 3.0}).sun_irradiance)
                  .all());
}

TEST(Daylight, AUniformSkyIsTheSameAboveTheHorizonOrEverywhere) {
  const Eigen::Array3d radiance(1.0, 2.0, 3.0);
  const Daylight half = UniformDaylight(radiance), full = UniformDaylight(radiance, true);
  EXPECT_TRUE((half.sun_irradiance == 0.0).all());
  EXPECT_TRUE((half.SkyRadiance(kUp) == radiance).all());
  EXPECT_TRUE((half.SkyRadiance(kDown) == 0.0).all());
  EXPECT_TRUE((full.SkyRadiance(kDown) == radiance).all());
}

TEST(Daylight, NightIsAnErrorThatSaysWhatToDo) {
  for (const SkyModel model : {SkyModel::kPreetham, SkyModel::kCabral2011}) {
    for (const double elevation_deg : {0.0, -0.5, -30.0}) {
      try {
        MakeDaylight(SunAt(270.0, elevation_deg), {.model = model});
        FAIL() << elevation_deg;
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("between sunrise and sunset"),
                  std::string::npos);
      }
    }
    EXPECT_NO_THROW(MakeDaylight(SunAt(270.0, 0.01), {.model = model}));
  }
}

TEST(Daylight, RefusesOptionsThatBelongToTheOtherModel) {
  const SolarPosition sun = SunAt(140.0, 35.0);
  EXPECT_THROW(MakeDaylight(sun, {.model = SkyModel::kCabral2011, .turbidity = 3.0}),
               OptionError);
  EXPECT_THROW(MakeDaylight(sun, {.sunset_correction = true}), OptionError);
  EXPECT_THROW(MakeDaylight(sun, {.turbidity = 0.5}), OptionError);
}

double Luminance(const Eigen::Array3d& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// Light on level ground, of the sky alone, by directions that all weigh the same there.
double GroundLux(const Daylight& day) {
  constexpr int kHeights = 60, kAzimuths = 120;
  double sum = 0;
  for (int i = 0; i < kHeights; ++i) {
    const double elevation_rad = std::asin(std::sqrt((i + 0.5) / kHeights));
    for (int j = 0; j < kAzimuths; ++j) {
      sum += Luminance(day.SkyRadiance(DirectionFromAzimuthElevation(
          (j + 0.25) * 2 * std::numbers::pi / kAzimuths, elevation_rad)));
    }
  }
  return sum * std::numbers::pi / (kHeights * kAzimuths);
}

double SunLux(const Daylight& day) {
  return Luminance(day.sun_irradiance) * day.sun_direction.z();
}

// Another grid of directions than the code's: sums part by some tenths of a percent
constexpr double kGrids = 0.01;

TEST(Daylight, CloudsLeaveWhatThePaperSays) {
  const SolarPosition sun = SunAt(140.0, 50.0);
  for (const SkyModel model : {SkyModel::kPreetham, SkyModel::kAtmosphere}) {
    const Daylight clear = MakeDaylight(sun, {.model = model});
    const double global = GroundLux(clear) + SunLux(clear);
    for (const double cloud : {0.25, 0.5, 0.9, 1.0}) {
      const Daylight day = MakeDaylight(sun, {.model = model, .cloud = cloud});
      const double left = 1 - 0.75 * std::pow(cloud, 3.4);
      EXPECT_NEAR((GroundLux(day) + SunLux(day)) / global, left, kGrids) << cloud;
      EXPECT_NEAR(SunLux(day) / SunLux(clear), left * (1 - cloud * cloud), 1e-12);
    }
  }
  // Under a whole cover a quarter is left, and it is that of the overcast sky
  const Daylight covered = MakeDaylight(sun, {.cloud = 1.0});
  const Daylight overcast = MakeDaylight(sun, {.model = SkyModel::kCie});
  EXPECT_TRUE((covered.SkyRadiance(kUp).isApprox(overcast.SkyRadiance(kUp), 1e-9)));
  EXPECT_TRUE((overcast.sun_irradiance == 0).all());
}

TEST(Daylight, EveryModelIsFiniteAndNotNegativeOverTheDome) {
  std::vector<DaylightOptions> all;
  for (const double turbidity : {1.7, 3.0, 6.0, 10.0}) {
    for (const SkyModel model : {SkyModel::kPreetham, SkyModel::kAtmosphere}) {
      for (const double cloud : {0.0, 0.5}) {
        all.push_back({.model = model, .turbidity = turbidity, .cloud = cloud});
      }
    }
  }
  for (int type = 1; type <= 15; ++type) {
    all.push_back({.model = SkyModel::kCie, .cie_type = type});
  }
  all.push_back({.model = SkyModel::kCabral2011});
  for (const DaylightOptions& options : all) {
    for (const double sun_deg : {0.1, 5.0, 40.0, 90.0}) {
      const Daylight day = MakeDaylight(SunAt(10.0, sun_deg), options);
      EXPECT_TRUE(day.sun_irradiance.isFinite().all());
      for (double elevation_deg = 0; elevation_deg <= 90; elevation_deg += 5) {
        for (double azimuth_deg = 10; azimuth_deg < 370; azimuth_deg += 30) {
          const Eigen::Array3d radiance = day.SkyRadiance(DirectionFromAzimuthElevation(
              RadFromDeg(azimuth_deg), RadFromDeg(elevation_deg)));
          EXPECT_TRUE(radiance.isFinite().all());
          EXPECT_GE(Luminance(radiance), 0)
              << static_cast<int>(options.model) << " " << options.cie_type << " "
              << sun_deg << " " << elevation_deg;
        }
      }
    }
  }
}

TEST(Daylight, TheSameSunGivesTheSameLightWhereverOnEarth) {
  // Light depends on the sun's place in the sky alone: turned about the vertical it turns
  for (const SkyModel model : {SkyModel::kPreetham, SkyModel::kAtmosphere}) {
    const Daylight a = MakeDaylight(SunAt(30.0, 35.0), {.model = model});
    const Daylight b = MakeDaylight(SunAt(210.0, 35.0), {.model = model});
    EXPECT_TRUE(a.sun_irradiance.isApprox(b.sun_irradiance, 1e-12));
    const Eigen::Vector3d turned(-kUp.x(), -kUp.y(), kUp.z());
    EXPECT_TRUE(a.SkyRadiance(kUp).isApprox(b.SkyRadiance(turned), 1e-9));
  }
}

TEST(Daylight, OnlyTheAtmosphereHasATwilight) {
  const Daylight dusk =
      MakeDaylight(SunAt(270.0, -4.0), {.model = SkyModel::kAtmosphere});
  EXPECT_TRUE((dusk.sun_irradiance == 0).all());
  EXPECT_GT(GroundLux(dusk), 1);  // Some tens of lux
  EXPECT_LT(GroundLux(dusk), 1000);
  EXPECT_THROW(MakeDaylight(SunAt(270.0, -6.5), {.model = SkyModel::kAtmosphere}),
               InputError);
  EXPECT_THROW(MakeDaylight(SunAt(270.0, -1.0), {.model = SkyModel::kCie}), InputError);
  EXPECT_THROW(MakeDaylight(SunAt(270.0, 30.0), {.model = SkyModel::kCie, .cloud = 0.5}),
               OptionError);
}

}  // namespace
}  // namespace relight
