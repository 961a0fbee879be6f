// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/swept_transmittance.h"

#include "relight/scattering/transmittance.h"
#include "relight/sh/quadrature.h"
#include "relight/volume/ray_traversal.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <cmath>

namespace relight {
namespace {

// Optical depths are sums of some 60 floats of up to 3: 1e-6 each, and exp of them.
constexpr double kFloatSum = 2e-5;

std::vector<Eigen::Vector3d> TestDirections(unsigned seed) {
  std::vector<Eigen::Vector3d> directions;
  for (int axis = 0; axis < 3; ++axis) {
    directions.push_back(Eigen::Vector3d::Unit(axis));
    directions.push_back(-Eigen::Vector3d::Unit(axis));
  }
  directions.push_back(Eigen::Vector3d(1, 1, 0).normalized());  // Through voxels' edges
  directions.push_back(Eigen::Vector3d(-1, 1, 1).normalized());
  std::mt19937 random(seed);
  for (int i = 0; i < 60; ++i) directions.push_back(tests::RandomDirection(random));
  return directions;
}

// Where the line that the header names leaves the voxel's plane.
Eigen::Vector3d LeavesAt(const ExtinctionGrid& grid,
                         const Eigen::Vector3i& cell,
                         const Eigen::Vector3d& direction) {
  int across = 0;
  direction.cwiseAbs().maxCoeff(&across);
  const double along = direction[across];
  const int t = along > 0 ? grid.cells[across] - 1 - cell[across] : cell[across];
  Eigen::Vector3d at;
  for (int axis = 0; axis < 3; ++axis) {
    const double place = 0.5 - t * direction[axis] / std::abs(along);
    at[axis] = axis == across ? 0.5 : place - std::floor(place);
  }
  return grid.origin_m +
         grid.cell_m * (cell.cast<double>() + at + direction / (2 * std::abs(along)));
}

// Random grids of random shapes: each voxel's depth is that of one exact ray.
TEST(SweptTransmittance, IsThatOfTheLineThatTheHeaderNames) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> side(1, 40);
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const Eigen::Vector3i cells(side(random), side(random), side(random));
    const ExtinctionGrid grid = tests::RandomCanopy(cells, 0.13, 3.0, seed);
    const OccupiedVoxels occupied = FindOccupied(grid);
    for (const Eigen::Vector3d& direction : TestDirections(seed)) {
      const std::vector<float> tau = TransmittanceSwept(grid, occupied, direction);
      ASSERT_EQ(tau.size(), occupied.cell.size());
      for (std::size_t v = 0; v < tau.size(); v += 3) {
        const Eigen::Vector3i& cell = occupied.cell[v];
        const double own = grid.At(cell.x(), cell.y(), cell.z()) * grid.cell_m / 2 /
                           direction.cwiseAbs().maxCoeff();
        // A hair outwards, for the face itself belongs to both planes
        const Ray ray{LeavesAt(grid, cell, direction) + 1e-9 * direction, direction};
        // On an edge, as along (1, 1, 0), either voxel beside it may be the ray's
        const Ray beside{
            ray.origin + 1e-7 * grid.cell_m * (grid.Center(0, 0, 0) - ray.origin),
            direction};
        const double a = std::exp(-own - OpticalDepth(grid, ray));
        const double b = std::exp(-own - OpticalDepth(grid, beside));
        ASSERT_TRUE(std::abs(tau[v] - a) < kFloatSum || std::abs(tau[v] - b) < kFloatSum)
            << tau[v] << " for " << a << " along " << direction.transpose() << " in "
            << cells.transpose();
      }
    }
  }
}

// Along the axes the points are the centres.
TEST(SweptTransmittance, AlongAnAxisIsThatFromTheCentres) {
  const ExtinctionGrid grid = tests::RandomCanopy({17, 9, 23}, 0.1, 4.0, /*seed=*/3);
  const OccupiedVoxels occupied = FindOccupied(grid);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d direction = sign * Eigen::Vector3d::Unit(axis);
      const std::vector<float> swept = TransmittanceSwept(grid, occupied, direction);
      const std::vector<float> exact = TransmittanceAlong(grid, occupied, direction);
      for (std::size_t v = 0; v < swept.size(); ++v) {
        ASSERT_NEAR(swept[v], exact[v], kFloatSum);
      }
    }
  }
}

