// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/sky_turbidity.h"

#include "relight/base/angles.h"
#include "relight/sky/preetham_sky.h"

#include <gtest/gtest.h>

#include <vector>

namespace relight {
namespace {

// What photos of different exposures show of a sky, from 8 to 38 degrees.
std::vector<SkySample> SamplesOf(double turbidity, double sun_elevation_deg) {
  const Eigen::Vector3d sun =
      DirectionFromAzimuthElevation(0, RadFromDeg(sun_elevation_deg));
  const PreethamSky sky(sun, {.turbidity = turbidity});
  std::vector<SkySample> samples;
  for (int photo = 0; photo < 3; ++photo) {
    for (int i = 0; i < 7; ++i) {
      for (int j = 0; j < 4; ++j) {
        const Eigen::Vector3d direction = DirectionFromAzimuthElevation(
            RadFromDeg(90 * photo + 60 + 5 * j), RadFromDeg(8 + 5 * i));
        samples.push_back({direction, sun, (1 << photo) * 1e-4 * sky(direction), photo});
      }
    }
  }
  return samples;
}

TEST(SkyTurbidity, GivesBackThatOfTheModelWhateverTheExposure) {
  // The prior of (K9) draws towards 3: by 12 % at most between 2 and 6
  for (const double turbidity : {2.5, 3.0, 4.2, 6.0}) {
    for (const double elevation_deg : {15.0, 45.0, 75.0}) {
      const TurbidityEstimate air = TurbidityFromSky(SamplesOf(turbidity, elevation_deg));
      EXPECT_TRUE(air.sure) << turbidity << " " << elevation_deg << " " << air.doubt;
      EXPECT_NEAR(std::log(air.turbidity / turbidity), 0, 0.12)
          << turbidity << " " << elevation_deg;
      EXPECT_EQ(air.photos, 3);
    }
  }
}

TEST(SkyTurbidity, FewWrongSamplesPullLittle) {
  std::vector<SkySample> samples = SamplesOf(3.0, 45.0);
  const double clean = TurbidityFromSky(samples).turbidity;
  for (std::size_t i = 0; i < samples.size(); i += 10) samples[i].color = {0.5, 0.2, 0.1};
  // One in ten at the full slope of Huber's loss
  EXPECT_NEAR(TurbidityFromSky(samples).turbidity, clean, 0.35);
}

TEST(SkyTurbidity, IsFoundUnderColorsThatTheCameraDeepens) {
  // Only how the colours change over the sky, and the gradient, still tell it
  for (const double turbidity : {2.3, 3.0, 4.0}) {
    std::vector<SkySample> samples = SamplesOf(turbidity, 45.0);
    for (SkySample& sample : samples) {
      const double green = sample.color[1];
      sample.color = green * (sample.color / green).pow(2.0);
    }
    const TurbidityEstimate air = TurbidityFromSky(samples);
    EXPECT_TRUE(air.sure) << turbidity << " " << air.doubt;
    EXPECT_NEAR(air.deepened, 2.0, 0.4) << turbidity;
    EXPECT_NEAR(std::log(air.turbidity / turbidity), 0, 0.25) << turbidity;
  }
  EXPECT_EQ(TurbidityFromSky(SamplesOf(3.0, 45.0)).deepened, 1.0);
}

TEST(SkyTurbidity, IsNotSureOfCloudsNorOfALittleSky) {
  std::vector<SkySample> grey = SamplesOf(3.0, 45.0);
  for (SkySample& sample : grey) sample.color = {0.5, 0.5, 0.5};
  EXPECT_FALSE(TurbidityFromSky(grey).sure);
  EXPECT_GT(TurbidityFromSky(grey).misfit, 0.15);
  std::vector<SkySample> red = SamplesOf(3.0, 45.0);
  for (SkySample& sample : red) sample.color = {0.6, 0.3, 0.2};
  EXPECT_FALSE(TurbidityFromSky(red).sure);
  const std::vector<SkySample> all = SamplesOf(3.0, 45.0);
  const TurbidityEstimate few = TurbidityFromSky(std::span(all).first(10));
  EXPECT_FALSE(few.sure);
  EXPECT_EQ(few.turbidity, 3.0);
  EXPECT_FALSE(TurbidityFromSky({}).sure);
}

TEST(SkyTurbidity, LeavesOutTheHorizonAndTheSunsGlare) {
  std::vector<SkySample> samples = SamplesOf(3.0, 45.0);
  const std::size_t used = samples.size();
  const Eigen::Vector3d sun = samples[0].sun_in_world;
  samples.push_back({DirectionFromAzimuthElevation(1, RadFromDeg(3)), sun, {1, 1, 1}, 0});
  samples.push_back(
      {DirectionFromAzimuthElevation(0, RadFromDeg(50)), sun, {1, 1, 1}, 0});
  EXPECT_EQ(TurbidityFromSky(samples).samples, static_cast<int>(used));
}

}  // namespace
}  // namespace relight
