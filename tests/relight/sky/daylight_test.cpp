// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/daylight.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/sky/cabral2011_sun.h"
#include "relight/sky/preetham_sun.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

SolarPosition SunAt(double azimuth_deg, double elevation_deg) {
  const double azimuth_rad = RadFromDeg(azimuth_deg),
               elevation_rad = RadFromDeg(elevation_deg);
  return {azimuth_rad,
          elevation_rad,
          DirectionFromAzimuthElevation(azimuth_rad, elevation_rad)};
}

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

}  // namespace
}  // namespace relight
