// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/ray_traversal.h"

#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <vector>

namespace relight {
namespace {

// Lengths of some metres in doubles, from a dozen sums.
constexpr double kRounding_m = 1e-11;

// Length of a ray inside a box, from `start_m` on.
double Chord(const Eigen::AlignedBox3d& box, const Ray& ray, double start_m) {
  double enter = start_m, leave = 1e300;
  for (int axis = 0; axis < 3; ++axis) {
    const double slope = ray.direction[axis];
    const double low = box.min()[axis] - ray.origin[axis];
    const double high = box.max()[axis] - ray.origin[axis];
    if (slope == 0) {
      if (low > 0 || high < 0) return 0;
      continue;
    }
    enter = std::max(enter, std::min(low / slope, high / slope));
    leave = std::min(leave, std::max(low / slope, high / slope));
  }
  return std::max(0.0, leave - enter);
}

Eigen::AlignedBox3d VoxelBox(const ExtinctionGrid& grid, int x, int y, int z) {
  const Eigen::Vector3d half = Eigen::Vector3d::Constant(grid.cell_m / 2);
  return {grid.Center(x, y, z) - half, grid.Center(x, y, z) + half};
}

ExtinctionGrid TestGrid() {
  ExtinctionGrid grid = tests::RandomCanopy({7, 5, 6}, 0.3, 2.0, /*seed=*/41);
  grid.origin_m = {-1.3, 0.7, 2.1};
  return grid;
}

// Rays from inside and outside; every third one along an axis, or in a plane of two.
std::vector<Ray> RandomRays(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-2.5, 5.0);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    Eigen::Vector3d direction = tests::RandomDirection(random);
    if (i % 6 == 0) direction = Eigen::Vector3d::Unit(i / 6 % 3) * (i % 4 == 0 ? 1 : -1);
    if (i % 6 == 3) {
      direction[i / 6 % 3] = 0;
      direction.normalize();
    }
    rays.push_back({{uniform(random), uniform(random), uniform(random)}, direction});
  }
  return rays;
}

// Against each voxel's own box, one by one.
TEST(RayTraversal, CrossesTheVoxelsThatARayCrosses) {
  const ExtinctionGrid grid = TestGrid();
  int met = 0;
  for (const Ray& ray : RandomRays(3000, 42)) {
    for (const double start_m : {0.0, 0.9}) {
      std::vector<double> lengths(grid.Size(), 0.0);
      double at_m = -1, sum_m = 0;
      TraverseRay(
          grid, ray, start_m, [&](std::size_t voxel, double entry, double length) {
            EXPECT_GT(length, 0);
            EXPECT_GE(entry, start_m);
            EXPECT_TRUE(at_m < 0 ||
                        std::abs(entry - at_m) < kRounding_m);  // Without a gap
            at_m = entry + length;
            sum_m += length;
            EXPECT_EQ(lengths.at(voxel), 0.0);  // No voxel twice
            lengths.at(voxel) = length;
            return true;
          });
      ASSERT_NEAR(sum_m, Chord(grid.Bounds(), ray, start_m), kRounding_m);
      met += sum_m > 0;
      for (int z = 0; z < 6; ++z) {
        for (int y = 0; y < 5; ++y) {
          for (int x = 0; x < 7; ++x) {
            ASSERT_NEAR(lengths[grid.Index(x, y, z)],
                        Chord(VoxelBox(grid, x, y, z), ray, start_m),
                        kRounding_m);
          }
        }
      }
    }
  }
  EXPECT_GT(met, 200);  // Not all of them pass by
}

