// SPDX-License-Identifier: Apache-2.0
#include "relight/ratio/mean_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace relight {
namespace {

// Sums of a few floats over the pyramid's levels.
constexpr float kFloat = 1e-5f;

struct Field {
  cv::Mat3f irradiance;
  cv::Mat1f weight;
  cv::Mat1b inside;
};

// Light 1 to 2 from left to right, weights of 0.05 to 1, all inside.
Field Ramp(const cv::Size& size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(0.05f, 1.0f);
  Field field{cv::Mat3f(size), cv::Mat1f(size), cv::Mat1b(size, 255)};
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const float light =
          1.0f + static_cast<float>(column) / static_cast<float>(size.width);
      field.weight(row, column) = uniform(random);
      field.irradiance(row, column) =
          cv::Vec3f(light, 2 * light, 3 * light) * field.weight(row, column);
    }
  }
  return field;
}

// (R1), to the last bit.
TEST(MeanLight, IsIrradianceOverWeightWhereTheWeightIsFull) {
  const Field field = Ramp({33, 21}, 1);
  const cv::Mat3f light = MeanLight(field.irradiance, field.weight, field.inside);
  for (int row = 0; row < light.rows; ++row) {
    for (int column = 0; column < light.cols; ++column) {
      EXPECT_EQ(light(row, column),
                cv::Vec3f(field.irradiance(row, column) / field.weight(row, column)));
    }
  }
}

// (R2) by hand where the neighbours all have one light: half of it, and half of theirs.
TEST(MeanLight, BlendsWithTheNeighboursWhereTheWeightIsSmall) {
  const cv::Size size(16, 16);
  cv::Mat3f irradiance(size, cv::Vec3f(0.8f, 0.4f, 0.2f));
  cv::Mat1f weight(size, 1.0f);
  const cv::Mat1b inside(size, 255);
  weight(8, 8) = 0.025f;  // Half of full
  irradiance(8, 8) = cv::Vec3f(0.1f, 0.1f, 0.1f);
  const cv::Mat3f light = MeanLight(irradiance, weight, inside);
  // Its own light is 4; N blends it with what is around, each by its weight
  for (int c = 0; c < 3; ++c) {
    const float around = irradiance(0, 0)[c];
    const float neighbours = (light(8, 8)[c] - 0.5f * 4.0f) / 0.5f;
    EXPECT_GT(neighbours, around);
    EXPECT_LT(neighbours, 4.0f);
    // At its own level: (0.1 + 0.05 x coarser) / (0.025 + 0.05), where the coarser
    // level's light is that of 4 and more pixels, of which 3 of weight 1 are around
    EXPECT_NEAR(neighbours, (0.1f + 0.05f * around) / 0.075f, 0.05f * (4 - around));
  }
}

TEST(MeanLight, FillsAnyGapFromItsNeighbours) {
  for (const cv::Size& size : {cv::Size(64, 48), cv::Size(37, 51), cv::Size(1, 9)}) {
    Field field = Ramp(size, 2);
    field.irradiance.colRange(0, size.width).setTo(cv::Vec3f(3, 2, 1));
    field.weight.setTo(1);
    const cv::Rect gap(0, size.height / 4, size.width, size.height / 2);
    field.irradiance(gap).setTo(cv::Vec3f(0, 0, 0));
    field.weight(gap).setTo(0);
    const cv::Mat3f light = MeanLight(field.irradiance, field.weight, field.inside);
    for (const cv::Vec3f& pixel : light) {
      // All the light there is is the same, so the gap takes just that
      EXPECT_NEAR(pixel[0], 3, kFloat);
      EXPECT_NEAR(pixel[1], 2, kFloat);
      EXPECT_NEAR(pixel[2], 1, kFloat);
    }
  }
}

// A gap between dark and bright is between the two, and nearer to the nearer.
TEST(MeanLight, AGapTakesTheNearerSide) {
  const cv::Size size(64, 64);
  cv::Mat3f irradiance(size, cv::Vec3f::all(1));
  irradiance.colRange(32, 64).setTo(cv::Vec3f::all(5));
  cv::Mat1f weight(size, 1.0f);
  irradiance.colRange(20, 44).setTo(cv::Vec3f::all(0));
  weight.colRange(20, 44).setTo(0);
  const cv::Mat3f light = MeanLight(irradiance, weight, cv::Mat1b(size, 255));
  for (int row = 0; row < 64; ++row) {
    for (int column = 20; column < 44; ++column) {
      EXPECT_GE(light(row, column)[0], 1 - kFloat);
      EXPECT_LE(light(row, column)[0], 5 + kFloat);
    }
    EXPECT_LT(light(row, 21)[0], 2.0f);
    EXPECT_GT(light(row, 42)[0], 4.0f);
  }
}

TEST(MeanLight, NothingOutsideTheMatteIsReadOrWritten) {
  Field field = Ramp({40, 30}, 3);
  cv::Mat1b left(field.inside.size(), static_cast<unsigned char>(0));
  left.colRange(0, 20).setTo(255);
  field.weight.colRange(5, 12).setTo(0);  // A gap, to be filled
  field.irradiance.colRange(5, 12).setTo(cv::Vec3f::all(0));
  const cv::Mat3f light = MeanLight(field.irradiance, field.weight, left);
  cv::Mat3f elsewhere = field.irradiance.clone();
  elsewhere.colRange(20, 40).setTo(cv::Vec3f::all(1e6f));
  EXPECT_EQ(cv::norm(light, MeanLight(elsewhere, field.weight, left), cv::NORM_INF), 0.0);
  EXPECT_EQ(cv::norm(light.colRange(20, 40), cv::NORM_INF), 0.0);
  EXPECT_GT(light(15, 8)[0], 1.0f);
}

TEST(MeanLight, WithoutAnyVolumeThereIsNoLight) {
  const cv::Size size(13, 7);
  const cv::Mat3f light = MeanLight(
      cv::Mat3f(size, cv::Vec3f::all(0)), cv::Mat1f(size, 0.0f), cv::Mat1b(size, 255));
  EXPECT_EQ(cv::norm(light, cv::NORM_INF), 0.0);
}

// A light that is the same everywhere stays so, whatever the weights and the blur.
TEST(MeanLight, SmoothingKeepsAConstantLight) {
  Field field = Ramp({50, 40}, 4);
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 50; ++column) {
      field.weight(row, column) *= column % 3 == 0 ? 0.0f : 1.0f;
      field.irradiance(row, column) = cv::Vec3f(7, 5, 3) * field.weight(row, column);
    }
  }
  const cv::Mat3f light =
      MeanLight(field.irradiance, field.weight, field.inside, {.smoothing_px = 2.5});
  for (const cv::Vec3f& pixel : light) {
    EXPECT_NEAR(pixel[0], 7, 7 * kFloat);
    EXPECT_NEAR(pixel[2], 3, 7 * kFloat);
  }
}

}  // namespace
}  // namespace relight
