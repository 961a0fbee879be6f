// SPDX-License-Identifier: Apache-2.0
#include "matting/cluster_matting.h"
#include "matting/mask_trimap.h"
#include "matting/screen_trimap.h"
#include "matting/trimap.h"
#include "relight/base/error.h"
#include "relight/base/parallel.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include <cmath>
#include <random>
#include <string>

namespace relight {
namespace {

TEST(Strokes, AreTheTwoColoursOfAPicture) {
  cv::Mat3f picture(20, 30, cv::Vec3f(0.5f, 0.5f, 0.5f));
  picture(cv::Rect(2, 3, 5, 2)).setTo(cv::Scalar(1, 1, 1));
  picture(cv::Rect(20, 10, 4, 4)).setTo(cv::Scalar(0, 0, 0));
  const cv::Mat1b strokes = StrokesFromPicture(picture, {});
  EXPECT_EQ(strokes(3, 2), kTrimapForeground);
  EXPECT_EQ(strokes(10, 20), kTrimapBackground);
  EXPECT_EQ(strokes(0, 0), kTrimapUnknown);
  EXPECT_EQ(CountLabels(strokes).foreground, 10);
  EXPECT_EQ(CountLabels(strokes).background, 16);
}

TEST(Strokes, LieOnACanvasOrOnNothing) {
  // Green and red on black: black is the canvas
  cv::Mat3f picture(20, 20, cv::Vec3f(0, 0, 0));
  picture.row(2).setTo(cv::Scalar(0, 1, 0));
  picture.row(9).setTo(cv::Scalar(1, 0, 0));
  TrimapCounts counts = CountLabels(StrokesFromPicture(picture, {}));
  EXPECT_EQ(counts.foreground, 20);
  EXPECT_EQ(counts.background, 20);
  // The same drawn on a transparent layer
  cv::Mat1f alpha(20, 20, 0.0f);
  alpha.row(2).setTo(1.0f);
  counts = CountLabels(StrokesFromPicture(picture, alpha));
  EXPECT_EQ(counts.foreground, 20);
  EXPECT_EQ(counts.background, 0);
  EXPECT_THROW(StrokesFromPicture(cv::Mat3f(9, 9, cv::Vec3f(0.5f, 0.4f, 0.5f)), {}),
               InputError);
}

TEST(Strokes, AreTwoMasks) {
  cv::Mat1f tree(10, 10, 0.0f), not_tree(10, 10, 0.0f);
  tree.row(1).setTo(1.0f);
  not_tree.row(8).setTo(1.0f);
  const cv::Mat1b strokes = StrokesFromMasks(tree, not_tree);
  EXPECT_EQ(CountLabels(strokes).foreground, 10);
  EXPECT_EQ(CountLabels(strokes).background, 10);
  not_tree.row(1).setTo(1.0f);
  EXPECT_THROW(StrokesFromMasks(tree, not_tree), InputError);
  EXPECT_THROW(StrokesFromMasks(tree, cv::Mat1f(3, 3, 0.0f)), InputError);
}

// A dark green disc with a hole before a bright sky, cut by hand as a full disc that is
// a little too large.
struct HandCut {
  cv::Mat3f display = cv::Mat3f(200, 200, cv::Vec3f(0.5f, 0.7f, 0.95f));
  cv::Mat1f mask = cv::Mat1f(200, 200, 0.0f);
  HandCut() {
    cv::circle(display, {100, 100}, 60, cv::Scalar(0.15, 0.3, 0.1), -1);
    cv::circle(display, {110, 90}, 9, cv::Scalar(0.5, 0.7, 0.95), -1);
    cv::circle(mask, {100, 100}, 62, cv::Scalar(1), -1);
    std::mt19937 random(3);
    std::normal_distribution<float> noise(0.0f, 0.01f);
    for (cv::Vec3f& color : display) {
      for (int c = 0; c < 3; ++c) color[c] += noise(random);
    }
  }
};

TEST(MaskTrimap, OpensFilledHoles) {
  const HandCut cut;
  const cv::Mat1b trimap = TrimapFromMask(cut.display, cut.mask, {.band_px = 5});
  EXPECT_EQ(trimap(90, 110), kTrimapUnknown);        // The hole
  EXPECT_EQ(trimap(90, 110 + 9), kTrimapUnknown);    // Its edge
  EXPECT_EQ(trimap(130, 90), kTrimapForeground);     // Leaves stay
  EXPECT_EQ(trimap(100, 100 + 60), kTrimapUnknown);  // The true edge
  EXPECT_EQ(trimap(100, 100 + 72), kTrimapBackground);
  EXPECT_EQ(trimap(100, 100 + 50), kTrimapForeground);
}

TEST(MaskTrimap, RefusesMasksWithoutInsideOrOutside) {
  const HandCut cut;
  EXPECT_THROW(TrimapFromMask(cut.display, cv::Mat1f(200, 200, 0.0f)), InputError);
  EXPECT_THROW(TrimapFromMask(cut.display, cv::Mat1f(200, 200, 1.0f)), InputError);
  EXPECT_THROW(TrimapFromMask(cut.display, cv::Mat1f(20, 200, 1.0f)), InputError);
}

// A brown disc before a blue screen that is lit unevenly.
cv::Mat3f BeforeAScreen() {
  cv::Mat3f linear(160, 160);
  for (int y = 0; y < 160; ++y) {
    for (int x = 0; x < 160; ++x) {
      const float light = 0.4f + 0.6f * static_cast<float>(x) / 160;
      const cv::Vec3f screen = light * cv::Vec3f(0.02f, 0.08f, 0.5f);
      const double r = std::hypot(x - 80.0, y - 80.0);
      const auto a = static_cast<float>(std::clamp((46 - r) / 6, 0.0, 1.0));
      linear(y, x) = a * cv::Vec3f(0.25f, 0.18f, 0.08f) + (1 - a) * screen;
    }
  }
  return linear;
}

TEST(ScreenTrimap, TellsScreenFromObject) {
  const cv::Mat3f linear = BeforeAScreen();
  const Screen screen = FindScreen(linear, "auto");
  EXPECT_EQ(screen.channel, 2);
  const cv::Mat1b trimap = TrimapFromScreen(linear, screen);
  for (const int x : {5, 20, 140, 155}) EXPECT_EQ(trimap(80, x), kTrimapBackground) << x;
  for (const int x : {60, 80, 100}) EXPECT_EQ(trimap(80, x), kTrimapForeground) << x;
  EXPECT_EQ(trimap(80, 80 + 43), kTrimapUnknown);
  EXPECT_EQ(FindScreen(linear, "10,70,190").channel, 2);
}

TEST(ScreenTrimap, RefusesPhotosWithoutScreen) {
  const cv::Mat3f grey(30, 30, cv::Vec3f(0.2f, 0.2f, 0.2f));
  EXPECT_THROW(FindScreen(grey, "auto"), InputError);
  EXPECT_THROW(FindScreen(BeforeAScreen(), "green"), InputError);
  for (const char* words : {"purple", "1,2", "1,2,3,4", "1,2,x", "1,2,300", "90,80,70"}) {
    EXPECT_THROW(FindScreen(grey, words), OptionError) << words;
  }
}

TEST(ScreenTrimap, SpillIsNeverAboveBothOthers) {
  cv::Mat3f colors(1, 2, cv::Vec3f(0.2f, 0.3f, 0.5f));
  colors(0, 1) = {0.4f, 0.2f, 0.1f};
  RemoveSpill(colors, {{0.02f, 0.08f, 0.5f}, 2});
  EXPECT_EQ(colors(0, 0), cv::Vec3f(0.2f, 0.3f, 0.3f));
  EXPECT_EQ(colors(0, 1), cv::Vec3f(0.4f, 0.2f, 0.1f));
}

// Two noisy colours mixed in LAB, as the equation says. [Reche04, Eq. 3]
TEST(ClusterMatting, FindsTheShareOfTwoClusters) {
  const cv::Vec3f leaf(40, -30, 35), sky(75, -5, -25);
  cv::Mat3f lab(40, 120);
  cv::Mat1b trimap(lab.size(), kTrimapUnknown);
  std::mt19937 random(9);
  std::normal_distribution<float> noise(0.0f, 1.5f);
  for (int y = 0; y < lab.rows; ++y) {
    for (int x = 0; x < lab.cols; ++x) {
      const float a = x < 30 ? 0.0f : x >= 90 ? 1.0f : static_cast<float>(x - 30) / 60;
      lab(y, x) = a * leaf + (1 - a) * sky;
      for (int c = 0; c < 3; ++c) lab(y, x)[c] += noise(random);
      if (x < 30) trimap(y, x) = kTrimapBackground;
      if (x >= 90) trimap(y, x) = kTrimapForeground;
    }
  }
  cv::Mat3f display;
  cv::cvtColor(lab, display, cv::COLOR_Lab2RGB);
  SetThreadCount(1);
  const cv::Mat1f alpha = EstimateClusterMatte(display, trimap);
  SetThreadCount(2);
  EXPECT_EQ(cv::norm(alpha, EstimateClusterMatte(display, trimap), cv::NORM_INF), 0.0);
  SetThreadCount(0);
  double sum = 0;
  for (int y = 0; y < lab.rows; ++y) {
    EXPECT_EQ(alpha(y, 5), 0.0f);
    EXPECT_EQ(alpha(y, 110), 1.0f);
    for (int x = 30; x < 90; ++x) sum += std::abs(alpha(y, x) - (x - 30) / 60.0);
  }
  // The colours lie 79 units apart; noise along the line is 1.5 of them in each pixel
  EXPECT_LT(sum / (40 * 60), 2 * 1.5 / 79);
}

TEST(ClusterMatting, RefusesTrimapsItCannotUse) {
  const cv::Mat3f grey(30, 30, cv::Vec3f(0.2f, 0.2f, 0.2f));
  EXPECT_THROW(EstimateClusterMatte(grey, cv::Mat1b(30, 30, kTrimapUnknown)), InputError);
  EXPECT_THROW(EstimateClusterMatte(grey, cv::Mat1b(3, 30, kTrimapUnknown)), InputError);
}

}  // namespace
}  // namespace relight
