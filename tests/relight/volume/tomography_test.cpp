// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/tomography.h"

#include "relight/base/error.h"
#include "relight/volume/opacity_estimation.h"
#include "relight/volume/ray_traversal.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <iostream>
#include <numeric>

namespace relight {
namespace {

constexpr double kRadius_m = 1.5;
const Eigen::Vector3d kCenter(0.4, -0.3, 2.0);

std::vector<MatteView> ViewsOf(const ExtinctionGrid& truth, int count = 12) {
  std::vector<MatteView> views;
  for (const Camera& camera : tests::RingOfCameras(kCenter, 12, count, 120, 400)) {
    views.push_back(
        {"view_" + std::to_string(views.size()), camera, RenderOpacity(truth, camera)});
  }
  return views;
}

Eigen::AlignedBox3d BallBox() {
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(kRadius_m + 0.1);
  return {kCenter - reach, kCenter + reach};
}

double TotalExtinction(const ExtinctionGrid& grid) {
  return std::accumulate(grid.sigma_per_m.begin(), grid.sigma_per_m.end(), 0.0) *
         std::pow(grid.cell_m, 3);
}

double Rms(const cv::Mat1f& a, const cv::Mat1f& b) {
  return cv::norm(a, b, cv::NORM_L2) / std::sqrt(static_cast<double>(a.total()));
}

// Without any scale: lengths are exact.
TEST(Tomography, GivesABallBack) {
  const ExtinctionGrid truth = tests::Ball(kCenter, kRadius_m, 0.9, 60);
  const Tomography found = EstimateTomography(ViewsOf(truth), BallBox(), {.cells = 40});
  const Camera unseen = tests::LookingAt(
      kCenter + 12 * DirectionFromAzimuthElevation(0.26, 0.5), kCenter, 120, 120, 400);
  const double held_out =
      Rms(RenderOpacity(found.grid, unseen), RenderOpacity(truth, unseen));
  const double total = TotalExtinction(found.grid) / TotalExtinction(truth);
  std::cout << "unseen view " << held_out << ", extinction over the truth " << total
            << "\n";
  // A voxel is 1/19 of the radius: the rim of the ball of cubes is rough by half of one
  EXPECT_LT(held_out, 0.03);
  EXPECT_NEAR(total, 1.0, 0.05);
}

// Its objective only falls at one resolution, but for momentum's small overshoots.
TEST(Tomography, Converges) {
  const ExtinctionGrid truth = tests::Ball(kCenter, kRadius_m, 2.0, 60);
  const Tomography found =
      EstimateTomography(ViewsOf(truth, 6), BallBox(), {.cells = 24});
  ASSERT_EQ(found.objective.size(), 16u);
  // From the second pass: the first weighs the prior by a guess
  EXPECT_LT(found.objective.back(), 0.5 * found.objective[1]);
  EXPECT_LT(found.objective.back(), 1.001 * found.objective[12]);
}

// A trunk behind leaves is as opaque as its matte says, in the round.
TEST(Tomography, WoodIsNotMadeFog) {
  ExtinctionGrid truth = tests::Ball(kCenter, kRadius_m, 0.3, 60);
  for (int z = 0; z < truth.cells.z(); ++z) {
    for (int y = 0; y < truth.cells.y(); ++y) {
      for (int x = 0; x < truth.cells.x(); ++x) {
        const Eigen::Vector3d from = truth.Center(x, y, z) - kCenter;
        if (from.head<2>().norm() < 0.2 && std::abs(from.z()) < 1.2)
          truth.Set(x, y, z, 60.0f);
      }
    }
  }
  const Tomography found = EstimateTomography(ViewsOf(truth), BallBox(), {.cells = 48});
  const Ray across{kCenter + Eigen::Vector3d(-5, -3.1, 0),
                   Eigen::Vector3d(5, 3.1, 0).normalized()};
  EXPECT_GT(-std::expm1(-OpticalDepth(found.grid, across)), 0.9);
}

// One wrong matte of eight, a tree taken for another: it is found and hardly counts.
TEST(Tomography, AWrongMatteIsTakenBackAndNamed) {
  const ExtinctionGrid truth = tests::Ball(kCenter, kRadius_m, 1.0, 60);
  std::vector<MatteView> views = ViewsOf(truth, 8);
  const Tomography good = EstimateTomography(views, BallBox(), {.cells = 40});
  views[3].alpha.colRange(0, 60).setTo(0);
  const TomographyOptions forgiving{.cells = 40, .kth_smallest = 2};
  const Tomography found = EstimateTomography(views, BallBox(), forgiving);
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_EQ(found.views[v].view, views[v].name);
    EXPECT_EQ(good.views[v].weight, 1.0);
    if (v == 3) {
      EXPECT_LT(found.views[v].weight, 0.3);
    } else {
      EXPECT_EQ(found.views[v].weight, 1.0) << v;
    }
  }
  EXPECT_NEAR(TotalExtinction(found.grid) / TotalExtinction(good.grid), 1.0, 0.1);
}

// Behind walls that nothing shines through there is what the walls are made of, not air.
TEST(Tomography, WhatNoPhotoSeesIsFilledFromItsSurroundings) {
  const ExtinctionGrid truth = tests::Ball(kCenter, kRadius_m, 12.0, 60);
  const Tomography found = EstimateTomography(ViewsOf(truth), BallBox(), {.cells = 40});
  EXPECT_GT(found.hidden_voxels, 0u);
  const Eigen::Vector3i middle = found.grid.cells / 2;
  EXPECT_GT(found.grid.At(middle.x(), middle.y(), middle.z()), 0.3f);
}

TEST(Tomography, DoesNotDependOnThreads) {
  const std::vector<MatteView> views =
      ViewsOf(tests::Ball(kCenter, kRadius_m, 2.0, 60), 5);
  const auto with = [&](int threads) {
    const tests::WithThreads limit(threads);
    return EstimateTomography(views, BallBox(), {.cells = 40}).grid.sigma_per_m;
  };
  const auto one = with(1);
  EXPECT_TRUE(tests::SameBytes(one, with(2)));
  EXPECT_TRUE(tests::SameBytes(one, with(8)));
}

TEST(Tomography, CanBeStopped) {
  const std::vector<MatteView> views =
      ViewsOf(tests::Ball(kCenter, kRadius_m, 2.0, 60), 3);
  for (const double at : {0.05, 0.4, 0.9}) {
    const Progress stop([&](double done) { return done < at; });
    EXPECT_THROW(EstimateTomography(views, BallBox(), {.cells = 24}, stop), Cancelled);
  }
}

}  // namespace
}  // namespace relight
