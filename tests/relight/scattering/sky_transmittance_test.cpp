// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/sky_transmittance.h"

#include "relight/scattering/transmittance.h"
#include "relight/sh/basis.h"
#include "relight/sh/quadrature.h"
#include "relight/volume/ray_traversal.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <numbers>

namespace relight {
namespace {

// Sums of floats: 1e-7 x sqrt(directions) x 4 pi, with room.
constexpr double kFloatSum = 1e-4;

// (S1) as it stands, ray by ray in doubles.
TEST(SkyTransmittance, IsTheSumOverAllDirections) {
  const ExtinctionGrid grid = tests::RandomCanopy({6, 5, 7}, 0.2, 4.0, /*seed=*/4);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const SkyTransmittanceOptions options{.bands = 4, .directions = 300};
  const SkyTransmittance sky = ProjectTransmittance(grid, occupied, options);
  ASSERT_EQ(sky.bands, 4);
  ASSERT_EQ(sky.coefficients.size(), 16u);
  for (std::size_t v = 0; v < occupied.cell.size(); v += 5) {
    const Eigen::Vector3i& cell = occupied.cell[v];
    Eigen::VectorXd c = Eigen::VectorXd::Zero(16);
    for (const Eigen::Vector3d& direction : SphereDirections(options.directions)) {
      const Ray ray{grid.Center(cell.x(), cell.y(), cell.z()), direction};
      c += 4 * std::numbers::pi / options.directions *
           std::exp(-OpticalDepth(grid, ray)) * SphericalHarmonics(direction, 4);
    }
    for (std::size_t i = 0; i < 16; ++i) {
      EXPECT_NEAR(sky.coefficients[i][v], c(static_cast<Eigen::Index>(i)), kFloatSum);
    }
  }
}

// tau = 1 everywhere: sqrt(4 pi) in band 0 and nothing above it.
TEST(SkyTransmittance, AnEmptyVolumeHasBandZeroOnly) {
  ExtinctionGrid grid = tests::Slab({5, 5, 5}, 0.2, 0.0);
  grid.sigma_per_m[grid.Index(2, 2, 2)] = 1e-30f;
  const SkyTransmittance sky = ProjectTransmittance(grid, FindOccupied(grid));
  EXPECT_NEAR(sky.coefficients[0][0], std::sqrt(4 * std::numbers::pi), kFloatSum);
  for (std::size_t i = 1; i < sky.coefficients.size(); ++i) {
    // The lattice of directions is not a quadrature: an error of 1 / 1024 or less
    EXPECT_NEAR(sky.coefficients[i][0], 0.0, 1e-3) << i;
  }
}

// More bands only add to those that are there.
TEST(SkyTransmittance, FewerBandsAreTheFirstOfMore) {
  const ExtinctionGrid grid = tests::RandomCanopy({6, 5, 7}, 0.2, 4.0, /*seed=*/5);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const auto two = ProjectTransmittance(grid, occupied, {.bands = 2, .directions = 100});
  const auto five = ProjectTransmittance(grid, occupied, {.bands = 5, .directions = 100});
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(tests::SameBytes(two.coefficients[i], five.coefficients[i]));
  }
}

TEST(SkyTransmittance, DoesNotDependOnThreads) {
  const ExtinctionGrid grid = tests::RandomCanopy({13, 12, 14}, 0.1, 3.0, /*seed=*/6);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const auto with = [&](int threads) {
    const tests::WithThreads limit(threads);
    return ProjectTransmittance(grid, occupied, {.directions = 128});
  };
  const SkyTransmittance one = with(1), two = with(2);
  for (std::size_t i = 0; i < one.coefficients.size(); ++i) {
    EXPECT_TRUE(tests::SameBytes(one.coefficients[i], two.coefficients[i]));
  }
}

TEST(SkyTransmittance, RefusesOptionsOutOfRangeAndStops) {
  const ExtinctionGrid grid = tests::Slab({3, 3, 3}, 0.2, 1.0);
  const OccupiedVoxels occupied = FindOccupied(grid);
  EXPECT_THROW(ProjectTransmittance(grid, occupied, {.bands = 9}), OptionError);
  EXPECT_THROW(ProjectTransmittance(grid, occupied, {.directions = 10}), OptionError);
  EXPECT_THROW(
      ProjectTransmittance(grid, occupied, {}, Progress([](double) { return false; })),
      Cancelled);
}

}  // namespace
}  // namespace relight
