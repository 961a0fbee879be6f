// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/arriving_light.h"

#include "relight/base/error.h"
#include "relight/scattering/swept_transmittance.h"
#include "relight/scattering/transmittance.h"
#include "relight/sh/quadrature.h"
#include "relight/volume/ray_traversal.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

namespace relight {
namespace {

using std::numbers::pi;

// [Cabral11, Eq. 8]'s second term at the centre of one voxel, direction by direction.
Eigen::Array3d SkyByQuadrature(const ExtinctionGrid& grid,
                               const Eigen::Vector3i& cell,
                               const Daylight& daylight) {
  const VoxelRows rows = RowsOf(grid);
  Eigen::Array3d light = Eigen::Array3d::Zero();
  for (const auto& [direction, weight_sr] : SphereQuadrature()) {
    const Eigen::Array3d radiance = daylight.SkyRadiance(direction);
    if ((radiance == 0).all()) continue;
    const auto pattern = RayPattern(grid.cells, grid.cell_m, direction);
    float depth = 0.0f;
    RowOpticalDepth(
        grid, rows, pattern, cell.x(), cell.x() + 1, cell.y(), cell.z(), &depth);
    light += weight_sr * radiance * std::exp(-static_cast<double>(depth));
  }
  return light;
}

// E_2(x) = exp(-x) - x E_1(x), the exponential integral of a half-space under a uniform
// sky.
double ExponentialIntegral2(double x) { return std::exp(-x) + x * std::expint(-x); }

TEST(ArrivingLight, AnEmptyVolumeUnderAUniformSkyHasTwoPiL) {
  ExtinctionGrid grid = tests::Slab({5, 5, 5}, 0.2, 0.0);
  const Eigen::Array3d radiance(3000, 4000, 5000);
  const Daylight daylight = UniformDaylight(radiance);
  // By quadrature: exact but for the rounding of 4608 terms
  const Eigen::Array3d light = SkyByQuadrature(grid, {2, 2, 2}, daylight);
  EXPECT_LT((light / (2 * pi * radiance) - 1).abs().maxCoeff(), 1e-12);

  // By harmonics: the lattice of 1024 directions errs by less than 1 / 1024
  grid.Set(2, 2, 2, 1e-30f);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const ArrivingLight by_sh =
      LightArriving(grid, occupied, ProjectTransmittance(grid, occupied), daylight);
  const Eigen::Array3d ratio = by_sh.sky[0].cast<double>() / (2 * pi * radiance);
  std::cout << "6 bands over 2 pi L: " << ratio.transpose() << "\n";
  EXPECT_LT((ratio - 1).abs().maxCoeff(), 1e-3);
  EXPECT_TRUE((by_sh.sun[0] == 0).all());
  EXPECT_TRUE((by_sh.indirect[0] == 0).all());
}

TEST(ArrivingLight, AHalfSpaceUnderAUniformSkyHasTheExponentialIntegral) {
  // 10 optical depths to the nearest side: what comes in there is below exp(-10)
  const ExtinctionGrid grid = tests::Slab({41, 41, 12}, 0.25, 2.0);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const Eigen::Array3d radiance(1000, 2000, 4000);
  const Daylight daylight = UniformDaylight(radiance);
  const ArrivingLight by_sh =
      LightArriving(grid, occupied, ProjectTransmittance(grid, occupied), daylight);
  for (int z = 11; z >= 4; --z) {
    const double depth = 2.0 * 0.25 * (11.5 - z);
    const double closed_form = 2 * pi * ExponentialIntegral2(depth);
    const Eigen::Array3d light = SkyByQuadrature(grid, {20, 20, z}, daylight) / radiance;
    const auto voxel = static_cast<std::size_t>(occupied.of_cell[grid.Index(20, 20, z)]);
    const double six_bands = by_sh.sky[voxel][1] / radiance[1];
    std::cout << "optical depth " << depth << ": 2 pi E_2 " << closed_form
              << ", quadrature " << light[0] << ", 6 bands " << six_bands << "\n";
    EXPECT_LT((light / closed_form - 1).abs().maxCoeff(), 0.01);  // The contract's
  }
}

// exp(-sigma z / cos) of the sun in a slab, and no sun at night.
TEST(ArrivingLight, TheSunIsAttenuatedAlongItsWay) {
  const ExtinctionGrid grid = tests::Slab({31, 31, 8}, 0.25, 1.2);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const SkyTransmittance sky =
      ProjectTransmittance(grid, occupied, {.bands = 1, .directions = 64});
  Daylight daylight = UniformDaylight({0, 0, 0});
  daylight.sun_direction = Eigen::Vector3d(0.3, -0.4, 1.0).normalized();
  daylight.sun_irradiance = {100000, 90000, 80000};
  const ArrivingLight light = LightArriving(grid, occupied, sky, daylight);
  for (int z = 0; z < 8; ++z) {
    const auto voxel = static_cast<std::size_t>(occupied.of_cell[grid.Index(15, 15, z)]);
    const double way_m = 0.25 * (7.5 - z) / daylight.sun_direction.z();
    const Eigen::Array3d closed_form = daylight.sun_irradiance * std::exp(-1.2 * way_m);
    EXPECT_LT((light.sun[voxel].cast<double>() / closed_form - 1).abs().maxCoeff(),
              1e-5);  // Floats, summed over the way
    EXPECT_TRUE((light.sky[voxel] == 0).all());
  }
}

// (S3): without its own shade a voxel has the light of the face where the sun comes in.
TEST(ArrivingLight, AVoxelNeedNotShadeItself) {
  const ExtinctionGrid grid = tests::Slab({31, 31, 8}, 0.25, 1.2);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const SkyTransmittance sky =
      ProjectTransmittance(grid, occupied, {.bands = 1, .directions = 64});
  Daylight daylight = UniformDaylight({0, 0, 0});
  daylight.sun_direction = Eigen::Vector3d(0.3, -0.4, 1.0).normalized();
  daylight.sun_irradiance = {100000, 90000, 80000};
  for (const double share : {0.0, 0.5, 1.0}) {
    const ArrivingLight light =
        LightArriving(grid, occupied, sky, daylight, {.own_shade = share});
    for (int z = 0; z < 8; ++z) {
      const auto voxel =
          static_cast<std::size_t>(occupied.of_cell[grid.Index(15, 15, z)]);
      const double way_m = 0.25 * (7 - z + share / 2) / daylight.sun_direction.z();
      EXPECT_NEAR(light.sun[voxel][1] / (90000 * std::exp(-1.2 * way_m)), 1, 1e-5);
    }
  }
  EXPECT_THROW(LightArriving(grid, occupied, sky, daylight, {.own_shade = 1.1}),
               OptionError);
}

// (S9) is the mean of exp(-g D) over a gamma distribution of g of mean 1 and variance k.
TEST(ArrivingLight, ClumpsAreRegionsOfManyDensities) {
  for (const double k : {0.2, 0.5, 0.9}) {
    for (const double depth : {0.1, 1.0, 5.0}) {
      double sum = 0, weights = 0;
      constexpr double kStep = 1e-3;
      for (double g = kStep / 2; g < 30; g += kStep) {
        const double weight = std::pow(g, 1 / k - 1) * std::exp(-g / k);
        sum += weight * std::exp(-g * depth);
        weights += weight;
      }
      EXPECT_NEAR(TransmittanceOfDepth(depth, k), sum / weights, 1e-4);
    }
    EXPECT_EQ(TransmittanceOfDepth(0, k), 1);
  }
  EXPECT_EQ(TransmittanceOfDepth(1.5, 0), std::exp(-1.5));
  EXPECT_NEAR(TransmittanceOfDepth(1.5, 1e-6), std::exp(-1.5), 1e-6);
}

// Sun and sky alike: the sun in a slab, and the sky by one direction after the other.
TEST(ArrivingLight, ClumpsLetMoreLightThrough) {
  const ExtinctionGrid grid = tests::Slab({31, 31, 8}, 0.25, 1.2);
  const OccupiedVoxels occupied = FindOccupied(grid);
  constexpr double kClumping = 0.6;
  const SkyTransmittanceOptions one_band = {.bands = 1, .directions = 256};
  const SkyTransmittance sky =
      ProjectTransmittance(grid, occupied, one_band, {}, nullptr, kClumping);
  Daylight daylight = UniformDaylight({1, 1, 1}, /*full_sphere=*/true);
  daylight.sun_direction = Eigen::Vector3d(0.3, -0.4, 1.0).normalized();
  daylight.sun_irradiance = {1, 1, 1};
  const ArrivingLight light =
      LightArriving(grid, occupied, sky, daylight, {.clumping = kClumping});
  std::vector<double> mean(occupied.cell.size(), 0.0);
  for (const Eigen::Vector3d& direction : SphereDirections(256)) {
    const std::vector<float> tau = TransmittanceSwept(grid, occupied, direction);
    for (std::size_t v = 0; v < tau.size(); ++v) {
      mean[v] += TransmittanceOfDepth(-std::log(tau[v]), kClumping) / 256;
    }
  }
  for (int z = 0; z < 8; ++z) {
    const auto voxel = static_cast<std::size_t>(occupied.of_cell[grid.Index(15, 15, z)]);
    const double depth = 1.2 * 0.25 * (7.5 - z) / daylight.sun_direction.z();
    // Floats, summed over the way
    EXPECT_NEAR(light.sun[voxel][0], TransmittanceOfDepth(depth, kClumping), 1e-5);
    // Half floats of the same swept ways
    EXPECT_NEAR(light.sky[voxel][0] / (4 * pi), mean[voxel], 5e-4);
  }
  const ArrivingLight random = LightArriving(
      grid, occupied, ProjectTransmittance(grid, occupied, one_band), daylight);
  for (std::size_t v = 0; v < light.sun.size(); ++v) {
    EXPECT_GE(light.sun[v][0], random.sun[v][0]);
    EXPECT_GE(light.sky[v][0], random.sky[v][0]);
  }
}

// An opaque roof whose edge is seen just before the sun's centre hides half of its disc.
TEST(ArrivingLight, AnEdgeBeforeTheSunsCentreHidesHalfOfIt) {
  constexpr int kRoof = 20;
  ExtinctionGrid grid = tests::Slab({9, 3, kRoof + 1}, 0.1, 0.0);
  for (int y = 0; y < 3; ++y) {
    for (int x = 5; x < 9; ++x) grid.Set(x, y, kRoof, 1e9f);
  }
  grid.Set(4, 1, 0, 1e-30f);  // The voxel that is looked at
  const OccupiedVoxels occupied = FindOccupied(grid);
  const SkyTransmittance sky =
      ProjectTransmittance(grid, occupied, {.bands = 1, .directions = 64});
  const auto seen = [&](double aside_rad, int directions) {
    // From the voxel's centre to the upper edge of the roof, and a little aside
    const double edge_rad = std::atan2(0.5, kRoof + 0.5) + aside_rad;
    Daylight daylight = UniformDaylight({0, 0, 0});
    daylight.sun_direction = {std::sin(edge_rad), 0, std::cos(edge_rad)};
    daylight.sun_irradiance = {1, 1, 1};
    const ArrivingLight light =
        LightArriving(grid, occupied, sky, daylight, {.sun_directions = directions});
    return light.sun[static_cast<std::size_t>(occupied.of_cell[grid.Index(4, 1, 0)])][0];
  };
  constexpr double kRadius_rad = 0.004652;
  EXPECT_NEAR(seen(0, 256), 0.5, 0.03);  // 256 directions: the edge crosses some 2 x 16
  EXPECT_NEAR(seen(0, 16), 0.5, 0.13);   // Two of sixteen
  EXPECT_NEAR(seen(-1.01 * kRadius_rad, 256), 1.0, 1e-5);  // A sum of floats
  EXPECT_EQ(seen(1.01 * kRadius_rad, 256), 0.0f);
  // Part of a disc beyond a chord at half the radius: acos(1/2) / pi - sqrt(3) / (4 pi)
  EXPECT_NEAR(seen(0.5 * kRadius_rad, 1024), 1.0 / 3 - std::sqrt(3) / (4 * pi), 0.02);
  EXPECT_EQ(seen(-0.1 * kRadius_rad, 1), 1.0f);
  EXPECT_EQ(seen(0.1 * kRadius_rad, 1), 0.0f);
}

// In a slab there are no edges: the disc is as good as its centre.
TEST(ArrivingLight, TheDiscIsItsCentreWhereTheShadowIsSoft) {
  const ExtinctionGrid grid = tests::Slab({31, 31, 8}, 0.25, 1.2);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const SkyTransmittance sky =
      ProjectTransmittance(grid, occupied, {.bands = 1, .directions = 64});
  Daylight daylight = UniformDaylight({0, 0, 0});
  daylight.sun_irradiance = {1, 1, 1};
  for (const Eigen::Vector3d& sun :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.3, -0.4, 1)}) {
    daylight.sun_direction = sun.normalized();
    const ArrivingLight disc =
        LightArriving(grid, occupied, sky, daylight, {.sun_directions = 16});
    const ArrivingLight centre = LightArriving(grid, occupied, sky, daylight);
    for (int z = 0; z < 8; ++z) {
      const auto v = static_cast<std::size_t>(occupied.of_cell[grid.Index(15, 15, z)]);
      // Up to 2.4 optical depths x 0.0047 x tan of 27 degrees / sqrt(16) directions
      EXPECT_NEAR(disc.sun[v][0] / centre.sun[v][0], 1.0, 2e-3);
    }
  }
  EXPECT_THROW(LightArriving(grid, occupied, sky, daylight, {.sun_directions = 0}),
               OptionError);
}

