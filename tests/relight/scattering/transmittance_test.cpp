// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/transmittance.h"

#include "relight/volume/ray_traversal.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

// Optical depths are sums of some 20 floats of up to 3: 1e-6 each, and exp of them.
constexpr double kFloatSum = 1e-5;

std::vector<Eigen::Vector3d> TestDirections() {
  std::vector<Eigen::Vector3d> directions;
  for (int axis = 0; axis < 3; ++axis) {
    directions.push_back(Eigen::Vector3d::Unit(axis));
    directions.push_back(-Eigen::Vector3d::Unit(axis));
  }
  directions.push_back(Eigen::Vector3d(1, 1, 0).normalized());  // Through voxels' edges
  directions.push_back(Eigen::Vector3d(-1, 1, 1).normalized());
  std::mt19937 random(11);
  for (int i = 0; i < 40; ++i) directions.push_back(tests::RandomDirection(random));
  return directions;
}

TEST(Transmittance, IsThatOfARayFromEachVoxel) {
  const ExtinctionGrid grid = tests::RandomCanopy({9, 7, 11}, 0.13, 6.0, /*seed=*/1);
  const OccupiedVoxels occupied = FindOccupied(grid);
  for (const Eigen::Vector3d& direction : TestDirections()) {
    const std::vector<float> tau = TransmittanceAlong(grid, occupied, direction);
    ASSERT_EQ(tau.size(), occupied.cell.size());
    for (std::size_t v = 0; v < tau.size(); ++v) {
      const Eigen::Vector3i& cell = occupied.cell[v];
      const Ray ray{grid.Center(cell.x(), cell.y(), cell.z()), direction};
      // A ray through an edge may cross either voxel beside it, of no length in both
      ASSERT_NEAR(tau[v], std::exp(-OpticalDepth(grid, ray)), kFloatSum)
          << "along " << direction.transpose();
    }
  }
}

TEST(Transmittance, OfABundleIsTheMeanOfItsRays) {
  const ExtinctionGrid grid = tests::RandomCanopy({37, 9, 14}, 0.13, 3.0, /*seed=*/5);
  const OccupiedVoxels occupied = FindOccupied(grid);
  std::mt19937 random(12);
  for (const double spread : {0.005, 2.0}) {  // The sun's disc, and all over the place
    for (const int count : {1, 8, 11, 16}) {
      const Eigen::Vector3d middle = tests::RandomDirection(random);
      std::vector<Eigen::Vector3d> directions;
      std::vector<double> mean(occupied.cell.size(), 0.0);
      for (int i = 0; i < count; ++i) {
        directions.push_back(
            (middle + spread * tests::RandomDirection(random)).normalized());
        const std::vector<float> tau =
            TransmittanceAlong(grid, occupied, directions.back());
        for (std::size_t v = 0; v < tau.size(); ++v) mean[v] += tau[v] / double(count);
      }
      const std::vector<float> bundle =
          MeanTransmittanceAlong(grid, occupied, directions);
      for (std::size_t v = 0; v < mean.size(); ++v) {
        ASSERT_NEAR(bundle[v], mean[v], 1e-6);  // Sixteen floats of 1 or less
      }
    }
  }
}

// A voxel in a full slab, straight up: half of its own edge and all above it.
TEST(Transmittance, CountsHalfTheVoxelsOwnExtinction) {
  const ExtinctionGrid grid = tests::Slab({1, 1, 4}, 0.5, 0.8);
  const std::vector<float> tau =
      TransmittanceAlong(grid, FindOccupied(grid), Eigen::Vector3d::UnitZ());
  for (std::size_t z = 0; z < 4; ++z) {
    const double depth_m = 0.5 * (3.5 - static_cast<double>(z));
    EXPECT_NEAR(tau[z], std::exp(-0.8 * depth_m), 1e-7);  // One float
  }
}

TEST(Transmittance, IsExactlyOneInAnEmptyVolume) {
  ExtinctionGrid grid = tests::Slab({8, 6, 7}, 0.2, 0.0);
  const VoxelRows rows = RowsOf(grid);
  for (const Eigen::Vector3d& direction : TestDirections()) {
    const auto pattern = RayPattern(grid.cells, grid.cell_m, direction);
    std::vector<float> depth(8, -1.0f);
    RowOpticalDepth(grid, rows, pattern, 0, 8, 3, 2, depth.data());
    for (const float d : depth) EXPECT_EQ(std::exp(-d), 1.0f);
    EXPECT_EQ(OpticalDepth(grid, {grid.Center(4, 3, 2), direction}), 0.0);
  }
  // The same by the whole path: a voxel that is there, and as good as empty
  grid.Set(4, 3, 2, 1e-30f);
  for (const Eigen::Vector3d& direction : TestDirections()) {
    EXPECT_EQ(TransmittanceAlong(grid, FindOccupied(grid), direction),
              std::vector<float>{1.0f});
  }
}

// The way there is the way back.
TEST(Transmittance, IsTheSameFromOutsideIn) {
  const ExtinctionGrid grid = tests::RandomCanopy({6, 9, 8}, 0.17, 5.0, /*seed=*/2);
  const OccupiedVoxels occupied = FindOccupied(grid);
  for (const Eigen::Vector3d& direction : TestDirections()) {
    const std::vector<float> tau = TransmittanceAlong(grid, occupied, direction);
    for (std::size_t v = 0; v < tau.size(); v += 7) {
      const Eigen::Vector3i& cell = occupied.cell[v];
      const Eigen::Vector3d center = grid.Center(cell.x(), cell.y(), cell.z());
      constexpr double kOutside_m = 10.0;
      double depth = 0.0;
      TraverseRay(grid,
                  {center + kOutside_m * direction, -direction},
                  0.0,
                  [&](std::size_t voxel, double entry_m, double length_m) {
                    depth += grid.sigma_per_m[voxel] *
                             std::clamp(kOutside_m - entry_m, 0.0, length_m);
                    return entry_m < kOutside_m;
                  });
      ASSERT_NEAR(tau[v], std::exp(-depth), kFloatSum);
    }
  }
}

TEST(Transmittance, APatternGoesOnInStepsOfOneVoxel) {
  const Eigen::Vector3i cells(12, 5, 9);
  for (const Eigen::Vector3d& direction : TestDirections()) {
    const auto pattern = RayPattern(cells, 0.25, direction);
    ASSERT_FALSE(pattern.empty());
    EXPECT_EQ(Eigen::Vector3i(pattern[0].dx, pattern[0].dy, pattern[0].dz),
              Eigen::Vector3i::Zero());
    Eigen::Vector3d at(0, 0, 0);
    for (const PatternStep& step : pattern) {
      // The middle of the piece is inside the step's voxel, around its centre
      const Eigen::Vector3d middle = at + 0.5 * step.length_m * direction;
      const Eigen::Vector3d offset =
          middle - 0.25 * Eigen::Vector3d(step.dx, step.dy, step.dz);
      EXPECT_LE(offset.cwiseAbs().maxCoeff(), 0.125 + 1e-6);
      at += step.length_m * direction;
    }
  }
}

TEST(Transmittance, DoesNotDependOnThreads) {
  const ExtinctionGrid grid = tests::RandomCanopy({20, 21, 22}, 0.1, 3.0, /*seed=*/3);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const Eigen::Vector3d direction = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
  const auto with = [&](int threads) {
    const tests::WithThreads limit(threads);
    return TransmittanceAlong(grid, occupied, direction);
  };
  EXPECT_TRUE(tests::SameBytes(with(1), with(2)));
}

}  // namespace
}  // namespace relight