// Beer-Lambert in a slab wider than the rays go: the point does not matter there.
TEST(SweptTransmittance, ASlabHasItsClosedForm) {
  const ExtinctionGrid grid = tests::Slab({41, 41, 9}, 0.2, 0.7);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const Eigen::Vector3d direction = Eigen::Vector3d(0.5, -0.4, 0.8).normalized();
  const std::vector<float> tau = TransmittanceSwept(grid, occupied, direction);
  for (int z = 0; z < 9; ++z) {
    const double way_m = 0.2 * (8.5 - z) / direction.z();
    const auto voxel = static_cast<std::size_t>(occupied.of_cell[grid.Index(20, 20, z)]);
    EXPECT_NEAR(tau[voxel], std::exp(-0.7 * way_m), kFloatSum);
  }
}

// Forth and back: what a voxel's line leaves on both sides is what the whole line leaves,
// the same for all voxels of it.
TEST(SweptTransmittance, IsReciprocal) {
  const ExtinctionGrid grid = tests::RandomCanopy({7, 8, 30}, 0.1, 2.0, /*seed=*/9);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  const std::vector<float> forth = TransmittanceSwept(grid, occupied, up);
  const std::vector<float> back = TransmittanceSwept(grid, occupied, -up);
  std::vector<double> whole(56, -1.0);
  for (std::size_t v = 0; v < forth.size(); ++v) {
    const Eigen::Vector3i& cell = occupied.cell[v];
    const double both = static_cast<double>(forth[v]) * back[v];
    double& line = whole[static_cast<std::size_t>(cell.x() + 7 * cell.y())];
    if (line < 0) line = both;
    ASSERT_NEAR(both / line, 1.0, kFloatSum);
  }
}

// A tree turned by a quarter about the vertical, under directions turned as well.
TEST(SweptTransmittance, TurnsWithTheTree) {
  const ExtinctionGrid grid = tests::RandomCanopy({11, 14, 9}, 0.1, 3.0, /*seed=*/12);
  ExtinctionGrid turned = tests::Slab({14, 11, 9}, 0.1, 0.0);
  for (int z = 0; z < 9; ++z) {
    for (int y = 0; y < 14; ++y) {
      for (int x = 0; x < 11; ++x) {
        turned.Set(13 - y, x, z, grid.At(x, y, z));
      }
    }
  }
  const OccupiedVoxels occupied = FindOccupied(grid), of_turned = FindOccupied(turned);
  std::mt19937 random(2);
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector3d d = tests::RandomDirection(random);
    const std::vector<float> a = TransmittanceSwept(grid, occupied, d);
    const std::vector<float> b =
        TransmittanceSwept(turned, of_turned, {-d.y(), d.x(), d.z()});
    for (std::size_t v = 0; v < a.size(); ++v) {
      const Eigen::Vector3i& cell = occupied.cell[v];
      const int other =
          of_turned.of_cell[turned.Index(13 - cell.y(), cell.x(), cell.z())];
      ASSERT_NEAR(a[v], b[static_cast<std::size_t>(other)], kFloatSum);
    }
  }
}

// More leaves, less light; a volume in two halves transmits as their product.
TEST(SweptTransmittance, MultipliesAndFalls) {
  ExtinctionGrid one = tests::RandomCanopy({20, 18, 16}, 0.1, 2.0, /*seed=*/21);
  tests::Fill(one, [&](int x, int y, int z) {
    return one.At(x, y, z) + 0.01f;  // All voxels are looked at
  });
  ExtinctionGrid two = one, both = one;
  std::mt19937 random(22);
  std::uniform_real_distribution<float> uniform(0.01f, 1.0f);
  tests::Fill(two, [&](int, int, int) { return uniform(random); });
  tests::Fill(both,
              [&](int x, int y, int z) { return one.At(x, y, z) + two.At(x, y, z); });
  const OccupiedVoxels occupied = FindOccupied(both);
  for (const Eigen::Vector3d& direction : SphereDirections(40)) {
    const std::vector<float> a = TransmittanceSwept(one, occupied, direction);
    const std::vector<float> b = TransmittanceSwept(two, occupied, direction);
    const std::vector<float> ab = TransmittanceSwept(both, occupied, direction);
    for (std::size_t v = 0; v < ab.size(); ++v) {
      ASSERT_NEAR(ab[v], a[v] * b[v], kFloatSum);
      ASSERT_LE(ab[v], a[v] + kFloatSum);
      ASSERT_GE(ab[v], 0.0f);
    }
  }
}

}  // namespace
}  // namespace relight
