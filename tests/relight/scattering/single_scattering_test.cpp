// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/single_scattering.h"

#include "relight/volume/opacity_estimation.h"
#include "relight/volume/ray_traversal.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

namespace relight {
namespace {

// Sums in doubles of light kept as floats.
constexpr double kFloat = 1e-6;

Daylight SunOnly(const Eigen::Vector3d& direction) {
  Daylight daylight = UniformDaylight({0, 0, 0});
  daylight.sun_direction = direction.normalized();
  daylight.sun_irradiance = {1000, 500, 250};
  return daylight;
}

ArrivingLight LightOf(const ExtinctionGrid& grid,
                      const OccupiedVoxels& occupied,
                      const Daylight& daylight,
                      const SkyTransmittanceOptions& options = {}) {
  return LightArriving(
      grid, occupied, ProjectTransmittance(grid, occupied, options), daylight);
}

// A pixel whose ray meets the slab's upper face in its middle, under `view`.
ScatteringImages OnePixel(const ExtinctionGrid& grid,
                          const OccupiedVoxels& occupied,
                          const ArrivingLight& light,
                          const Eigen::Vector3d& towards_eye) {
  const Eigen::Vector3d top(0, 0, grid.Bounds().max().z());
  const Camera camera = tests::LookingAt(top + 20 * towards_eye, top, 1, 1, 1000);
  return SingleScattering(grid, occupied, {&light, 1}, camera);
}

// The slab of the closed form: 2 optical depths, each voxel 0.1.
ExtinctionGrid ClosedFormSlab() { return tests::Slab({121, 121, 20}, 0.1, 1.0); }

// E / S = (1 - exp(-sigma h (1/mu_s + 1/mu_v))) / (1 + mu_v / mu_s)
double SlabIrradiance(double depth, double mu_sun, double mu_view) {
  return -std::expm1(-depth * (1 / mu_sun + 1 / mu_view)) / (1 + mu_view / mu_sun);
}

TEST(SingleScattering, ASlabUnderTheSunHasItsClosedForm) {
  const ExtinctionGrid grid = ClosedFormSlab();
  const OccupiedVoxels occupied = FindOccupied(grid);
  double worst = 0.0;
  for (const Eigen::Vector3d& sun : {Eigen::Vector3d(0, 0, 1),
                                     Eigen::Vector3d(0.5, 0.2, 0.8),
                                     Eigen::Vector3d(-0.9, 0.6, 0.7)}) {
    const Daylight daylight = SunOnly(sun);
    const ArrivingLight light =
        LightOf(grid, occupied, daylight, {.bands = 1, .directions = 64});
    for (const Eigen::Vector3d& to_eye : {Eigen::Vector3d(0, 0, 1),
                                          Eigen::Vector3d(0.3, 0.8, 0.9),
                                          Eigen::Vector3d(-1.0, 0.1, 0.6)}) {
      const Eigen::Vector3d view = to_eye.normalized();
      const ScatteringImages images = OnePixel(grid, occupied, light, view);
      const double closed_form =
          SlabIrradiance(2.0, daylight.sun_direction.z(), view.z());
      for (int c = 0; c < 3; ++c) {
        const double relative =
            images.lights[0].sun(0, 0)[c] / (daylight.sun_irradiance[c] * closed_form) -
            1;
        worst = std::max(worst, std::abs(relative));
        // The contract's; light constant in a voxel of depth d errs by (2d / mu)^2 / 24
        EXPECT_LT(std::abs(relative), 0.01);
      }
      EXPECT_NEAR(images.weight(0, 0), -std::expm1(-2.0 / view.z()), kFloat);
    }
  }
  std::cout << "worst of 9 pairs of sun and view: " << worst << "\n";
}

// The half of a slab's error that comes of its voxels falls with their square.
TEST(SingleScattering, FinerVoxelsComeNearerToTheClosedForm) {
  const auto error = [](int cells) {
    const ExtinctionGrid grid =
        tests::Slab({6 * cells + 1, 6 * cells + 1, cells}, 2.0 / cells, 1.0);
    const OccupiedVoxels occupied = FindOccupied(grid);
    const ArrivingLight light =
        LightOf(grid, occupied, SunOnly({0, 0.3, 1}), {.bands = 1, .directions = 64});
    const ScatteringImages images =
        OnePixel(grid, occupied, light, Eigen::Vector3d::UnitZ());
    const double mu_sun = Eigen::Vector3d(0, 0.3, 1).normalized().z();
    return std::abs(
        images.lights[0].sun(0, 0)[0] / (1000 * SlabIrradiance(2, mu_sun, 1)) - 1);
  };
  const double coarse = error(5), fine = error(10);
  EXPECT_NEAR(coarse / fine, 4.0, 0.5);  // Second order, and the next one in 0.2^2
}

// Sun and eye change places: E / mu_s stays, as of any reflecting surface.
TEST(SingleScattering, IsReciprocal) {
  const ExtinctionGrid grid = ClosedFormSlab();
  const OccupiedVoxels occupied = FindOccupied(grid);
  const Eigen::Vector3d a = Eigen::Vector3d(0.2, 0.7, 0.8).normalized();
  const Eigen::Vector3d b = Eigen::Vector3d(-0.3, 0.1, 1.0).normalized();
  const auto reflected = [&](const Eigen::Vector3d& sun, const Eigen::Vector3d& eye) {
    const ArrivingLight light =
        LightOf(grid, occupied, SunOnly(sun), {.bands = 1, .directions = 64});
    return OnePixel(grid, occupied, light, eye).lights[0].sun(0, 0)[0] / sun.z();
  };
  EXPECT_NEAR(reflected(a, b) / reflected(b, a), 1.0, 0.005);  // The voxels' error, twice
}

// White furnace: in a volume that glows alike everywhere a ray sees that light, times
// the share of it that the volume stops.
TEST(SingleScattering, TheSameLightEverywhereIsSeenByItsWeight) {
  const ExtinctionGrid grid = tests::RandomCanopy({12, 13, 14}, 0.2, 3.0, /*seed=*/21);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const std::vector<Eigen::Array3f> white(occupied.cell.size(),
                                          Eigen::Array3f(2.0f, 4.0f, 8.0f));
  const std::vector<Eigen::Array3f> dark(occupied.cell.size(), Eigen::Array3f::Zero());
  const ArrivingLight light{dark, white, dark};
  for (const Camera& camera :
       tests::RingOfCameras(grid.Bounds().center(), 8, 4, 40, 100)) {
    const ScatteringImages images = SingleScattering(grid, occupied, {&light, 1}, camera);
    const cv::Mat1f opacity = RenderOpacity(grid, camera);
    for (int row = 0; row < 40; ++row) {
      for (int column = 0; column < 40; ++column) {
        const float weight = images.weight(row, column);
        // A ray ends at a transmittance of 1e-5
        EXPECT_NEAR(weight, opacity(row, column), 2e-5);
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(
              images.lights[0].sky(row, column)[c], (2 << c) * weight, 8 * kFloat);
        }
        EXPECT_EQ(images.lights[0].Total()(row, column),
                  images.lights[0].sky(row, column));
      }
    }
  }
}

// A thin cloud in a white furnace: every voxel receives 4 pi L.
TEST(SingleScattering, AThinCloudInAWhiteFurnaceIsWhite) {
  const double sigma = 1e-4;
  const ExtinctionGrid grid = tests::Slab({10, 10, 10}, 0.2, sigma);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const ArrivingLight light =
      LightOf(grid, occupied, UniformDaylight({1, 2, 3}, /*full_sphere=*/true));
  const ScatteringImages images =
      OnePixel(grid, occupied, light, Eigen::Vector3d(0.1, 0.2, 1).normalized());
  for (int c = 0; c < 3; ++c) {
    const double mean = images.lights[0].sky(0, 0)[c] / images.weight(0, 0);
    // Shaded by itself: an optical depth of at most 2e-4; 1e-4 for the sums of floats
    EXPECT_NEAR(mean / (4 * std::numbers::pi * (c + 1)), 1.0, 3e-4);
  }
}

// The integral as it stands, in steps of a hundredth of a voxel.
TEST(SingleScattering, AgreesWithSmallStepsAlongTheRay) {
  const ExtinctionGrid grid = tests::RandomCanopy({8, 9, 7}, 0.25, 2.0, /*seed=*/22);
  const OccupiedVoxels occupied = FindOccupied(grid);
  ArrivingLight light;
  std::mt19937 random(23);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  for (auto* part : {&light.sun, &light.sky, &light.indirect}) {
    for (std::size_t v = 0; v < occupied.cell.size(); ++v) {
      part->emplace_back(uniform(random), uniform(random), uniform(random));
    }
  }
  const Camera camera = tests::LookingAt({5, -4, 3}, {0, 0, 0.9}, 9, 9, 30);
  const ScatteringImages images = SingleScattering(grid, occupied, {&light, 1}, camera);
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) {
      const Eigen::Vector3d ray = camera.RayInWorld({column + 0.5, row + 0.5});
      const double step_m = 0.0025;
      double tau = 1.0;
      Eigen::Array3d total = Eigen::Array3d::Zero();
      for (double at_m = step_m / 2; at_m < 12; at_m += step_m) {
        const Eigen::Vector3d point = camera.PositionInWorld() + at_m * ray;
        const Eigen::Vector3d at = (point - grid.origin_m) / grid.cell_m;
        const Eigen::Vector3i cell = at.array().floor().cast<int>();
        const std::ptrdiff_t found = grid.Find(cell.x(), cell.y(), cell.z());
        if (found < 0) continue;
        const auto index = static_cast<std::size_t>(found);
        if (occupied.of_cell[index] < 0) continue;
        const auto v = static_cast<std::size_t>(occupied.of_cell[index]);
        const double share = -tau * std::expm1(-step_m * grid.sigma_per_m[index]);
        total += share * (light.sun[v] + light.sky[v] + light.indirect[v]).cast<double>();
        tau -= share;
      }
      for (int c = 0; c < 3; ++c) {
        // A voxel's entry is off by half a step: 2 x 0.00125 m x 2 /m x some 10 voxels,
        // of either sign
        EXPECT_NEAR(images.lights[0].Total()(row, column)[c], total[c], 0.02);
      }
    }
  }
}

