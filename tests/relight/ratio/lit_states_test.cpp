// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/lit_states.h"

#include "relight/base/angles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace relight {
namespace {

using Pixels = std::array<float, LuminanceBins::kCount>;

Pixels AllIn(double relative_luminance) {
  Pixels pixels{};
  pixels[static_cast<std::size_t>(LuminanceBins::Of(relative_luminance))] = 1;
  return pixels;
}

PatchLight FarApart() {
  return {.lit_now = 0.4,
          .lit_then = 0.3,
          .lit_both = 0.2,
          .sky_now = 1,
          .sky_then = 0.8,
          .sun_now = 6,
          .sun_then = 4,
          .between_suns_rad = RadFromDeg(70)};
}

TEST(LitStates, EqualHoursHaveTheRatioOne) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 200; ++trial) {
    Pixels pixels;
    for (float& weight : pixels) weight = static_cast<float>(uniform(random));
    const double lit = uniform(random), sky = 0.1 + uniform(random);
    const double sun = 10 * uniform(random);
    // Samples are lit in part: the mean of squares is below the mean
    const PatchLight light{.lit_now = lit,
                           .lit_then = lit,
                           .lit_both = lit * (lit + (1 - lit) * uniform(random)),
                           .sky_now = sky,
                           .sky_then = sky,
                           .sun_now = sun,
                           .sun_then = sun,
                           .between_suns_rad = 0};
    EXPECT_NEAR(EstimateLitStates(pixels, light, 0.3, 0.6).ratio, 1, 1e-12);
  }
}

TEST(LitStates, BrightPixelsAreInTheSun) {
  const PatchLight light = FarApart();
  double last = 0;
  for (int bin = 0; bin < LuminanceBins::kCount; ++bin) {
    const double share =
        EstimateLitStates(AllIn(LuminanceBins::Center(bin)), light, 0.25, 0.5).lit_share;
    EXPECT_GE(share, last);
    last = share;
  }
  EXPECT_GT(last, 0.99);
  EXPECT_LT(EstimateLitStates(AllIn(0.1), light, 0.25, 0.5).lit_share, 0.01);
}

// Without a sun now, pixels tell nothing: the ratio is that of the mean light.
TEST(LitStates, WithoutASunTheRatioIsThatOfTheMeans) {
  PatchLight light = FarApart();
  light.sun_now = 0;
  const double means = light.sky_then + light.sun_then * light.lit_then;
  for (const double luminance : {0.05, 0.4, 3.0}) {
    const LitStates states = EstimateLitStates(AllIn(luminance), light, 0.25, 0.5);
    constexpr double kSameSun = 1e-6;  // h of 70 degrees is not quite 0
    EXPECT_NEAR(states.lit_share, light.lit_now, 1e-12);
    EXPECT_NEAR(states.ratio, means / light.sky_now, kSameSun);
  }
}

// Leaves drawn as the model has them, photographed and lit anew one by one.
TEST(LitStates, AgreesWithLeavesDrawnOneByOne) {
  const PatchLight light = FarApart();
  constexpr double kReflectance = 0.25, kSpread = 0.5;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  Pixels pixels{};
  double before = 0, after = 0, lit_sum = 0;
  constexpr int kLeaves = 400000;
  for (int leaf = 0; leaf < kLeaves; ++leaf) {
    const bool is_lit = uniform(random) < light.lit_now;
    const double lit_then = is_lit
                                ? light.lit_both / light.lit_now
                                : (light.lit_then - light.lit_both) / (1 - light.lit_now);
    const double albedo =
        kReflectance * std::exp(kSpread * normal(random) - kSpread * kSpread / 2);
    const double now = light.sky_now + (is_lit ? light.sun_now : 0);
    const double then =
        light.sky_then + (uniform(random) < lit_then ? light.sun_then : 0);
    pixels[static_cast<std::size_t>(LuminanceBins::Of(albedo * now))] += 1;
    before += albedo * now;
    after += albedo * then;
    lit_sum += is_lit;
  }
  const LitStates states = EstimateLitStates(pixels, light, kReflectance, kSpread);
  constexpr double kBins = 0.02;  // Of 0.4 in ln: a pixel is taken for its bin's middle
  EXPECT_NEAR(states.ratio / (after / before), 1, kBins);
  EXPECT_NEAR(states.lit_share, lit_sum / kLeaves, 0.01);
}

TEST(LitStates, NoPixelsChangeNothing) {
  const LitStates states = EstimateLitStates({}, FarApart(), 0.25, 0.5);
  EXPECT_EQ(states.ratio, 1);
  EXPECT_EQ(states.lit_share, 0);
}

}  // namespace
}  // namespace relight
