// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/footprint_opacity.h"

#include "relight/base/error.h"
#include "relight/volume/extinction_grid.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <limits>

namespace relight {
namespace {

// A table of sums in doubles, a mean kept as a float.
constexpr float kFloat = 1e-6f;

// One voxel of 0.1 m in the origin, and a camera 10 m south of it that sees it 10 pixels
// wide in the middle of 100 x 100.
ExtinctionGrid OneVoxel() {
  ExtinctionGrid grid = tests::Slab({1, 1, 1}, 0.1, 0.0);
  grid.origin_m = Eigen::Vector3d::Constant(-0.05);
  return grid;
}
MatteView View(float alpha) {
  return {"view",
          tests::LookingAt({0, -10, 0}, {0, 0, 0}, 100, 100, 1000),
          cv::Mat1f(100, 100, alpha)};
}

float Footprint(const std::vector<MatteView>& views, int kth_smallest = 1) {
  Footprints found = FootprintOpacity(OneVoxel(), views, {.kth_smallest = kth_smallest});
  return ExtinctionGrid{std::move(found.voxels), std::move(found.opacity)}.At(0, 0, 0);
}

TEST(FootprintOpacity, IsTheMeanOfTheSquareTheVoxelProjectsTo) {
  EXPECT_NEAR(Footprint({View(0.3f)}), 0.3f, kFloat);
  // Left half of the frame empty, right half full: the square is 45 to 55
  MatteView halves = View(0);
  halves.alpha.colRange(50, 100).setTo(1);
  EXPECT_NEAR(Footprint({halves}), 0.5f, kFloat);
  // A column of one pixel is a tenth of it, one outside is nothing
  MatteView column = View(0);
  column.alpha.colRange(45, 46).setTo(1);
  EXPECT_NEAR(Footprint({column}), 0.1f, kFloat);
  MatteView outside = View(0);
  outside.alpha.colRange(55, 100).setTo(1);
  outside.alpha.rowRange(0, 45).setTo(1);
  EXPECT_NEAR(Footprint({outside}), 0.0f, kFloat);
}

TEST(FootprintOpacity, TakesTheKthSmallestOverTheViews) {
  const std::vector<MatteView> views = {View(0.7f), View(0.1f), View(0.9f), View(0.4f)};
  EXPECT_NEAR(Footprint(views, 1), 0.1f, kFloat);
  EXPECT_NEAR(Footprint(views, 2), 0.4f, kFloat);
  EXPECT_NEAR(Footprint(views, 3), 0.7f, kFloat);
  EXPECT_NEAR(Footprint(views, 4), 0.9f, kFloat);
  EXPECT_NEAR(Footprint(views, 5), 0.1f, kFloat);  // Fewer views than k: the smallest
}

TEST(FootprintOpacity, AViewThatLooksAwayIsPassedOver) {
  MatteView away = View(0.05f);
  away.camera = tests::LookingAt({0, -10, 0}, {0, -20, 0}, 100, 100, 1000);
  EXPECT_NEAR(Footprint({away, View(0.6f)}), 0.6f, kFloat);
  EXPECT_EQ(Footprint({away}), 0.0f);  // Nobody knows
}

TEST(FootprintOpacity, BeyondTheFrameEmptyStaysEmptyAndACutTreeIsUnknown) {
  MatteView beside = View(0.0f);
  beside.camera = tests::LookingAt({0, -10, 0}, {5, 0, 0}, 100, 100, 1000);
  EXPECT_FALSE(beside.camera.Project({0, 0, 0})->x() > 0);  // Left of the frame
  EXPECT_EQ(Footprint({beside, View(0.6f)}), 0.0f);
  beside.alpha.setTo(0.5f);
  EXPECT_NEAR(Footprint({beside, View(0.6f)}), 0.6f, kFloat);
}

// What is below the least takes no memory, and nothing else changes.
TEST(FootprintOpacity, KeepsWhatIsNotBelowTheLeast) {
  const ExtinctionGrid box = tests::Slab({30, 20, 50}, 0.1, 0.0);
  MatteView upper = View(0.0f);
  upper.alpha.rowRange(0, 40).setTo(0.5f);
  const Footprints all = FootprintOpacity(box, {&upper, 1});
  const Footprints most = FootprintOpacity(box, {&upper, 1}, {.least_alpha = 0.4});
  EXPECT_LT(most.voxels.Size(), all.voxels.Size());
  EXPECT_LT(all.voxels.Size(), box.Count());
  std::size_t kept = 0;
  ForEachVoxel(all.voxels, [&](int x, int y, int z, std::size_t index) {
    const std::ptrdiff_t at = most.voxels.Find(x, y, z);
    const float alpha = at < 0 ? 0.0f : most.opacity[static_cast<std::size_t>(at)];
    EXPECT_EQ(alpha, all.opacity[index] < 0.4 ? 0.0f : all.opacity[index]);
    kept += alpha > 0;
  });
  EXPECT_GT(kept, 500u);
}

TEST(FootprintOpacity, RefusesMattesThatAreNone) {
  MatteView small = View(0.5f);
  small.alpha = cv::Mat1f(99, 100, 0.5f);
  EXPECT_THROW(Footprint({small}), InputError);
  for (const float wrong : {-0.01f, 1.01f, std::numeric_limits<float>::quiet_NaN()}) {
    MatteView bad = View(0.5f);
    bad.alpha(3, 4) = wrong;
    EXPECT_THROW(Footprint({View(0.5f), bad}), InputError) << wrong;
  }
  EXPECT_THROW(Footprint({View(0.5f)}, 0), OptionError);
}

}  // namespace
}  // namespace relight
