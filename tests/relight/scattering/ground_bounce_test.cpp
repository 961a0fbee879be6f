// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/ground_bounce.h"

#include "relight/scattering/arriving_light.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace relight {
namespace {

using std::numbers::pi;

Eigen::Array3f Unshaded(const Eigen::Vector2d& /*ground_m*/) {
  return Eigen::Array3f::Ones();
}

TEST(GroundBounce, EndlessGroundFillsHalfOfTheSphere) {
  ExtinctionGrid grid = tests::Slab({1, 1, 9}, 0.2, 0.0);
  grid.Set(0, 0, 2, 1e-30f);
  grid.Set(0, 0, 8, 1e-30f);
  const Eigen::Array3d radiance(100, 200, 300);
  const auto light =
      GroundBounce(grid, FindOccupied(grid), radiance, Unshaded, /*ground_z_m=*/1.0);
  EXPECT_TRUE((light[0] == 0).all());  // Below the ground
  // 64 floats
  EXPECT_LT((light[1].cast<double>() / (2 * pi * radiance) - 1).abs().maxCoeff(), 1e-5);
}

// A black disc of the radius R below a leaf at the height h takes the cone
// cos(angle) > h / sqrt(R^2 + h^2) from it.
TEST(GroundBounce, GroundInTheShadeSendsNothing) {
  ExtinctionGrid grid = tests::Slab({1, 1, 1}, 0.2, 0.0);
  grid.origin_m.z() = 2.9;
  grid.Set(0, 0, 0, 1e-30f);
  for (const double radius_m : {1.5, 3.0, 6.0}) {
    const auto light = GroundBounce(
        grid,
        FindOccupied(grid),
        {1, 1, 1},
        [&](const Eigen::Vector2d& ground_m) -> Eigen::Array3f {
          return Eigen::Array3f::Constant(ground_m.norm() < radius_m ? 0.0f : 1.0f);
        });
    const double outside = 3.0 / std::hypot(3.0, radius_m);
    // The directions go down in 64 steps of equal solid angle
    EXPECT_NEAR(light[0][1], 2 * pi * outside, 2 * pi / 64);
  }
}

// Under a tree in the open the ground is what the sky is above it, upside down.
TEST(GroundBounce, IsTheSkyUpsideDown) {
  const ExtinctionGrid grid = tests::RandomCanopy({12, 10, 11}, 0.2, 2.0, /*seed=*/5);
  ExtinctionGrid turned = grid;
  for (int z = 0; z < 11; ++z) {
    for (int y = 0; y < 10; ++y) {
      for (int x = 0; x < 12; ++x) {
        turned.Set(x, y, 10 - z, grid.At(x, y, z));
      }
    }
  }
  const OccupiedVoxels occupied = FindOccupied(grid), of_turned = FindOccupied(turned);
  const auto ground = GroundBounce(turned, of_turned, {1, 1, 1}, Unshaded);
  const ArrivingLight sky = LightArriving(
      grid, occupied, ProjectTransmittance(grid, occupied), UniformDaylight({1, 1, 1}));
  double apart = 0, all = 0;
  for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
    const Eigen::Vector3i& at = occupied.cell[v];
    const int other = of_turned.of_cell[turned.Index(at.x(), at.y(), 10 - at.z())];
    const float a = ground[static_cast<std::size_t>(other)][1], b = sky.sky[v][1];
    apart += (a - b) * (a - b);
    all += b * b;
  }
  // 64 directions against 512 in 6 bands, through voxels without likeness
  EXPECT_LT(std::sqrt(apart / all), 0.05);
}

}  // namespace
}  // namespace relight
