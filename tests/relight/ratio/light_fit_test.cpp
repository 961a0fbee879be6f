// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/light_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace relight {
namespace {

// A crown of `side` pixels whose sun falls off to the right and sky downwards, seen under
// e^k times the sky, with noise of `spread` in the logarithm.
struct Crown {
  IrradianceImage light;
  cv::Mat3f colors;
  cv::Mat1f alpha;

  Crown(double k, double spread, bool alike = false, int side = 200)
      : light{cv::Mat3f(side, side), cv::Mat3f(side, side), cv::Mat3f(side, side)},
        colors(side, side),
        alpha(side, side, 1.0f) {
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, spread);
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        const double sun = std::exp(-4.0 * column / side);
        const double sky = alike ? 0.4 * sun : 0.1 + 0.3 * row / side;
        light.sun(row, column) = cv::Vec3f::all(static_cast<float>(sun));
        light.sky(row, column) = cv::Vec3f::all(static_cast<float>(sky));
        light.indirect(row, column) = {};
        colors(row, column) = cv::Vec3f::all(static_cast<float>(
            0.02 * (sun + std::exp(k) * sky) * std::exp(noise(random))));
      }
    }
  }
  SkyFit Fit() const { return FitSky(ShadingOf(light, colors, alpha)); }
};

TEST(LightFit, FindsTheSkyThatAPictureWasMadeWith) {
  for (const double k : {-0.5, 0.0, 0.4}) {
    const SkyFit fit = Crown(k, 0.5).Fit();
    // Patches average 100 pixels, so that noise is 0.05 each; what the prior takes is
    // less than the deviation
    EXPECT_NEAR(fit.sky.log_value, k, 0.03 + 2 * fit.sky.deviation) << k;
    EXPECT_LT(fit.sky.deviation, 0.05) << k;
    EXPECT_FALSE(fit.sky.flat) << k;
    EXPECT_LE(fit.spread, fit.unfitted + 1e-12) << k;
  }
}

// Light that shades alike from sun and sky tells nothing: what was believed before stays.
TEST(LightFit, IsFlatWhereSunAndSkyShadeAlike) {
  const SkyFit fit = Crown(0.5, 0.3, true).Fit();
  EXPECT_TRUE(fit.sky.flat);
  EXPECT_NEAR(fit.sky.log_value, 0, 0.05);
  EXPECT_NEAR(fit.sky.deviation, 0.3, 0.02);
}

TEST(LightFit, ATreeOfFewPatchesTellsNothing) {
  Crown crown(0.5, 0.1);
  crown.alpha = 0.0f;
  EXPECT_TRUE(crown.Fit().sky.flat);
  EXPECT_EQ(crown.Fit().sky.log_value, 0);
}

TEST(LightFit, FindsTheScaleOfAParabola) {
  const std::vector<double> scales = {-0.7, -0.35, 0, 0.35, 0.7};
  std::vector<double> costs, flat(5, 3.0);
  for (const double s : scales) costs.push_back(0.5 * 100 * (s - 0.2) * (s - 0.2));
  const FittedNumber fit = FitScale(scales, costs);
  const double of_prior = 1 / 0.09;  // Two parabolas add up
  EXPECT_NEAR(fit.log_value, 0.2 * 100 / (100 + of_prior), 1e-9);
  EXPECT_NEAR(fit.deviation, 1 / std::sqrt(100 + of_prior), 1e-9);
  EXPECT_FALSE(fit.flat);
  EXPECT_TRUE(FitScale(scales, flat).flat);
  EXPECT_NEAR(FitScale(scales, flat).log_value, 0, 1e-9);
}

}  // namespace
}  // namespace relight
