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
  EXPECT_EQ(grid.Count(), 20u * 5u * 50u);
  EXPECT_TRUE(grid.Bounds().isApprox(box));
  EXPECT_TRUE(grid.Center(0, 0, 0).isApprox(Eigen::Vector3d(-0.9, 2.1, 0.1)));
  EXPECT_EQ(tests::AllValues(grid), std::vector<float>(grid.Count(), 0.0f));
  EXPECT_EQ(grid.At(-1, 0, 0), 0.0f);
  EXPECT_EQ(grid.At(20, 0, 0), 0.0f);
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
  grid.Set(1, 2, 1, static_cast<float>(-std::log(0.7) / 0.3));
  ExtinctionGrid split{NoBricks(2 * grid.cells, grid.origin_m, grid.cell_m / 2), {}};
  tests::Fill(split, [&](int x, int y, int z) { return grid.At(x / 2, y / 2, z / 2); });
  std::mt19937 random(33);
  for (int i = 0; i < 200; ++i) {
    const Ray ray{grid.Center(1, 2, 1), tests::RandomDirection(random)};
    EXPECT_NEAR(OpticalDepth(grid, ray), OpticalDepth(split, ray), 1e-10);
  }
  // Straight up through the middle of one voxel alone
  std::fill(split.sigma_per_m.begin(), split.sigma_per_m.end(), 0.0f);
  for (const int z : {2, 3}) {
    split.Set(2, 4, z, grid.At(1, 2, 1));
  }
  const Ray up{split.Center(2, 4, 0), Eigen::Vector3d::UnitZ()};
  EXPECT_NEAR(1 - std::exp(-OpticalDepth(split, up)), 0.3, 1e-7);  // A float
}

TEST(ExtinctionGrid, FindsWhatIsNotEmptyInTheGridsOrder) {
  const ExtinctionGrid grid = tests::RandomCanopy({5, 7, 6}, 0.1, 2.0, /*seed=*/31);
  const OccupiedVoxels occupied = FindOccupied(grid);
  ASSERT_EQ(occupied.of_cell.size(), grid.Size());
  int before = -1;
  for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
    const Eigen::Vector3i& at = occupied.cell[v];
    const std::size_t index = grid.Index(at.x(), at.y(), at.z());
    EXPECT_EQ(occupied.of_cell[index], static_cast<int>(v));
    EXPECT_GT(grid.sigma_per_m[index], 0.0f);
    const int in_box = at.x() + 5 * (at.y() + 7 * at.z());
    EXPECT_GT(in_box, before);
    before = in_box;
  }
  const auto positive = std::count_if(grid.sigma_per_m.begin(),
                                      grid.sigma_per_m.end(),
                                      [](float sigma) { return sigma > 0; });
  EXPECT_EQ(static_cast<std::size_t>(positive), occupied.cell.size());
  EXPECT_EQ(std::count(occupied.of_cell.begin(), occupied.of_cell.end(), -1),
            static_cast<std::ptrdiff_t>(grid.Size()) - positive);
}

// Values set at random in a box that bricks do not divide evenly, beside a plain array.
TEST(ExtinctionGrid, KeepsWhatIsSetWhereItIsSet) {
  ExtinctionGrid grid = tests::Slab({21, 17, 30}, 0.1, 0.0);
  std::vector<float> expected(grid.Count(), 0.0f);
  std::mt19937 random(4);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3i at(random() % 21, random() % 17, random() % 30);
    const auto sigma = static_cast<float>(random() % 4);  // Some are 0
    grid.Set(at.x(), at.y(), at.z(), sigma);
    expected[static_cast<std::size_t>(at.x() + 21 * (at.y() + 17 * at.z()))] = sigma;
  }
  EXPECT_EQ(tests::AllValues(grid), expected);
  std::vector<float> in_order(grid.Count(), 0.0f);
  std::size_t before = 0;
  ForEachVoxel(grid, [&](int x, int y, int z, std::size_t index) {
    EXPECT_EQ(grid.VoxelAt(index), Eigen::Vector3i(x, y, z));
    const auto in_box = static_cast<std::size_t>(x + 21 * (y + 17 * z));
    EXPECT_TRUE(in_box > before || in_box == 0);
    before = in_box;
    in_order[in_box] = grid.sigma_per_m[index];
  });
  EXPECT_EQ(in_order, expected);
  EXPECT_THROW(grid.Set(21, 0, 0, 1.0f), std::logic_error);
  EXPECT_THROW(grid.Set(0, -1, 0, 1.0f), std::logic_error);
}

TEST(ExtinctionGrid, DropsTheBricksThatHoldNothing) {
  ExtinctionGrid grid = tests::Slab({40, 40, 40}, 0.1, 0.0);
  for (int i = 0; i < 40; i += 3) grid.Set(i, 39 - i, i, 1.0f + static_cast<float>(i));
  for (int i = 0; i < 40; i += 6) grid.Set(i, 39 - i, i, 0.0f);
  grid.Set(39, 39, 39, 2.0f);
  for (int i = 8; i < 24; ++i) grid.Set(i, 39 - i, i, 0.0f);
  const std::vector<float> before = tests::AllValues(grid);
  const std::size_t bricks = grid.brick_at.size();
  grid.DropEmptyBricks();
  EXPECT_LT(grid.brick_at.size(), bricks);
  EXPECT_EQ(tests::AllValues(grid), before);
  EXPECT_EQ(grid.sigma_per_m.size(), grid.Size());
  for (std::size_t b = 0; b < grid.brick_at.size(); ++b) {
    const auto from =
        grid.sigma_per_m.begin() + static_cast<std::ptrdiff_t>(b * grid.kPerBrick);
    EXPECT_TRUE(std::any_of(from, from + grid.kPerBrick, [](float s) { return s > 0; }));
  }
}

// 4 GiB if the box counted: a ball of 20 voxels across touches 4 x 4 x 4 bricks at most,
// and a table of 128^3 places tells where they are.
TEST(ExtinctionGrid, MemoryFollowsWhatIsOccupiedNotTheBox) {
  ExtinctionGrid grid = tests::Slab({1, 1, 1}, 0.01, 0.0);
  const auto bytes_in_box = [&](int cells) {
    grid = EmptyGrid({Eigen::Vector3d::Zero(), Eigen::Vector3d::Constant(0.01 * cells)},
                     cells);
    const Eigen::Vector3i middle = Eigen::Vector3i::Constant(cells / 2);
    for (int i = 0; i < 20 * 20 * 20; ++i) {
      const Eigen::Vector3i from(i % 20 - 10, i / 20 % 20 - 10, i / 400 - 10);
      const Eigen::Vector3i at = middle + from;
      if (from.squaredNorm() < 100) grid.Set(at.x(), at.y(), at.z(), 2.0f);
    }
    return grid.Bytes() + FindOccupied(grid).Bytes();
  };
  const std::size_t large = bytes_in_box(1024), table = sizeof(std::int32_t) << 21;
  EXPECT_EQ(grid.Count(), std::size_t{1} << 30);
  EXPECT_GT(FindOccupied(grid).cell.size(), 4000u);
  EXPECT_LT(large, std::size_t{10} << 20);
  EXPECT_EQ(large - table, bytes_in_box(128) - (table >> 9));
}

}  // namespace
}  // namespace relight
