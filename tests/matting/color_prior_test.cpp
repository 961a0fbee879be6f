// SPDX-License-Identifier: Apache-2.0
#include "matting/color_prior.h"

#include "matting/trimap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace relight {
namespace {

const cv::Vec3f kLeaf(0.05f, 0.20f, 0.02f), kBark(0.10f, 0.06f, 0.04f),
    kSky(0.30f, 0.45f, 0.80f);

// A crown with a gap: leaf and bark known around an unknown hole, sky known outside only.
struct Crown {
  cv::Mat3f image{cv::Size(60, 40), kSky};
  cv::Mat1b trimap{cv::Size(60, 40), kTrimapBackground};
  Crown() {
    image(cv::Rect(10, 5, 40, 30)).setTo(kLeaf);
    image(cv::Rect(30, 5, 20, 30)).setTo(kBark);
    trimap(cv::Rect(10, 5, 40, 30)).setTo(kTrimapForeground);
    trimap(cv::Rect(20, 10, 20, 20)).setTo(kTrimapUnknown);
  }
};

TEST(ColorPrior, FindsMixturesInsideACrown) {
  Crown crown;
  for (int i = 0; i <= 10; ++i) {
    const float a = static_cast<float>(i) / 10;
    crown.image(20, 22 + i) = a * kLeaf + (1 - a) * kSky;
  }
  const ColorPrior prior = EstimateColorPrior(crown.image, crown.trimap);
  for (int i = 0; i <= 10; ++i) {
    // The pairs with bark, and the preference for pure colours, pull by a little
    EXPECT_NEAR(prior.alpha(20, 22 + i), static_cast<float>(i) / 10, 0.08) << i;
    EXPECT_GT(prior.confidence(20, 22 + i), 0.5f) << i;
  }
  EXPECT_EQ(prior.confidence(0, 0), 0.0f);  // Known
}

TEST(ColorPrior, PrefersPureColoursToMixturesThatExplainAsWell) {
  Crown crown;
  // A third foreground colour lies half-way between bark and sky: is the pixel it, or a
  // mixture?
  const cv::Vec3f between = 0.5f * (kBark + kSky);
  crown.image(cv::Rect(10, 5, 10, 30)).setTo(between);
  crown.image(20, 30) = between;
  const ColorPrior pure = EstimateColorPrior(crown.image, crown.trimap, {.purity = 20});
  const ColorPrior any = EstimateColorPrior(crown.image, crown.trimap, {.purity = 0});
  EXPECT_GT(pure.alpha(20, 30), 0.95f);
  EXPECT_LT(any.alpha(20, 30), pure.alpha(20, 30) - 0.1f);
  EXPECT_LT(any.confidence(20, 30), pure.confidence(20, 30));
}

TEST(ColorPrior, KnowsSunlitLeavesFromShadedOnesBeforeTheSky) {
  Crown crown;
  for (int i = 0; i <= 5; ++i) {  // Three times as bright as any leaf that is known
    const float a = 0.5f + 0.1f * static_cast<float>(i);
    crown.image(20, 22 + i) = 3 * a * kLeaf + (1 - a) * kSky;
  }
  const ColorPrior dark = EstimateColorPrior(crown.image, crown.trimap);
  const ColorPrior tree = EstimateColorPrior(crown.image, crown.trimap, {.brightest = 4});
  double dark_error = 0, tree_error = 0;
  for (int i = 0; i <= 5; ++i) {
    const float a = 0.5f + 0.1f * static_cast<float>(i);
    dark_error += std::abs(dark.alpha(20, 22 + i) - a);
    tree_error += std::abs(tree.alpha(20, 22 + i) - a);
    // Other pairs explain the pixel as well, with bark for leaf: they pull to either side
    EXPECT_NEAR(tree.alpha(20, 22 + i), a, 0.12) << i;
  }
  EXPECT_LT(tree_error, 0.5 * dark_error);
}

// A leaf of any brightness is told from sky by its hue, as before a blue screen: alpha
// does not depend on how much light falls on the leaf.
TEST(ColorPrior, DoesNotDependOnALeafsLightBeforeTheSky) {
  for (const float a : {0.3f, 0.5f, 0.7f, 1.0f}) {
    std::vector<float> found;
    for (const float light : {1.0f, 1.4f, 2.0f, 2.8f, 4.0f}) {
      Crown crown;
      crown.image.setTo(kLeaf, crown.trimap == kTrimapForeground);
      crown.image.setTo(kSky, crown.trimap == kTrimapBackground);
      crown.image(20, 30) = light * a * kLeaf + (1 - a) * kSky;
      const ColorPrior prior =
          EstimateColorPrior(crown.image, crown.trimap, {.brightest = 4});
      found.push_back(prior.alpha(20, 30));
      // One hue of leaf, one of sky: the mixture is known but for rounding
      EXPECT_NEAR(found.back(), a, 1e-3) << light;
    }
  }
}

TEST(ColorPrior, IsNotSureOfColoursItHasNotSeen) {
  Crown crown;
  crown.image(20, 30) = cv::Vec3f(0.9f, 0.05f, 0.05f);
  const ColorPrior prior = EstimateColorPrior(crown.image, crown.trimap);
  EXPECT_LT(prior.confidence(20, 30), 0.01f);
}

}  // namespace
}  // namespace relight
