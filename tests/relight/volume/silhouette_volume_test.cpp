// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/silhouette_volume.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/cameras/level_camera.h"
#include "relight/volume/opacity_estimation.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <iostream>

namespace relight {
namespace {

constexpr double kDistance_m = 14.0;

// A round crown of opacity `alpha` on a level photo.
MatteView RoundCrown(float alpha) {
  const LevelCamera level =
      MakeLevelCamera(200, 240, 300, 0.4, {100, 200}, 40, {.distance_m = kDistance_m});
  MatteView view{"photo", level.camera, cv::Mat1f(240, 200, 0.0f)};
  for (int row = 0; row < 240; ++row) {
    for (int column = 0; column < 200; ++column) {
      if (std::hypot(column + 0.5 - 100, row + 0.5 - 110) < 70) {
        view.alpha(row, column) = alpha;
      }
    }
  }
  return view;
}

TEST(SilhouetteVolume, GivesItsMatteBack) {
  for (const float alpha : {0.3f, 0.7f, 0.95f}) {
    const MatteView view = RoundCrown(alpha);
    const ExtinctionGrid grid = SilhouetteVolume(view, kDistance_m);
    const cv::Mat1f opacity = RenderOpacity(grid, view.camera);
    double outer = 0, sum = 0, sum2 = 0;
    int inner_count = 0, rim_count = 0;
    for (int row = 0; row < 240; ++row) {
      for (int column = 0; column < 200; ++column) {
        const double radius = std::hypot(column + 0.5 - 100, row + 0.5 - 110);
        const double error = opacity(row, column) - view.alpha(row, column);
        if (radius < 60) {
          sum += error;
          sum2 += error * error;
          ++inner_count;
        } else if (radius > 76) {
          outer = std::max(outer, std::abs(error));
          ++rim_count;
        }
      }
    }
    const double rms = std::sqrt(sum2 / inner_count), mean = sum / inner_count;
    std::cout << "alpha " << alpha << ": error inside rms " << rms << ", mean " << mean
              << "; outside at most " << outer << "\n";
    // A chord of some 60 voxels is off by one or two of them: 3 % of an optical depth of
    // up to 3, times 1 - alpha
    EXPECT_LT(rms, 0.02);
    EXPECT_LT(std::abs(mean), 0.01);
    EXPECT_LT(outer, 1e-6);  // Two voxels beyond the outline there is nothing
    EXPECT_GT(rim_count, 0);
  }
}

// As deep as it is wide, around the distance given.
TEST(SilhouetteVolume, IsRound) {
  const MatteView view = RoundCrown(0.7f);
  const ExtinctionGrid grid = SilhouetteVolume(view, kDistance_m);
  const Eigen::Vector3d forward = view.camera.ForwardInWorld();
  const Eigen::Vector3d right = view.camera.camera_from_world.linear().row(0);
  Eigen::AlignedBox2d seen;  // Aside and ahead
  for (const Eigen::Vector3i& cell : FindOccupied(grid).cell) {
    const Eigen::Vector3d from_eye =
        grid.Center(cell.x(), cell.y(), cell.z()) - view.camera.PositionInWorld();
    seen.extend(Eigen::Vector2d(from_eye.dot(right), from_eye.dot(forward)));
  }
  const double radius_m = 70 * kDistance_m / 300;
  // Voxels of 1/50 of the radius, and the near half that is seen 1/4 larger
  EXPECT_NEAR(seen.max().y() - kDistance_m, radius_m, 0.05 * radius_m);
  EXPECT_NEAR(kDistance_m - seen.min().y(), radius_m, 0.05 * radius_m);
  EXPECT_NEAR(seen.center().x(), 0.0, 0.1 * radius_m);
}

// How far the volume reaches ahead of its axis at a share of the crown's height [m].
double HalfDepth(const ExtinctionGrid& grid, const MatteView& view, double u) {
  const Eigen::Vector3d forward = view.camera.ForwardInWorld();
  const double bottom_px = 180, top_px = 40;
  double reach_m = 0;
  for (const Eigen::Vector3i& cell : FindOccupied(grid).cell) {
    const Eigen::Vector3d center = grid.Center(cell.x(), cell.y(), cell.z());
    const double row = view.camera.Project(center)->y();
    if (std::abs(row - (bottom_px + u * (top_px - bottom_px))) > 2) continue;
    reach_m = std::max(
        reach_m, (center - view.camera.PositionInWorld()).dot(forward) - kDistance_m);
  }
  return reach_m;
}

TEST(SilhouetteVolume, TheCrownsShapeGivesItsDepth) {
  const MatteView view = RoundCrown(0.7f);
  const double radius_m = 70 * kDistance_m / 300;
  const auto half_depth = [&](Crown crown, double u, double ratio = 1.0) {
    const ExtinctionGrid grid = SilhouetteVolume(
        view, kDistance_m, {.shape = {.crown = crown, .depth_ratio = ratio}});
    return HalfDepth(grid, view, u) / radius_m;
  };
  // A third of the widest is reached a few rows from either end; voxels of 1/50
  constexpr double kNear = 0.1;
  EXPECT_NEAR(half_depth(Crown::kAuto, 0.5), 1, kNear);
  EXPECT_NEAR(half_depth(Crown::kAuto, 0.5, 0.5), 0.5, kNear);
  EXPECT_NEAR(half_depth(Crown::kRound, 0.5), 1, kNear);
  EXPECT_NEAR(half_depth(Crown::kRound, 0.9), 0.6, kNear);
  EXPECT_NEAR(half_depth(Crown::kCone, 0.2), 0.8, kNear);
  EXPECT_NEAR(half_depth(Crown::kCone, 0.8), 0.2, kNear);
  EXPECT_NEAR(half_depth(Crown::kVase, 0.2), 0.2, kNear);
  EXPECT_NEAR(half_depth(Crown::kVase, 0.8), 0.8, kNear);
  EXPECT_NEAR(half_depth(Crown::kColumnar, 0.2), 1, kNear);
  EXPECT_NEAR(half_depth(Crown::kColumnar, 0.9), 1, kNear);
}

// Whatever its depth, the matte comes back.
TEST(SilhouetteVolume, AnyCrownGivesItsMatteBack) {
  const MatteView view = RoundCrown(0.7f);
  for (const auto& [word, crown] : kCrownWords) {
    const ExtinctionGrid grid =
        SilhouetteVolume(view, kDistance_m, {.shape = {.crown = crown}});
    const cv::Mat1f opacity = RenderOpacity(grid, view.camera);
    double sum = 0;
    for (int row = 80; row < 140; ++row) {
      for (int column = 70; column < 130; ++column) sum += opacity(row, column);
    }
    EXPECT_NEAR(sum / (60 * 60), 0.7, 0.015) << word;
  }
}

// Seen by a camera that looks up, the tree neither leans nor changes its opacity.
TEST(SilhouetteVolume, StandsUprightBeforeATiltedCamera) {
  constexpr float kAlpha = 0.7f;
  Camera camera = tests::LookingAt(
      {0, -kDistance_m, 1.6}, {0, 0, 1.6 + kDistance_m * 0.36}, 200, 300, 300);
  ASSERT_NEAR(DegFromRad(ElevationOf(camera.ForwardInWorld())), 19.8, 0.1);
  // A crown of 3 m around the axis, 2 to 11 m high
  MatteView view{"photo", camera, cv::Mat1f(300, 200, 0.0f)};
  for (int row = 0; row < 300; ++row) {
    for (int column = 0; column < 200; ++column) {
      const Eigen::Vector3d ray = camera.RayInWorld({column + 0.5, row + 0.5});
      const Eigen::Vector3d p = camera.PositionInWorld() + ray * (kDistance_m / ray.y());
      if (std::abs(p.x()) < 3 && p.z() > 2 && p.z() < 11)
        view.alpha(row, column) = kAlpha;
    }
  }
  const ExtinctionGrid grid = SilhouetteVolume(view, kDistance_m);
  double low = 0, high = 0, low_count = 0, high_count = 0;
  for (const Eigen::Vector3i& cell : FindOccupied(grid).cell) {
    const Eigen::Vector3d center = grid.Center(cell.x(), cell.y(), cell.z());
    if (center.z() > 4.5 && center.z() < 5.5) {
      low += center.y();
      ++low_count;
    }
    if (center.z() > 7.5 && center.z() < 8.5) {
      high += center.y();
      ++high_count;
    }
  }
  // The farther half of a circle of radius r is seen through, so larger: its middle lies
  // r^2 / (4 d) behind the axis. A plane across the view direction would lean by 1.1 m
  // over these 3 m
  const double behind_m = 9 / (4 * kDistance_m);
  EXPECT_NEAR(low / low_count, behind_m, 0.03);
  EXPECT_NEAR(high / high_count, behind_m, 0.03);
  const cv::Mat1f opacity = RenderOpacity(grid, camera);
  for (const double z : {4.0, 6.0, 8.0}) {
    const auto pixel = camera.Project({0, 0, z});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(opacity(static_cast<int>(pixel->y()), static_cast<int>(pixel->x())),
                kAlpha,
                0.03);  // A chord of 60 voxels is off by one or two
  }
}

TEST(SilhouetteVolume, TheScaleMultipliesTheExtinction) {
  const ExtinctionGrid one =
      SilhouetteVolume(RoundCrown(0.7f), kDistance_m, {.cells = 40});
  const ExtinctionGrid half =
      SilhouetteVolume(RoundCrown(0.7f), kDistance_m, {.cells = 40, .scale = 0.5});
  for (std::size_t i = 0; i < one.sigma_per_m.size(); ++i) {
    EXPECT_EQ(one.sigma_per_m[i], 2 * half.sigma_per_m[i]);
  }
}

TEST(SilhouetteVolume, DoesNotDependOnThreads) {
  const auto with = [&](int threads) {
    const tests::WithThreads limit(threads);
    return SilhouetteVolume(RoundCrown(0.7f), kDistance_m, {.cells = 40}).sigma_per_m;
  };
  EXPECT_TRUE(tests::SameBytes(with(1), with(2)));
}

TEST(SilhouetteVolume, RefusesAMatteWithoutATree) {
  EXPECT_THROW(SilhouetteVolume(RoundCrown(0.0f), kDistance_m), InputError);
  EXPECT_THROW(SilhouetteVolume(RoundCrown(0.05f), kDistance_m), InputError);
}

}  // namespace
}  // namespace relight