// Twice the sun and sky give twice the light: in one unit, nothing is clipped.
TEST(ArrivingLight, IsLinearInTheDaylight) {
  const ExtinctionGrid grid = tests::RandomCanopy({7, 8, 9}, 0.2, 3.0, /*seed=*/8);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const SkyTransmittance sky = ProjectTransmittance(grid, occupied, {.directions = 256});
  Daylight daylight = UniformDaylight({3000, 4000, 5000});
  daylight.sun_direction = Eigen::Vector3d(0.5, 0.1, 0.6).normalized();
  daylight.sun_irradiance = {100000, 90000, 80000};
  Daylight twice = UniformDaylight({6000, 8000, 10000});
  twice.sun_direction = daylight.sun_direction;
  twice.sun_irradiance = 2 * daylight.sun_irradiance;
  const ArrivingLight one = LightArriving(grid, occupied, sky, daylight);
  const ArrivingLight two = LightArriving(grid, occupied, sky, twice);
  for (std::size_t v = 0; v < one.sun.size(); ++v) {
    EXPECT_TRUE((2 * one.sun[v] == two.sun[v]).all());  // Doubling a float is exact
    EXPECT_TRUE((2 * one.sky[v] == two.sky[v]).all());
    EXPECT_TRUE((one.sky[v] >= 0).all());
  }
}

TEST(ArrivingLight, RefusesTheTransmittanceOfAnotherVolume) {
  const ExtinctionGrid one = tests::Slab({3, 3, 3}, 0.2, 1.0);
  const ExtinctionGrid two = tests::Slab({4, 3, 3}, 0.2, 1.0);
  const SkyTransmittance sky =
      ProjectTransmittance(one, FindOccupied(one), {.bands = 1, .directions = 64});
  EXPECT_THROW(LightArriving(two, FindOccupied(two), sky, UniformDaylight({1, 1, 1})),
               std::logic_error);
}

}  // namespace
}  // namespace relight
