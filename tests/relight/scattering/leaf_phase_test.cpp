// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/leaf_phase.h"

#include "relight/sh/quadrature.h"
#include "tests/support/made_light.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace relight {
namespace {

using std::numbers::pi;

// Nothing is lost: over all directions of the eye the mean is 1.
TEST(LeafPhase, HasTheMeanOne) {
  for (const double transmitted : {0.0, 0.3, 0.5, 1.0}) {
    double mean = 0;
    for (const auto& [eye, weight_sr] : SphereQuadrature()) {
      mean += weight_sr / (4 * pi) * LeafPhase(eye.z(), transmitted);
    }
    EXPECT_NEAR(mean, 1, 1e-6);  // Quadrature of a function with a root at one end
  }
}

// (S11) against leaves of all directions, one by one: |n w| |n e| where the light is on
// the eye's side of the leaf, and where it has to go through. Light and eye may change
// places in that sum, and so in p.
TEST(LeafPhase, IsThatOfFlatLeavesTurnedToAllDirections) {
  const Eigen::Vector3d light(0, 0, 1);
  for (const double angle_rad : {0.0, 0.4, 1.1, pi / 2, 2.3, pi}) {
    const Eigen::Vector3d eye(std::sin(angle_rad), 0, std::cos(angle_rad));
    for (const double transmitted : {0.0, 0.4, 1.0}) {
      double sum = 0;
      for (const auto& [normal, weight_sr] : SphereQuadrature()) {
        const double both = normal.dot(light) * normal.dot(eye);
        sum += weight_sr / (4 * pi) * std::abs(both) *
               (both > 0 ? 1 - transmitted : transmitted);
      }
      EXPECT_NEAR(LeafPhase(light.dot(eye), transmitted), 8 * sum, 3e-3) << angle_rad;
    }
  }
}

TEST(LeafPhase, ReflectingLeavesAreBrightBeforeTheSun) {
  EXPECT_NEAR(LeafPhase(1, 0), 8.0 / 3, 1e-12);
  EXPECT_NEAR(LeafPhase(-1, 0), 0, 1e-12);
  EXPECT_NEAR(LeafPhase(-1, 1), 8.0 / 3, 1e-12);
  EXPECT_NEAR(LeafPhase(0, 0), 8 / (3 * pi), 1e-12);
}

// One leaf in the open: the sun by its own angle, and of light from everywhere the same
// as from leaves that scatter evenly.
TEST(LeafPhase, OfALeafInTheOpen) {
  ExtinctionGrid grid = tests::Slab({3, 3, 3}, 0.2, 0.0);
  grid.Set(1, 1, 1, 1e-30f);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const SkyTransmittance sky = ProjectTransmittance(grid, occupied);
  Daylight daylight = UniformDaylight({1000, 2000, 3000}, /*full_sphere=*/true);
  daylight.sun_direction = Eigen::Vector3d(0.3, -0.4, 1.0).normalized();
  daylight.sun_irradiance = {100, 90, 80};
  const ArrivingLight even = LightArriving(grid, occupied, sky, daylight);
  ArrivingLight light = even;
  const Eigen::Vector3d eye(4, -8, 1.6);
  ScatterTowards(eye, 0.3, grid, occupied, sky, daylight, light);
  const double cosine =
      (eye - grid.Center(1, 1, 1)).normalized().dot(daylight.sun_direction);
  EXPECT_NEAR(light.sun[0][1], 90 * LeafPhase(cosine, 0.3), 1e-4);
  // By 1024 directions of the transmittance
  EXPECT_LT((light.sky[0] / even.sky[0] - 1).abs().maxCoeff(), 2e-3);
}

}  // namespace
}  // namespace relight
