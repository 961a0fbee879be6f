// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/densification.h"

#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

ExtinctionGrid Empty() { return tests::Slab({7, 7, 7}, 0.1, 0.0); }

// Two voxels side by side: each gives its five empty axial neighbours what the other is.
TEST(Densification, TwoNeighboursGiveEachOthersExtinction) {
  ExtinctionGrid grid = Empty();
  const auto at = [&](int x, int y, int z) { return grid.At(x, y, z); };
  grid.Set(3, 3, 3, 1);
  grid.Set(4, 3, 3, 5);
  EXPECT_EQ(Densify(grid), 10u);
  EXPECT_EQ(at(3, 3, 3), 1);
  EXPECT_EQ(at(4, 3, 3), 5);
  for (const Eigen::Vector3i& d : {Eigen::Vector3i(0, 1, 0),
                                   Eigen::Vector3i(0, -1, 0),
                                   Eigen::Vector3i(0, 0, 1),
                                   Eigen::Vector3i(0, 0, -1)}) {
    EXPECT_EQ(at(3 + d.x(), 3 + d.y(), 3 + d.z()), 5);
    EXPECT_EQ(at(4 + d.x(), 3 + d.y(), 3 + d.z()), 1);
  }
  EXPECT_EQ(at(2, 3, 3), 5);
  EXPECT_EQ(at(5, 3, 3), 1);
  EXPECT_EQ(FindOccupied(grid).cell.size(), 12u);
}

// An empty voxel between two givers takes the mean; a giver the mean of its neighbours.
TEST(Densification, WhatIsGivenTwiceIsTheMean) {
  ExtinctionGrid grid = Empty();
  const auto at = [&](int x, int y, int z) { return grid.At(x, y, z); };
  grid.Set(1, 3, 3, 2);  // Gives 4, the mean of its one axial neighbour
  grid.Set(2, 3, 3, 4);  // Gives 2
  grid.Set(4, 3, 3, 8);  // Gives 6
  grid.Set(5, 3, 3, 6);
  Densify(grid);
  EXPECT_EQ(at(3, 3, 3), (2 + 6) / 2);
  EXPECT_EQ(at(2, 4, 3), 2);
  EXPECT_EQ(at(1, 4, 3), 4);
}

TEST(Densification, ASingleVoxelHasNothingToGive) {
  ExtinctionGrid grid = Empty();
  grid.Set(3, 3, 3, 1);
  EXPECT_EQ(Densify(grid), 0u);
  EXPECT_EQ(FindOccupied(grid).cell.size(), 1u);
}

// Of a solid cube only the 8 corners have fewer than 8 neighbours (7 each).
TEST(Densification, LeavesDenseNeighbourhoodsAlone) {
  ExtinctionGrid grid = Empty();
  for (int z = 2; z < 5; ++z) {
    for (int y = 2; y < 5; ++y) {
      for (int x = 2; x < 5; ++x) grid.Set(x, y, z, 3);
    }
  }
  EXPECT_EQ(Densify(grid), 8u * 3u);
  EXPECT_EQ(grid.At(1, 2, 2), 3);
  EXPECT_EQ(grid.At(1, 3, 3), 0);  // Before a face's middle
}

TEST(Densification, StaysInsideTheGrid) {
  ExtinctionGrid grid = tests::Slab({2, 1, 1}, 0.1, 1.0);
  EXPECT_EQ(Densify(grid), 0u);
}

}  // namespace
}  // namespace relight
