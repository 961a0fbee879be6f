// SPDX-License-Identifier: Apache-2.0
#include "relight/volume/visual_hull.h"

#include "relight/base/error.h"
#include "relight/volume/matte_agreement.h"
#include "relight/volume/opacity_estimation.h"
#include "tests/support/made_cameras.h"
#include "tests/support/reference_tree.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <iostream>

namespace relight {
namespace {

const Eigen::Vector3d kCenter(3, -2, 2.5);
constexpr double kRadius_m = 1.0;

// The silhouettes of a ball, in closed form: rays that pass its centre nearer than its
// radius.
std::vector<MatteView> BallViews() {
  std::vector<MatteView> views;
  for (const Camera& camera : tests::RingOfCameras(kCenter, 12, 12, 200, 900)) {
    MatteView view{
        "view_" + std::to_string(views.size()), camera, cv::Mat1f(200, 200, 0.0f)};
    for (int row = 0; row < 200; ++row) {
      for (int column = 0; column < 200; ++column) {
        const Eigen::Vector3d ray = camera.RayInWorld({column + 0.5, row + 0.5});
        const double away_m = (kCenter - camera.PositionInWorld()).cross(ray).norm();
        if (away_m < kRadius_m) view.alpha(row, column) = 1.0f;
      }
    }
    views.push_back(view);
  }
  return views;
}

TEST(VisualHull, HoldsABallAndLittleMore) {
  const Eigen::AlignedBox3d hull = HullBounds(BallViews());
  const Eigen::Vector3d reach = Eigen::Vector3d::Constant(kRadius_m);
  EXPECT_TRUE(hull.contains(Eigen::AlignedBox3d(kCenter - reach, kCenter + reach)));
  const Eigen::Vector3d beyond_low = kCenter - reach - hull.min();
  const Eigen::Vector3d beyond_high = hull.max() - kCenter - reach;
  std::cout << "beyond the ball: " << beyond_low.transpose() << ", "
            << beyond_high.transpose() << " m\n";
  // 12 silhouettes leave some 4 % around a ball, half a footprint and 1.5 voxels of
  // 1/30 of its radius more
  EXPECT_LT(beyond_low.maxCoeff(), 0.15 * kRadius_m);
  EXPECT_LT(beyond_high.maxCoeff(), 0.15 * kRadius_m);
}

TEST(VisualHull, ForgivesOneMatteOfTwelveOnlyWhenAsked) {
  std::vector<MatteView> views = BallViews();
  views[5].alpha.rowRange(0, 100).setTo(0);  // The upper half is lost
  const double top_m = kCenter.z() + kRadius_m;
  EXPECT_LT(HullBounds(views).max().z(), top_m - 0.2);
  EXPECT_GT(HullBounds(views, {.kth_smallest = 2}).max().z(), top_m);
}

TEST(VisualHull, SaysWhatIsWrong) {
  std::vector<MatteView> views = BallViews();
  EXPECT_THROW(HullBounds({views.data(), 1}), InputError);
  std::vector<MatteView> empty = views;
  empty[3].alpha.setTo(0);
  try {
    HullBounds(empty);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("view_3: the matte holds no tree"),
              std::string::npos);
  }
  // Two photos from one place
  EXPECT_THROW(HullBounds(std::vector<MatteView>{views[0], views[0]}), InputError);
  // Mattes of other cameras: no point of space is in all
  std::vector<MatteView> apart = views;
  for (std::size_t v = 0; v < apart.size(); ++v) {
    apart[v].alpha.setTo(0);
    apart[v].alpha(cv::Rect(v % 2 == 0 ? 0 : 170, 80, 30, 30)).setTo(1);
  }
  EXPECT_THROW(HullBounds(apart), InputError);
  EXPECT_THROW(HullBounds(views, {}, Progress([](double) { return false; })), Cancelled);
}

TEST(VisualHull, HoldsARenderedTree) {
  RELIGHT_SKIP_WITHOUT_SHARED("reference/cabral2011/maple");
  RELIGHT_SKIP_WITHOUT_SHARED("data/maple/sparse");
  const tests::ReferenceTree tree = tests::ReadReferenceTree("maple");
  std::vector<MatteView> views;
  for (const auto& [view, camera] : tree.cameras) {
    views.push_back({view, camera, tests::ReadTrueMatte("maple", view)});
  }
  const Eigen::AlignedBox3d hull = HullBounds(views);
  const Eigen::Vector3d low = tree.true_box.min() - hull.min();
  const Eigen::Vector3d high = hull.max() - tree.true_box.max();
  std::cout << "beyond the tree: " << low.transpose() << ", " << high.transpose()
            << " m\n";
  // A voxel of the hull is 0.14 m: single leaves at the rim cover less than 2 % of its
  // footprint, and a dozen views leave some voxels of a hull outside
  EXPECT_GT(low.minCoeff(), -0.15);
  EXPECT_GT(high.minCoeff(), -0.15);
  EXPECT_LT(low.maxCoeff(), 0.6);
  EXPECT_LT(high.maxCoeff(), 0.6);
}

Eigen::AlignedBox3d BoxOf(const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
  return {low, high};
}

TEST(VisualHull, OfALargerBoxTheSameVoxelsAreKept) {
  const Eigen::AlignedBox3d hull = BoxOf({-1.05, -2.03, 0.24}, {1.01, 2.33, 6.95});
  const Eigen::AlignedBox3d box = BoxOf({-10, -10, -10}, {10, 10, 10});
  const VoxelBox part = PartWithin(box, 200, hull);  // Voxels of 0.1 m
  // Rounding of a sum: 1e-9 m
  EXPECT_LT((part.bounds.min() - Eigen::Vector3d(-1.1, -2.1, 0.2)).norm(), 1e-9);
  EXPECT_TRUE(part.bounds.contains(hull));
  EXPECT_LT((part.bounds.sizes() - hull.sizes()).maxCoeff(), 0.2 + 1e-9);
  const ExtinctionGrid grid = EmptyGrid(part.bounds, part.cells);
  EXPECT_NEAR(grid.cell_m, 0.1, 1e-12);
  // On the box's own voxels
  const Eigen::Vector3d steps = (grid.origin_m - box.min()) / 0.1;
  EXPECT_LT((steps.array() - steps.array().round()).abs().maxCoeff(), 1e-6);
}

TEST(VisualHull, ASmallerBoxIsTakenAsItIs) {
  const Eigen::AlignedBox3d hull = BoxOf({-5, -5, 0}, {5, 5, 9}),
                            box = BoxOf({-1, -1, 2}, {1, 1, 4});
  const VoxelBox part = PartWithin(box, 20, hull);
  EXPECT_EQ(part.cells, 20);
  EXPECT_LT((part.bounds.min() - box.min()).norm(), 1e-9);
  EXPECT_LT((part.bounds.max() - box.max()).norm(), 1e-9);
}

TEST(VisualHull, ABoxBesideTheTreeIsRefused) {
  const Eigen::AlignedBox3d hull = BoxOf({-5, -5, 0}, {5, 5, 9});
  for (const double away : {-20.0, 20.0, 1e7}) {
    const Eigen::AlignedBox3d box(Eigen::Vector3d::Constant(away),
                                  Eigen::Vector3d::Constant(away + 2));
    EXPECT_THROW(PartWithin(box, 20, hull), InputError) << away;
  }
}

TEST(VisualHull, CornersOfABoxAreRead) {
  const Eigen::AlignedBox3d box = BoxFromText("1,-2,3.5,-1,2,0");
  EXPECT_EQ(box.min(), Eigen::Vector3d(-1, -2, 0));
  EXPECT_EQ(box.max(), Eigen::Vector3d(1, 2, 3.5));
  for (const char* wrong : {"", "1,2,3", "0,0,0,1,1,0", "0,0,0,1,1,x", "nan,0,0,1,1,1"}) {
    EXPECT_THROW(BoxFromText(wrong), OptionError) << wrong;
  }
}

TEST(MatteAgreement, ForgivesTwoMattesThatMissTheTree) {
  std::vector<MatteView> views = BallViews();
  views[5].alpha.rowRange(0, 100).setTo(0);  // The upper half is lost
  views[9].alpha.colRange(0, 100).setTo(0);
  const MatteAgreement agreement = AgreementOf(views);
  EXPECT_EQ(agreement.kth_smallest, 3);
  // Half a ball and a half of the rest are carved away; a ray that still meets a part of
  // what is left is not lost
  EXPECT_GT(agreement.lost, 0.3);
  EXPECT_LT(agreement.left, 0.05);
  // As EstimateOpacity takes it when nothing is said
  const Eigen::AlignedBox3d box = HullBounds(views, {.kth_smallest = 3});
  const auto asked = EstimateOpacity(views, box, {.cells = 24, .kth_smallest = 3});
  EXPECT_EQ(EstimateOpacity(views, box, {.cells = 24}).grid.sigma_per_m,
            asked.grid.sigma_per_m);
}

TEST(MatteAgreement, BelievesGoodMattes) {
  std::vector<MatteView> views = BallViews();
  EXPECT_EQ(AgreementOf(views).kth_smallest, 1);
  EXPECT_LT(AgreementOf(views).lost, 0.02);
  // And mattes too few to say which of them is wrong
  views.resize(5);
  views[3].alpha.rowRange(0, 100).setTo(0);
  EXPECT_EQ(AgreementOf(views).kth_smallest, 1);
}

}  // namespace
}  // namespace relight
