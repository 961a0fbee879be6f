// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/opacity_estimation.h"

#include "relight/base/error.h"
#include "relight/volume/ray_traversal.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <iostream>
#include <numeric>

namespace relight {
namespace {

constexpr double kRadius_m = 1.5, kSigma_per_m = 2.0;
const Eigen::Vector3d kCenter(0.4, -0.3, 2.0);

ExtinctionGrid TrueBall(double sigma_per_m = kSigma_per_m) {
  return tests::Ball(kCenter, kRadius_m, sigma_per_m, 60);
}

std::vector<MatteView> BallViews(int count = 12, double sigma_per_m = kSigma_per_m) {
  const ExtinctionGrid ball = TrueBall(sigma_per_m);
  std::vector<MatteView> views;
  for (const Camera& camera : tests::RingOfCameras(kCenter, 12, count, 120, 400)) {
    views.push_back(
        {"view_" + std::to_string(views.size()), camera, RenderOpacity(ball, camera)});
  }
  return views;
}

Eigen::AlignedBox3d BallBox() {
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(kRadius_m + 0.1);
  return {kCenter - reach, kCenter + reach};
}

double Rms(const cv::Mat1f& a, const cv::Mat1f& b) {
  return cv::norm(a, b, cv::NORM_L2) / std::sqrt(static_cast<double>(a.total()));
}

// 1 - exp(-sigma x chord) of a ball.
TEST(OpacityEstimation, RendersABallAsItsClosedForm) {
  const Camera camera = tests::LookingAt({0.4, -12.3, 2}, kCenter, 61, 61, 200);
  const cv::Mat1f opacity = RenderOpacity(TrueBall(), camera);
  double sum = 0, sum2 = 0;
  for (int row = 0; row < 61; ++row) {
    for (int column = 0; column < 61; ++column) {
      const Eigen::Vector3d ray = camera.RayInWorld({column + 0.5, row + 0.5});
      const double away_m = (kCenter - camera.PositionInWorld()).cross(ray).norm();
      const double half2 = kRadius_m * kRadius_m - away_m * away_m;
      const double chord_m = half2 > 0 ? 2 * std::sqrt(half2) : 0;
      const double error = opacity(row, column) + std::expm1(-kSigma_per_m * chord_m);
      sum += error;
      sum2 += error * error;
    }
  }
  // A ball of cubes of 1/30 of its radius is rough by half of one at its rim
  EXPECT_NEAR(sum / 3721, 0.0, 0.005);
  EXPECT_LT(std::sqrt(sum2 / 3721), 0.03);
}

// [Reche04, Eq. 9]: one pixel, n equal cells on its ray: t_i = t_p^(1/n), in one step,
// from any equal start. Two views of one column from both ends.
TEST(OpacityEstimation, SharesAPixelsOpacityAmongTheCellsOfItsRay) {
  std::vector<MatteView> views;
  for (const double side : {-1.0, 1.0}) {
    const Camera camera = tests::LookingAt({0, 100 * side, 0}, {0, 0, 0}, 3, 3, 50);
    views.push_back({"v", camera, cv::Mat1f(3, 3, 0.0f)});
    views.back().alpha(1, 1) = 0.8f;
  }
  const Eigen::AlignedBox3d column(Eigen::Vector3d(-0.25, -2, -0.25),
                                   Eigen::Vector3d(0.25, 2, 0.25));
  const OpacityEstimate estimate = EstimateOpacity(
      views, column, {.method = VolumeMethod::kReche2004, .cells = 8, .iterations = 1});
  ASSERT_EQ(estimate.grid.cells, Eigen::Vector3i(1, 8, 1));
  for (const float sigma : tests::AllValues(estimate.grid)) {
    EXPECT_NEAR(std::exp(-8 * 0.5 * sigma), 0.2, 1e-5);  // Logarithms of floats
  }
  EXPECT_LT(estimate.summary.residual_rms, 1e-5);
}

// [Reche04, Eq. 13] by hand: two pixels move each cell to the mean of what they ask for,
// weighted by the squares of their distances (lengths, cells and pixels are alike).
TEST(OpacityEstimation, MovesACellToTheWeightedMeanOfItsPixels) {
  std::vector<MatteView> views;
  for (const double y_m : {-20.0, 30.0}) {
    const Camera camera = tests::LookingAt({0, y_m, 0}, {0, 0, 0}, 3, 3, 20);
    views.push_back({"v", camera, cv::Mat1f(3, 3, 0.0f)});
    views.back().alpha(1, 1) = y_m < 0 ? 0.8f : 0.5f;
  }
  const Eigen::AlignedBox3d column(Eigen::Vector3d(-0.25, -2, -0.25),
                                   Eigen::Vector3d(0.25, 2, 0.25));
  const ExtinctionGrid grid = EstimateOpacity(views,
                                              column,
                                              {.method = VolumeMethod::kReche2004,
                                               .cells = 8,
                                               .iterations = 1,
                                               .cutoff = 1.0})
                                  .grid;
  for (int cell = 0; cell < 8; ++cell) {
    const double y_m = -1.75 + 0.5 * cell;
    const double near2 = std::pow(20 + y_m, 2), far2 = std::pow(30 - y_m, 2);
    const double t =
        (near2 * std::pow(0.2, 1.0 / 8) + far2 * std::pow(0.5, 1.0 / 8)) / (near2 + far2);
    EXPECT_NEAR(std::exp(-0.5 * grid.At(0, cell, 0)), t, 1e-6);
  }
}

double TotalExtinction(const ExtinctionGrid& grid) {
  return std::accumulate(grid.sigma_per_m.begin(), grid.sigma_per_m.end(), 0.0) *
         std::pow(grid.cell_m, 3);
}

// A cell of [Reche04, Eq. 9] counts in full however short the ray's way in it, which is
// 2/3 of its edge in the mean (4 x volume / surface, Cauchy): so much of the extinction
// is found, and a scale of 3/2 gives the ball back.
TEST(OpacityEstimation, GivesTheMattesOfABallBack) {
  const double thin_per_m = 0.9;
  const std::vector<MatteView> views = BallViews(12, thin_per_m);
  const ExtinctionGrid truth = TrueBall(thin_per_m);
  const auto [grid, summary] = EstimateOpacity(views,
                                               BallBox(),
                                               {.method = VolumeMethod::kReche2004,
                                                .cells = 24,
                                                .iterations = 20,
                                                .cutoff = 1.0,
                                                .scale = 1.5});
  // From where no photo was taken
  const Camera unseen = tests::LookingAt(
      kCenter + 12 * DirectionFromAzimuthElevation(0.26, 0.5), kCenter, 120, 120, 400);
  const double held_out = Rms(RenderOpacity(grid, unseen), RenderOpacity(truth, unseen));
  const double total = TotalExtinction(grid) / TotalExtinction(truth);
  std::cout << "residual " << summary.residual_rms << ", unseen view " << held_out
            << ", extinction over the truth " << total << "\n";
  // Voxels of 1/11 of the radius: at the rim opacity rises within one of them
  EXPECT_LT(summary.residual_rms, 0.04);
  EXPECT_LT(held_out, 0.04);
  EXPECT_NEAR(total, 1.0, 0.07);  // 2/3 is the mean for rays from all sides, not of 12
}

TEST(OpacityEstimation, FindsTwoThirdsOfTheExtinctionWithoutAScale) {
  const auto [grid, summary] = EstimateOpacity(
      BallViews(), BallBox(), {.method = VolumeMethod::kReche2004, .cells = 24});
  const double total = TotalExtinction(grid) / TotalExtinction(TrueBall());
  std::cout << "residual " << summary.residual_rms << ", extinction over the truth "
            << total << "\n";
  EXPECT_NEAR(total, 2.0 / 3, 0.04);
  // Thinner by a third where the ball is thin, at its rim: 0.14 of opacity there
  EXPECT_LT(summary.residual_rms, 0.14);
}

// The first pass undoes the start, which is too opaque; from then on it gets better.
TEST(OpacityEstimation, MorePassesFitBetter) {
  const std::vector<MatteView> views = BallViews(6);
  double before = 1.0;
  for (const int iterations : {2, 4, 8}) {
    const auto [grid, summary] = EstimateOpacity(
        views,
        BallBox(),
        {.method = VolumeMethod::kReche2004, .cells = 24, .iterations = iterations});
    EXPECT_LT(summary.residual_rms, before);
    EXPECT_EQ(summary.iterations, iterations);
    before = summary.residual_rms;
  }
}

TEST(OpacityEstimation, OneBadMatteOfTwelveIsForgiven) {
  std::vector<MatteView> views = BallViews();
  views[4].alpha.colRange(0, 60).setTo(0);  // Half of the tree taken for sky
  const OpacityOptions first{.method = VolumeMethod::kReche2004, .cells = 24},
      second{.method = VolumeMethod::kReche2004, .cells = 24, .kth_smallest = 2};
  const auto lost = EstimateOpacity(views, BallBox(), first);
  const auto kept = EstimateOpacity(views, BallBox(), second);
  const auto good = EstimateOpacity(BallViews(), BallBox(), first);
  const Camera unseen = tests::LookingAt(
      kCenter + 12 * DirectionFromAzimuthElevation(0.26, 0.0), kCenter, 120, 120, 400);
  const cv::Mat1f reference = RenderOpacity(good.grid, unseen);
  const double error_lost = Rms(RenderOpacity(lost.grid, unseen), reference);
  const double error_kept = Rms(RenderOpacity(kept.grid, unseen), reference);
  std::cout << "off what good mattes give: k = 1 by " << error_lost << ", k = 2 by "
            << error_kept << "; voxels " << lost.summary.occupied_voxels << ", "
            << kept.summary.occupied_voxels << " of " << good.summary.occupied_voxels
            << "\n";
  EXPECT_LT(error_kept, 0.5 * error_lost);
  EXPECT_GT(kept.summary.occupied_voxels, 9 * good.summary.occupied_voxels / 10);
  EXPECT_LT(lost.summary.occupied_voxels, 7 * good.summary.occupied_voxels / 10);
}

TEST(OpacityEstimation, EmptiesWhatIsClearerThanTheCutoff) {
  const auto [grid, summary] = EstimateOpacity(
      BallViews(), BallBox(), {.method = VolumeMethod::kReche2004, .cells = 24});
  for (const float sigma : grid.sigma_per_m) {
    EXPECT_TRUE(sigma == 0.0f || std::exp(-sigma * grid.cell_m) <= 0.94 + 1e-6);
  }
}

TEST(OpacityEstimation, TheScaleMultipliesTheExtinction) {
  const std::vector<MatteView> views = BallViews(4);
  const auto one = EstimateOpacity(
      views, BallBox(), {.method = VolumeMethod::kReche2004, .cells = 16});
  const auto two = EstimateOpacity(
      views, BallBox(), {.method = VolumeMethod::kReche2004, .cells = 16, .scale = 2.0});
  for (std::size_t i = 0; i < one.grid.sigma_per_m.size(); ++i) {
    EXPECT_EQ(2 * one.grid.sigma_per_m[i], two.grid.sigma_per_m[i]);
  }
}

TEST(OpacityEstimation, DoesNotDependOnThreads) {
  const std::vector<MatteView> views = BallViews(5);
  const auto with = [&](int threads) {
    const tests::WithThreads limit(threads);
    return EstimateOpacity(
               views, BallBox(), {.method = VolumeMethod::kReche2004, .cells = 20})
        .grid.sigma_per_m;
  };
  EXPECT_TRUE(tests::SameBytes(with(1), with(2)));
}

// A volume of no extinction beside a matte of 1: the error is 1 where the matte's square
// lies whole inside, whatever the footprint.
TEST(OpacityEstimation, TheRmseOfAMatteAveragesOverTheFootprint) {
  const Camera camera = tests::LookingAt({0.4, -12.3, 2}, kCenter, 61, 61, 200);
  MatteView view{"v", camera, cv::Mat1f(61, 61, 0.0f)};
  view.alpha(cv::Rect(20, 20, 21, 21)).setTo(1.0f);
  ExtinctionGrid empty = TrueBall();
  std::fill(empty.sigma_per_m.begin(), empty.sigma_per_m.end(), 0.0f);
  // 21 of 27 pixels a side are 1
  EXPECT_NEAR(MatteRmse(empty, view, 0.01), 21.0 / 27, 1e-6);
  EXPECT_LT(MatteRmse(empty, view, 0.3), 21.0 / 27 - 0.01);
  view.alpha = RenderOpacity(TrueBall(), camera);
  EXPECT_EQ(MatteRmse(TrueBall(), view), 0.0);
}

TEST(OpacityEstimation, SaysWhatIsWrong) {
  const std::vector<MatteView> views = BallViews(4);
  const auto estimate = [&](const OpacityOptions& options) {
    return EstimateOpacity(views, BallBox(), options);
  };
  EXPECT_THROW(estimate({.cells = 7}), OptionError);
  EXPECT_THROW(estimate({.smoothness = -1.0}), OptionError);
  EXPECT_THROW(estimate({.leaf_spread = -1.0}), OptionError);
  EXPECT_THROW(estimate({.iterations = 0}), OptionError);
  EXPECT_THROW(estimate({.alpha_max = 1.0}), OptionError);
  EXPECT_THROW(estimate({.cutoff = 1.1}), OptionError);
  EXPECT_THROW(estimate({.kth_smallest = 9}), OptionError);
  EXPECT_THROW(estimate({.scale = 0.0}), OptionError);
  EXPECT_THROW(EstimateOpacity({views.data(), 1}, BallBox()), InputError);
  std::vector<MatteView> empty = views;
  for (MatteView& view : empty) view.alpha.setTo(0);
  try {
    EstimateOpacity(empty, BallBox(), {.method = VolumeMethod::kReche2004, .cells = 16});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("--kth-smallest"), std::string::npos);
  }
  EXPECT_THROW(
      EstimateOpacity(views, BallBox(), {}, Progress([](double) { return false; })),
      Cancelled);
}

}  // namespace
}  // namespace relight
