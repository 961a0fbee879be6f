// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/extinction_grid.h"

#include "relight/base/error.h"
#include "relight/volume/ray_traversal.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace relight {
namespace {

TEST(ExtinctionGrid, CoversItsBoxWithCubes) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(-1, 2, 0), Eigen::Vector3d(3, 3, 10));
  const ExtinctionGrid grid = EmptyGrid(box, 50);
  EXPECT_EQ(grid.cell_m, 0.2);
  EXPECT_EQ(grid.cells, Eigen::Vector3i(20, 5, 50));
  EXPECT_EQ(grid.sigma_per_m.size(), 20u * 5u * 50u);
  EXPECT_EQ(grid.Count(), grid.sigma_per_m.size());
  EXPECT_TRUE(grid.Bounds().isApprox(box));
  EXPECT_TRUE(grid.Center(0, 0, 0).isApprox(Eigen::Vector3d(-0.9, 2.1, 0.1)));
  for (const float sigma : grid.sigma_per_m) EXPECT_EQ(sigma, 0.0f);
}

TEST(ExtinctionGrid, SidesThatAreNoWholeNumberAreRoundedUp) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0, 0, 0),
                                Eigen::Vector3d(1, 0.71, 0.001));
  const ExtinctionGrid grid = EmptyGrid(box, 10);
  EXPECT_EQ(grid.cells, Eigen::Vector3i(10, 8, 1));
  EXPECT_TRUE(grid.Bounds().contains(box));
  // Three tenths are three voxels, whatever 0.3 / 0.1 is in binary
  const Eigen::AlignedBox3d thirds(Eigen::Vector3d(0, 0, 0),
                                   Eigen::Vector3d(1, 0.3, 0.7));
  EXPECT_EQ(EmptyGrid(thirds, 10).cells, Eigen::Vector3i(10, 3, 7));
}

TEST(ExtinctionGrid, RefusesBoxesAndCountsThatMakeNoGrid) {
  const Eigen::AlignedBox3d box(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 1, 1));
  EXPECT_THROW(EmptyGrid(box, 0), OptionError);
  EXPECT_THROW(EmptyGrid(box, 1025), OptionError);
  EXPECT_THROW(EmptyGrid({}, 10), OptionError);
  const Eigen::AlignedBox3d flat(Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 1));
  EXPECT_THROW(EmptyGrid(flat, 10), OptionError);
  const Eigen::AlignedBox3d endless(
      Eigen::Vector3d(0, 0, 0),
      Eigen::Vector3d(1, std::numeric_limits<double>::infinity(), 1));
  EXPECT_THROW(EmptyGrid(endless, 10), OptionError);
}

// (V1): an opacity of 0.3 a voxel stays that of the whole when the voxel is eight.
TEST(ExtinctionGrid, ExtinctionKeepsItsMeaningWhenTheVoxelsAreSplit) {
  ExtinctionGrid grid = tests::RandomCanopy({4, 5, 3}, 0.3, 4.0, /*seed=*/32);
  grid.sigma_per_m[grid.Index(1, 2, 1)] = static_cast<float>(-std::log(0.7) / 0.3);
  ExtinctionGrid split = grid;
  split.cells = 2 * grid.cells;
  split.cell_m = grid.cell_m / 2;
  split.sigma_per_m.resize(split.Count());
  for (int z = 0; z < split.cells.z(); ++z) {
    for (int y = 0; y < split.cells.y(); ++y) {
      for (int x = 0; x < split.cells.x(); ++x) {
        split.sigma_per_m[split.Index(x, y, z)] =
            grid.sigma_per_m[grid.Index(x / 2, y / 2, z / 2)];
      }
    }
  }
  std::mt19937 random(33);
  for (int i = 0; i < 200; ++i) {
    const Ray ray{grid.Center(1, 2, 1), tests::RandomDirection(random)};
    EXPECT_NEAR(OpticalDepth(grid, ray), OpticalDepth(split, ray), 1e-10);
  }
  // Straight up through the middle of one voxel alone
  std::fill(split.sigma_per_m.begin(), split.sigma_per_m.end(), 0.0f);
  for (const int z : {2, 3}) {
    split.sigma_per_m[split.Index(2, 4, z)] = grid.sigma_per_m[grid.Index(1, 2, 1)];
  }
  const Ray up{split.Center(2, 4, 0), Eigen::Vector3d::UnitZ()};
  EXPECT_NEAR(1 - std::exp(-OpticalDepth(split, up)), 0.3, 1e-7);  // A float
}

TEST(ExtinctionGrid, FindsWhatIsNotEmptyInTheGridsOrder) {
  const ExtinctionGrid grid = tests::RandomCanopy({5, 7, 6}, 0.1, 2.0, /*seed=*/31);
  const OccupiedVoxels occupied = FindOccupied(grid);
  ASSERT_EQ(occupied.of_cell.size(), grid.Count());
  std::size_t before = 0;
  for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
    const Eigen::Vector3i& at = occupied.cell[v];
    const std::size_t index = grid.Index(at.x(), at.y(), at.z());
    EXPECT_EQ(occupied.of_cell[index], static_cast<int>(v));
    EXPECT_GT(grid.sigma_per_m[index], 0.0f);
    EXPECT_TRUE(v == 0 || index > before);
    before = index;
  }
  const auto positive = std::count_if(grid.sigma_per_m.begin(),
                                      grid.sigma_per_m.end(),
                                      [](float sigma) { return sigma > 0; });
  EXPECT_EQ(static_cast<std::size_t>(positive), occupied.cell.size());
  EXPECT_EQ(std::count(occupied.of_cell.begin(), occupied.of_cell.end(), -1),
            static_cast<std::ptrdiff_t>(grid.Count()) - positive);
}

}  // namespace
}  // namespace relight
