// SPDX-License-Identifier: Apache-2.0
#include "relight/sh/basis.h"

#include "relight/sh/quadrature.h"
#include "tests/support/csv_table.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace relight {
namespace {

// The table has 15 digits; its own directions are unit vectors to 1e-15.
TEST(SphericalHarmonics, AgreesWithTheTable) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/sky/sh36.csv");
  const auto rows = tests::ReadCsv(tests::SharedPath("reference/sky/sh36.csv"));
  ASSERT_GE(rows.size(), 50u);
  double worst = 0.0;
  for (const auto& row : rows) {
    const auto values = SphericalHarmonics<kSkyBands>({row["x"], row["y"], row["z"]});
    for (int l = 0; l < kSkyBands; ++l) {
      for (int m = -l; m <= l; ++m) {
        const double expected = row["Y_" + std::to_string(l) + "_" + std::to_string(m)];
        worst = std::max(worst, std::abs(values(ShIndex(l, m)) - expected));
      }
    }
  }
  std::printf("worst %.1e\n", worst);
  EXPECT_LT(worst, 1e-12);
}

TEST(SphericalHarmonics, IsOrthonormal) {
  constexpr int kBands = 10;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(ShCount(kBands), ShCount(kBands));
  // Products are polynomials of degree 18 with 18 waves: 10 heights and 20 azimuths are
  // exact
  for (const auto& [direction, weight_sr] :
       SphereQuadrature({.heights_per_side = 10, .azimuths = 20})) {
    const Eigen::VectorXd values = SphericalHarmonics(direction, kBands);
    gram += weight_sr * values * values.transpose();
  }
  EXPECT_LT(
      (gram - Eigen::MatrixXd::Identity(gram.rows(), gram.cols())).cwiseAbs().maxCoeff(),
      1e-12);  // Rounding
}

// sum_m Y_lm(a) Y_lm(b) = (2 l + 1) / (4 pi) P_l(a . b): holds for any pair of
// directions, so it holds after any rotation.
TEST(SphericalHarmonics, ObeysTheAdditionTheorem) {
  const auto directions = SphereDirections(30);
  for (const Eigen::Vector3d& a : directions) {
    for (const Eigen::Vector3d& b : directions) {
      const Eigen::VectorXd in_a = SphericalHarmonics(a, 8),
                            in_b = SphericalHarmonics(b, 8);
      for (int l = 0; l < 8; ++l) {
        double sum = 0.0;
        for (int m = -l; m <= l; ++m) sum += in_a(ShIndex(l, m)) * in_b(ShIndex(l, m));
        const double cosine = std::min(1.0, std::max(-1.0, a.dot(b)));
        EXPECT_NEAR(
            sum, (2 * l + 1) / (4 * std::numbers::pi) * std::legendre(l, cosine), 1e-12);
      }
    }
  }
}

TEST(SphericalHarmonics, BothFormsAgreeAndSmallIsAPartOfLarge) {
  const Eigen::Vector3d direction = SphereDirections(7)[3];
  const Eigen::VectorXd large = SphericalHarmonics(direction, kMaxShBands);
  EXPECT_TRUE((SphericalHarmonics<6>(direction) == large.head(36)));
  EXPECT_TRUE((SphericalHarmonics(direction, 1) == large.head(1)));
  EXPECT_THROW(SphericalHarmonics(direction, 0), std::logic_error);
  EXPECT_THROW(SphericalHarmonics(direction, kMaxShBands + 1), std::logic_error);
}

}  // namespace
}  // namespace relight