TEST(SingleScattering, EqualLightsGiveEqualImagesAndTheMaskLeavesOut) {
  const ExtinctionGrid grid = tests::RandomCanopy({9, 9, 9}, 0.2, 2.0, /*seed=*/24);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const ArrivingLight light =
      LightOf(grid, occupied, SunOnly({1, 0, 1}), {.bands = 2, .directions = 64});
  const ArrivingLight lights[] = {light, light};
  const Camera camera = tests::LookingAt({5, -4, 3}, {0, 0, 0.9}, 30, 20, 60);
  cv::Mat1b mask(20, 30, static_cast<unsigned char>(255));
  mask.colRange(0, 15).setTo(0);
  const ScatteringImages all = SingleScattering(grid, occupied, lights, camera);
  const ScatteringImages half = SingleScattering(grid, occupied, lights, camera, mask);
  EXPECT_TRUE(tests::SameBytes(all.lights[0].sun, all.lights[1].sun));
  EXPECT_EQ(cv::countNonZero(half.weight.colRange(0, 15)), 0);
  EXPECT_GT(cv::countNonZero(half.weight), 0);
  EXPECT_EQ(
      cv::norm(half.weight.colRange(15, 30), all.weight.colRange(15, 30), cv::NORM_INF),
      0.0);
}