// Of a box that is in bricks all over, what is in those of another's: the same voxels,
// entries and lengths, to the last bit.
TEST(RayTraversal, MeetsWhatIsInBricksAndNothingElse) {
  ExtinctionGrid full =
      EmptyGrid({Eigen::Vector3d(-1, -2, 0), Eigen::Vector3d(1.3, 1.1, 2.2)}, 37);
  tests::Fill(full, [](int, int, int) { return 1; });
  std::mt19937 random(3);
  ExtinctionGrid some = EmptyGrid(full.Bounds(), 37);
  for (const Eigen::Vector3i& low : full.brick_at) {
    if (random() % 3 != 0) some.Set(low.x(), low.y(), low.z(), 1);
  }
  ASSERT_LT(some.brick_at.size(), full.brick_at.size());
  struct Crossing {
    Eigen::Vector3i voxel;
    double entry_m, length_m;
  };
  std::size_t met = 0;
  for (const Ray& ray : RandomRays(2000, 44)) {
    std::vector<Crossing> expected, crossed;
    TraverseRay(full, ray, 0.3, [&](std::size_t index, double entry_m, double length_m) {
      const Eigen::Vector3i at = full.VoxelAt(index);
      if (some.Find(at.x(), at.y(), at.z()) >= 0) {
        expected.push_back({at, entry_m, length_m});
      }
      return true;
    });
    TraverseRay(some, ray, 0.3, [&](std::size_t index, double entry_m, double length_m) {
      crossed.push_back({some.VoxelAt(index), entry_m, length_m});
      return true;
    });
    ASSERT_EQ(crossed.size(), expected.size());
    for (std::size_t i = 0; i < crossed.size(); ++i) {
      ASSERT_EQ(crossed[i].voxel, expected[i].voxel);
      ASSERT_EQ(crossed[i].entry_m, expected[i].entry_m);
      ASSERT_EQ(crossed[i].length_m, expected[i].length_m);
    }
    met += crossed.size();
  }
  EXPECT_GT(met, 1000u);
}

// In the face of two voxels, or the edge of four, the length is that of one of them.
TEST(RayTraversal, ARayInAFaceIsCountedOnce) {
  const ExtinctionGrid grid = tests::Slab({4, 4, 4}, 0.5, 1.0);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      for (int corner = 0; corner < 25; ++corner) {
        Eigen::Vector3d origin = grid.origin_m;
        origin[(axis + 1) % 3] += 0.5 * (corner % 5);
        origin[(axis + 2) % 3] += 0.5 * (corner / 5);
        origin[axis] += sign > 0 ? -1.0 : 3.0;
        EXPECT_NEAR(OpticalDepth(grid, {origin, sign * Eigen::Vector3d::Unit(axis)}),
                    2.0,
                    1e-6);  // A float of extinction
      }
    }
  }
  // The diagonal meets corners only
  const Eigen::Vector3d diagonal = Eigen::Vector3d(1, 1, 1).normalized();
  EXPECT_NEAR(
      OpticalDepth(grid, {grid.origin_m - diagonal, diagonal}), 2.0 * std::sqrt(3), 1e-6);
}

// exp(-depth) multiplies along a path: a to b and b outwards is a outwards.
TEST(RayTraversal, OpticalDepthAddsUpAlongAPath) {
  const ExtinctionGrid grid = TestGrid();
  for (const Ray& ray : RandomRays(500, 43)) {
    const double whole = OpticalDepth(grid, ray);
    for (const double split_m : {0.05, 0.8, 2.2}) {
      double first = 0.0;
      TraverseRay(grid, ray, 0.0, [&](std::size_t voxel, double entry, double length) {
        first += grid.sigma_per_m[voxel] * std::clamp(split_m - entry, 0.0, length);
        return entry + length < split_m;
      });
      const Ray rest{ray.origin + split_m * ray.direction, ray.direction};
      EXPECT_NEAR(first + OpticalDepth(grid, rest), whole, 1e-10);
    }
  }
}

TEST(RayTraversal, StopsWhenItIsTold) {
  const ExtinctionGrid grid = tests::Slab({8, 1, 1}, 1.0, 1.0);
  std::vector<std::size_t> visited;
  TraverseRay(grid,
              {{-9, 0, 0.5}, Eigen::Vector3d::UnitX()},
              0.0,
              [&](std::size_t voxel, double, double) {
                visited.push_back(voxel);
                return visited.size() < 3;
              });
  EXPECT_EQ(visited, (std::vector<std::size_t>{0, 1, 2}));
}

TEST(RayTraversal, WhatIsBehindIsNotMet) {
  const ExtinctionGrid grid = tests::Slab({8, 8, 8}, 0.25, 1.0);
  EXPECT_EQ(OpticalDepth(grid, {{0, 0, 3}, Eigen::Vector3d::UnitZ()}), 0.0);
  EXPECT_NEAR(
      OpticalDepth(grid, {{0.1, 0.1, 1.5}, Eigen::Vector3d::UnitZ()}), 0.5, 1e-12);
}

}  // namespace
}  // namespace relight
