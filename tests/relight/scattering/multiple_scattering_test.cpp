// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/multiple_scattering.h"

#include "relight/scattering/transmittance.h"
#include "relight/sh/quadrature.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace relight {
namespace {

using std::numbers::pi;

ArrivingLight UnderEvenLight(const ExtinctionGrid& grid, const OccupiedVoxels& occupied) {
  return LightArriving(grid,
                       occupied,
                       ProjectTransmittance(grid, occupied),
                       UniformDaylight({1, 2, 3}, /*full_sphere=*/true));
}

// The white furnace: under the same light from everywhere, leaves that lose nothing have
// as much of it deep inside as at the outside.
TEST(MultipleScattering, LosesNothingInAWhiteFurnace) {
  for (const double most_per_m : {0.4, 1.5, 3.0}) {
    const ExtinctionGrid grid =
        tests::RandomCanopy({8, 9, 8}, 0.3, most_per_m, /*seed=*/4);
    const OccupiedVoxels occupied = FindOccupied(grid);
    const ArrivingLight swept = UnderEvenLight(grid, occupied);
    ArrivingLight light = swept;
    const std::vector<float> tau =
        MeanTransmittanceAlong(grid, occupied, SphereDirections(128));
    for (std::size_t v = 0; v < tau.size(); ++v) {
      light.sky[v] = 4 * static_cast<float>(pi) * tau[v] * Eigen::Array3f(1, 2, 3);
    }
    const Eigen::Array3f white = Eigen::Array3f::Constant(1);
    const auto more = MultipleScattering(grid, occupied, light, white);
    const auto more_swept = MultipleScattering(grid, occupied, swept, white);
    double mean_swept = 0;
    float least = 1;
    for (std::size_t v = 0; v < more.size(); ++v) {
      // Along the same ways all that is left are orders below 1/1000
      EXPECT_LT(((light.sky[v] + more[v]) / (4 * static_cast<float>(pi)) /
                     Eigen::Array3f(1, 2, 3) -
                 1)
                    .abs()
                    .maxCoeff(),
                0.01);
      mean_swept +=
          (swept.sky[v] + more_swept[v])[0] / (4 * pi) / static_cast<double>(more.size());
      least = std::min(least, tau[v]);
    }
    // A swept way is up to half a voxel aside, 1 % of a voxel's light, and all orders
    // have it
    EXPECT_NEAR(mean_swept, 1, 0.03);
    EXPECT_LT(least, most_per_m > 1 ? 0.5 : 0.8);  // There was something to make up
  }
}

// The sums of (S12) are the powers of the albedo: each channel has its own, and dark
// leaves send on nothing.
TEST(MultipleScattering, GrowsWithTheAlbedo) {
  const ExtinctionGrid grid = tests::RandomCanopy({9, 8, 10}, 0.2, 2.0, /*seed=*/6);
  const OccupiedVoxels occupied = FindOccupied(grid);
  ArrivingLight light = UnderEvenLight(grid, occupied);
  for (Eigen::Array3f& sky : light.sky) sky = Eigen::Array3f::Constant(sky[0]);
  const auto more = MultipleScattering(grid, occupied, light, {0.0f, 0.1f, 0.2f});
  for (const Eigen::Array3f& color : more) {
    EXPECT_EQ(color[0], 0);
    EXPECT_GT(color[1], 0);
    // The first order twice, all further ones more than twice
    EXPECT_GT(color[2], 2 * color[1]);
    EXPECT_LT(color[2], 2.5f * color[1]);
  }
}

// All light that is there counts alike, and twice the light is sent on twice.
TEST(MultipleScattering, IsLinearInTheLight) {
  const ExtinctionGrid grid = tests::RandomCanopy({9, 8, 10}, 0.2, 2.0, /*seed=*/7);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const ArrivingLight light = UnderEvenLight(grid, occupied);
  ArrivingLight twice = light;
  twice.sun = light.sky;
  const Eigen::Array3f albedo(0.1f, 0.3f, 0.05f);
  const auto one = MultipleScattering(grid, occupied, light, albedo);
  const auto two = MultipleScattering(grid, occupied, twice, albedo);
  for (std::size_t v = 0; v < one.size(); ++v) {
    EXPECT_TRUE((two[v] == 2 * one[v]).all());  // Doubling a float is exact
  }
}

// Voxels that are too many for it are taken together: a tree of the same leaves in
// voxels half as large has the same light.
TEST(MultipleScattering, DoesNotDependOnTheVoxels) {
  const ExtinctionGrid large = tests::Ball({0, 0, 2}, 2.0, 1.5, 16);
  ExtinctionGrid small = tests::Slab(2 * large.cells, large.cell_m / 2, 0.0);
  small.origin_m = large.origin_m;
  for (int z = 0; z < small.cells.z(); ++z) {
    for (int y = 0; y < small.cells.y(); ++y) {
      for (int x = 0; x < small.cells.x(); ++x) {
        small.Set(x, y, z, large.At(x / 2, y / 2, z / 2));
      }
    }
  }
  const OccupiedVoxels of_large = FindOccupied(large), of_small = FindOccupied(small);
  const Eigen::Array3f albedo = Eigen::Array3f::Constant(0.4f);
  const auto a =
      MultipleScattering(large, of_large, UnderEvenLight(large, of_large), albedo);
  const auto b =
      MultipleScattering(small, of_small, UnderEvenLight(small, of_small), albedo);
  double mean_a = 0, mean_b = 0;
  for (const Eigen::Array3f& color : a)
    mean_a += color[1] / static_cast<double>(a.size());
  for (const Eigen::Array3f& color : b)
    mean_b += color[1] / static_cast<double>(b.size());
  EXPECT_NEAR(mean_b / mean_a, 1, 0.02);  // The light that comes in is finer
}

TEST(MultipleScattering, DoesNotDependOnThreads) {
  const ExtinctionGrid grid = tests::RandomCanopy({30, 20, 25}, 0.2, 2.0, /*seed=*/8);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const ArrivingLight light = UnderEvenLight(grid, occupied);
  const auto with = [&](int threads) {
    const tests::WithThreads limit(threads);
    return MultipleScattering(grid, occupied, light, {0.1f, 0.3f, 0.1f});
  };
  const auto one = with(1), two = with(2);
  for (std::size_t v = 0; v < one.size(); ++v) EXPECT_TRUE((one[v] == two[v]).all());
}

}  // namespace
}  // namespace relight
