// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/rec709.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

TEST(Rec709, WhiteIsD65WithTheLuminanceOne) {
  const Eigen::Array3d xyz = XyzFromRec709(Eigen::Array3d::Ones());
  EXPECT_NEAR(xyz.y(), 1.0, 1e-15);
  EXPECT_NEAR(xyz.x() / xyz.sum(), 0.3127, 5e-5);  // The standard's own four digits
  EXPECT_NEAR(xyz.z() / xyz.sum(), 1 - 0.3127 - 0.3290, 5e-5);
}

// Four digits, and D65 in five digits is 0.00004 in x from the four of the standard.
TEST(Rec709, LuminanceHasTheWeightsOfTheStandard) {
  EXPECT_NEAR(XyzFromRec709({1, 0, 0}).y(), 0.2126, 1e-4);
  EXPECT_NEAR(XyzFromRec709({0, 1, 0}).y(), 0.7152, 1e-4);
  EXPECT_NEAR(XyzFromRec709({0, 0, 1}).y(), 0.0722, 1e-4);
}

TEST(Rec709, ThereAndBackIsTheSameColourOutsideTheGamutToo) {
  for (const Eigen::Array3d& rgb :
       {Eigen::Array3d(0.2, 3.0, 7.0), Eigen::Array3d(2, 1, -0.5)}) {
    EXPECT_TRUE(Rec709FromXyz(XyzFromRec709(rgb)).isApprox(rgb, 1e-14));  // Rounding
  }
}

}  // namespace
}  // namespace relight