TEST(SingleScattering, DoesNotDependOnThreadsAndStops) {
  const ExtinctionGrid grid = tests::RandomCanopy({9, 9, 9}, 0.2, 2.0, /*seed=*/25);
  const OccupiedVoxels occupied = FindOccupied(grid);
  const Camera camera = tests::LookingAt({5, -4, 3}, {0, 0, 0.9}, 31, 23, 60);
  Daylight daylight = UniformDaylight({1, 2, 3});
  daylight.sun_irradiance = {5, 4, 3};
  const auto with = [&](int threads) {
    const tests::WithThreads limit(threads);
    const ArrivingLight light =
        LightOf(grid, occupied, daylight, {.bands = 3, .directions = 64});
    return SingleScattering(grid, occupied, {&light, 1}, camera);
  };
  const ScatteringImages one = with(1), two = with(2);
  EXPECT_TRUE(tests::SameBytes(one.lights[0].sun, two.lights[0].sun));
  EXPECT_TRUE(tests::SameBytes(one.lights[0].sky, two.lights[0].sky));
  EXPECT_TRUE(tests::SameBytes(one.weight, two.weight));
  EXPECT_THROW(SingleScattering(grid, occupied, {}, camera, {}, Progress([](double) {
                                  return false;
                                })),
               Cancelled);
}

}  // namespace
}  // namespace relight
