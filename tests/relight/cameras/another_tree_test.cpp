// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/another_tree.h"

#include "relight/base/angles.h"
#include "relight/cameras/colmap_model.h"
#include "tests/support/made_cameras.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace relight {
namespace {

// A camera of some 40 degrees at `position` that looks at `target`.
NamedCamera LookAt(const std::string& view,
                   const Eigen::Vector3d& position,
                   const Eigen::Vector3d& target) {
  return {view, tests::LookingAt(position, target, 600, 800, 900)};
}

Eigen::Vector3d Around(double azimuth_deg, double distance_m) {
  return distance_m * DirectionFromAzimuthElevation(RadFromDeg(azimuth_deg), 0) +
         Eigen::Vector3d(0, 0, 1.6);
}

std::vector<NamedCamera> Circle(int count, double step_deg) {
  std::vector<NamedCamera> cameras;
  for (int i = 0; i < count; ++i) {
    // Not all at the same point of the tree, nor from the same distance
    const Eigen::Vector3d target(0.5 * std::sin(i), 0.5 * std::cos(3 * i), 3 + i % 3);
    cameras.push_back(
        LookAt("v" + std::to_string(i), Around(i * step_deg, 12 + i % 5), target));
  }
  return cameras;
}

TEST(AnotherTree, ACircleHasNone) {
  EXPECT_TRUE(ViewsOfAnotherTree(Circle(36, 10)).empty());
  EXPECT_TRUE(ViewsOfAnotherTree(Circle(6, 15)).empty());  // A quarter of one
  EXPECT_TRUE(ViewsOfAnotherTree(Circle(200, 1.8)).empty());
}

TEST(AnotherTree, TheOneThatLooksElsewhereIsNamed) {
  std::vector<NamedCamera> cameras = Circle(12, 30);
  cameras[4] = LookAt("away", Around(120, 14), Around(120, 40));
  cameras[9] = LookAt("beside", Around(270, 14), {0, 25, 3});
  const auto strange = ViewsOfAnotherTree(cameras);
  ASSERT_EQ(strange.size(), 2u);
  EXPECT_EQ(strange[0].view, "away");
  EXPECT_NEAR(strange[0].off_axis_deg, 180, 15);  // The tree is high and wide
  EXPECT_EQ(strange[1].view, "beside");
  EXPECT_NEAR(strange[1].off_axis_deg, 61, 10);
}

TEST(AnotherTree, CamerasThatGoAroundNothingSayNothing) {
  // Straight down from a grid, in a row along a hedge, and too few
  std::vector<NamedCamera> down, row;
  for (int i = 0; i < 18; ++i) {
    const Eigen::Vector3d at(20 * (i % 6), 25 * (i / 6), 60);
    down.push_back(LookAt("d" + std::to_string(i), at, at - Eigen::Vector3d(0.5, 1, 60)));
    const Eigen::Vector3d along(5 * i, 0, 1.6);
    row.push_back(
        LookAt("r" + std::to_string(i), along, along + Eigen::Vector3d(0, 9, 1)));
  }
  EXPECT_TRUE(ViewsOfAnotherTree(down).empty());
  EXPECT_TRUE(ViewsOfAnotherTree(row).empty());
  EXPECT_TRUE(ViewsOfAnotherTree({}).empty());
  EXPECT_TRUE(ViewsOfAnotherTree(std::vector{LookAt("a", Around(0, 9), {0, 0, 3}),
                                             LookAt("b", Around(0, 9), Around(0, 20))})
                  .empty());
}

TEST(AnotherTree, RealAndRenderedCapturesHaveNone) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/photos/fern/sparse");
  for (const char* model : {"maple/sparse",
                            "birch/sparse",
                            "photos/fern/sparse",
                            "photos/brighton_park/sparse_enu"}) {
    SCOPED_TRACE(model);
    const auto strange =
        ViewsOfAnotherTree(ReadColmap(tests::SharedPath("data") / model).cameras);
    EXPECT_TRUE(strange.empty()) << strange.front().view;
  }
}

}  // namespace
}  // namespace relight
