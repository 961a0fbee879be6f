// SPDX-License-Identifier: Apache-2.0
#include "relight/sh/projection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace relight {
namespace {

using std::numbers::pi;

constexpr double kRounding = 1e-12;

ShCoefficients RandomCoefficients(int bands, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  return ShCoefficients::NullaryExpr(
      ShCount(bands), 3, [&](auto, auto) { return normal(random); });
}

Eigen::Array3d Evaluate(const ShCoefficients& coefficients,
                        int bands,
                        const Eigen::Vector3d& direction) {
  return (SphericalHarmonics(direction, bands).transpose() * coefficients)
      .transpose()
      .array();
}

TEST(Projection, ReturnsTheCoefficientsOfASum) {
  for (const int bands : {1, 2, 6, 8}) {
    const ShCoefficients coefficients = RandomCoefficients(bands, /*seed=*/5);
    const ShCoefficients again = ProjectColorOnSh(
        [&](const Eigen::Vector3d& d) { return Evaluate(coefficients, bands, d); },
        bands);
    EXPECT_LT((again - coefficients).cwiseAbs().maxCoeff(), kRounding);
  }
}

TEST(Projection, AConstantHasOneCoefficient) {
  const Eigen::VectorXd c = ProjectOnSh([](const Eigen::Vector3d&) { return 3.0; });
  EXPECT_NEAR(c(0), 3.0 * std::sqrt(4 * pi), kRounding);
  EXPECT_LT(c.tail(35).cwiseAbs().maxCoeff(), kRounding);
}

// max(0, z): sqrt(pi) / 2, sqrt(pi / 3), sqrt(5 pi) / 8, 0, -sqrt(pi) / 16, 0 on the
// axis.
TEST(Projection, TheClampedCosineHasItsClosedForm) {
  const Eigen::VectorXd c =
      ProjectOnSh([](const Eigen::Vector3d& d) { return std::max(0.0, d.z()); });
  EXPECT_NEAR(c(ShIndex(0, 0)), std::sqrt(pi) / 2, kRounding);
  EXPECT_NEAR(c(ShIndex(1, 0)), std::sqrt(pi / 3), kRounding);
  EXPECT_NEAR(c(ShIndex(2, 0)), std::sqrt(5 * pi) / 8, kRounding);
  EXPECT_NEAR(c(ShIndex(3, 0)), 0.0, kRounding);
  EXPECT_NEAR(c(ShIndex(4, 0)), -std::sqrt(pi) / 16, kRounding);
  EXPECT_NEAR(c(ShIndex(5, 0)), 0.0, kRounding);
}

// Turned then evaluated is evaluated then turned.
TEST(Projection, TurningTheCoefficientsTurnsTheFunction) {
  const ShCoefficients coefficients = RandomCoefficients(6, /*seed=*/9);
  for (const double angle_rad : {0.3, 1.0, -2.5, 6.0}) {
    const ShCoefficients turned = TurnedAboutZ(coefficients, angle_rad);
    for (const Eigen::Vector3d& direction : SphereDirections(20)) {
      const double c = std::cos(angle_rad), s = std::sin(angle_rad);
      const Eigen::Vector3d back(c * direction.x() + s * direction.y(),
                                 -s * direction.x() + c * direction.y(),
                                 direction.z());
      EXPECT_TRUE(Evaluate(turned, 6, direction)
                      .isApprox(Evaluate(coefficients, 6, back), kRounding));
    }
  }
}

// Under any rotation the power of a band stays what it is.
TEST(Projection, TheBandsKeepTheirPowerInAnyFrame) {
  const ShCoefficients coefficients = RandomCoefficients(6, /*seed=*/2);
  Eigen::Matrix3d mirror_of_axes;  // x to y, y to z, z to x: a rotation by 120 degrees
  mirror_of_axes << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  const ShCoefficients turned = ProjectColorOnSh(
      [&](const Eigen::Vector3d& d) -> Eigen::Array3d {
        return Evaluate(coefficients, 6, mirror_of_axes.transpose() * d);
      },
      6);
  for (int l = 0; l < 6; ++l) {
    EXPECT_TRUE(
        turned.middleRows(l * l, 2 * l + 1)
            .colwise()
            .squaredNorm()
            .isApprox(coefficients.middleRows(l * l, 2 * l + 1).colwise().squaredNorm(),
                      1e-11));  // Rounding of 9216 terms
  }
  EXPECT_GT((turned - coefficients).cwiseAbs().maxCoeff(), 0.1);  // It did turn
}

// The integral of a product is the product of the coefficients.
TEST(Projection, TheDotProductIsTheIntegralOfTheProduct) {
  const ShCoefficients a = RandomCoefficients(6, 3), b = RandomCoefficients(6, 4);
  double integral = 0.0;
  for (const auto& [direction, weight_sr] : SphereQuadrature()) {
    integral += weight_sr * (Evaluate(a, 6, direction) * Evaluate(b, 6, direction)).sum();
  }
  EXPECT_NEAR(integral, a.cwiseProduct(b).sum(), 1e-11);  // Rounding of 9216 terms
}

}  // namespace
}  // namespace relight
