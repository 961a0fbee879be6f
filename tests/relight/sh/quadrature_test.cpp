// SPDX-License-Identifier: Apache-2.0
#include "relight/sh/quadrature.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace relight {
namespace {

using std::numbers::pi;

template <class Function>
double Integral(const Function& f, const SphereQuadratureOptions& options = {}) {
  double sum = 0.0;
  for (const auto& [direction, weight_sr] : SphereQuadrature(options)) {
    sum += weight_sr * f(direction);
  }
  return sum;
}

constexpr double kRounding = 1e-12;

TEST(SphereQuadrature, KnowsTheIntegralsOfPowers) {
  using Vector = Eigen::Vector3d;
  EXPECT_NEAR(Integral([](const Vector&) { return 1.0; }), 4 * pi, kRounding);
  EXPECT_NEAR(
      Integral([](const Vector& d) { return d.z() * d.z(); }), 4 * pi / 3, kRounding);
  EXPECT_NEAR(
      Integral([](const Vector& d) { return d.x() * d.x(); }), 4 * pi / 3, kRounding);
  EXPECT_NEAR(Integral([](const Vector& d) { return std::pow(d.x() * d.y(), 2); }),
              4 * pi / 15,
              kRounding);
  EXPECT_NEAR(Integral([](const Vector& d) { return d.x(); }), 0.0, kRounding);
}

// 2 n - 1 is the degree that n nodes a side integrate, and no more.
TEST(SphereQuadrature, HasTheDegreeItPromises) {
  for (const int n : {1, 2, 5, 16}) {
    const auto power = [&](int degree) {
      return Integral(
          [&](const Eigen::Vector3d& d) { return std::pow(std::abs(d.z()), degree); },
          {.heights_per_side = n, .azimuths = 1});
    };
    EXPECT_NEAR(power(2 * n - 1), 4 * pi / (2 * n), kRounding);
    if (n <= 5) {
      EXPECT_GT(std::abs(power(2 * n) - 4 * pi / (2 * n + 1)), 1e-7);
    }
  }
}

TEST(SphereQuadrature, SeesAStepAtTheHorizonExactly) {
  EXPECT_NEAR(Integral([](const Eigen::Vector3d& d) { return d.z() > 0 ? 1.0 : 0.0; }),
              2 * pi,
              kRounding);
  EXPECT_NEAR(Integral([](const Eigen::Vector3d& d) { return std::max(0.0, d.z()); }),
              pi,
              kRounding);
}

TEST(SphereDirections, AreUnitVectorsThatBalance) {
  for (const int count : {1, 2, 64, 512, 4096}) {
    const auto directions = SphereDirections(count);
    ASSERT_EQ(directions.size(), static_cast<std::size_t>(count));
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& direction : directions) {
      EXPECT_NEAR(direction.norm(), 1.0, kRounding);
      mean += direction / count;
    }
    if (count >= 64) {
      EXPECT_LT(mean.norm(), 1.0 / count);  // Random ones would have 1 / sqrt(count)
    }
  }
}

// No two are nearer than 0.8 of the spacing sqrt(4 pi / n) of a square lattice: the
// golden angle keeps them apart at every latitude.
TEST(SphereDirections, KeepApart) {
  const auto directions = SphereDirections(512);
  double nearest = 4.0;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      nearest = std::min(nearest, (directions[i] - directions[j]).norm());
    }
  }
  EXPECT_GT(nearest, 0.8 * std::sqrt(4 * pi / 512));
}

}  // namespace
}  // namespace relight
