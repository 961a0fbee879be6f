// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/sky_transmittance.h"

#include "relight/scattering/swept_transmittance.h"
#include "relight/scattering/transmittance.h"
#include "relight/sh/basis.h"
#include "relight/sh/quadrature.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

namespace relight {
namespace {

// Sums of floats, 1e-7 x sqrt(directions) x 4 pi, and half floats: 2^-11 of values up to
// sqrt(4 pi).
constexpr double kHalfFloat = 2e-3;

// (S1) as it stands: the same directions one by one.
TEST(SkyTransmittance, IsTheSumOverAllDirections) {
  const ExtinctionGrid grid = tests::RandomCanopy({6, 5, 7}, 0.2, 4.0, /*seed=*/4);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const SkyTransmittanceOptions options{.bands = 4, .directions = 300};
  const SkyTransmittance sky = ProjectTransmittance(grid, occupied, options);
  ASSERT_EQ(sky.bands, 4);
  ASSERT_EQ(sky.voxels, occupied.cell.size());
  ASSERT_EQ(sky.half.size(), 16 * occupied.cell.size());
  std::vector<Eigen::VectorXd> sums(occupied.cell.size(), Eigen::VectorXd::Zero(16));
  for (const Eigen::Vector3d& direction : SphereDirections(options.directions)) {
    const std::vector<float> tau = TransmittanceSwept(grid, occupied, direction);
    const Eigen::VectorXd y = SphericalHarmonics(direction, 4);
    for (std::size_t v = 0; v < tau.size(); ++v) {
      sums[v] += 4 * std::numbers::pi / options.directions * tau[v] * y;
    }
  }
  for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
    for (int i = 0; i < 16; ++i) {
      ASSERT_NEAR(sky.Coefficient(i, v), sums[v](i), kHalfFloat);
    }
  }
}

// From the centres by exact rays: each voxel's points are spread over its middle, so that
// what differs averages out over voxels.
TEST(SkyTransmittance, AgreesOnAverageWithRaysFromTheCentres) {
  const ExtinctionGrid grid = tests::RandomCanopy({24, 20, 22}, 0.2, 1.5, /*seed=*/14);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const SkyTransmittance sky =
      ProjectTransmittance(grid, occupied, {.bands = 1, .directions = 400});
  double mean = 0, exact = 0, squares = 0;
  std::vector<double> sums(occupied.cell.size(), 0.0);
  for (const Eigen::Vector3d& direction : SphereDirections(400)) {
    const std::vector<float> tau = TransmittanceAlong(grid, occupied, direction);
    for (std::size_t v = 0; v < tau.size(); ++v) {
      sums[v] += tau[v] * std::sqrt(4 * std::numbers::pi) / 400;
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v) {
    mean += sky.Coefficient(0, v);
    exact += sums[v];
    squares += std::pow(sky.Coefficient(0, v) / sums[v] - 1, 2);
  }
  const double rms = std::sqrt(squares / static_cast<double>(sums.size()));
  std::cout << "swept over exact, mean " << mean / exact << ", rms " << rms << "\n";
  EXPECT_NEAR(mean / exact, 1.0, 0.005);  // White noise: more unlike within a voxel than
  EXPECT_LT(rms, 0.1);                    // any tree
}

// tau = 1 everywhere: sqrt(4 pi) in band 0 and nothing above it.
TEST(SkyTransmittance, AnEmptyVolumeHasBandZeroOnly) {
  ExtinctionGrid grid = tests::Slab({5, 5, 5}, 0.2, 0.0);
  grid.Set(2, 2, 2, 1e-30f);
  const SkyTransmittance sky = ProjectTransmittance(grid, FindOccupied(grid));
  EXPECT_NEAR(sky.Coefficient(0, 0), std::sqrt(4 * std::numbers::pi), kHalfFloat);
  for (int i = 1; i < 36; ++i) {
    // The lattice of directions is not a quadrature: an error of 1 / 1024 or less
    EXPECT_NEAR(sky.Coefficient(i, 0), 0.0, 1e-3) << i;
  }
}

// More bands only add to those that are there.
TEST(SkyTransmittance, FewerBandsAreTheFirstOfMore) {
  const ExtinctionGrid grid = tests::RandomCanopy({6, 5, 7}, 0.2, 4.0, /*seed=*/5);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const auto two = ProjectTransmittance(grid, occupied, {.bands = 2, .directions = 100});
  const auto five = ProjectTransmittance(grid, occupied, {.bands = 5, .directions = 100});
  EXPECT_TRUE(tests::SameBytes(two.half, FirstBands(five, 2).half));
}

TEST(SkyTransmittance, DoesNotDependOnThreads) {
  const ExtinctionGrid grid = tests::RandomCanopy({13, 12, 14}, 0.1, 3.0, /*seed=*/6);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const auto with = [&](int threads) {
    const tests::WithThreads limit(threads);
    return ProjectTransmittance(grid, occupied, {.directions = 128});
  };
  const SkyTransmittance one = with(1), two = with(2);
  EXPECT_TRUE(tests::SameBytes(one.half, two.half));
}

TEST(SkyTransmittance, PacksAndUnpacks) {
  const ExtinctionGrid grid = tests::RandomCanopy({6, 5, 7}, 0.2, 4.0, /*seed=*/8);
  const SkyTransmittance sky =
      ProjectTransmittance(grid, FindOccupied(grid), {.bands = 3, .directions = 100});
  const auto values = UnpackedSky(sky);
  ASSERT_EQ(values.size(), 9u);
  EXPECT_EQ(values[5][3], sky.Coefficient(5, 3));
  EXPECT_TRUE(tests::SameBytes(PackedSky(3, values).half, sky.half));
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
