// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/sky_in_photo.h"

#include "relight/photo/color.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace relight {
namespace {

constexpr int kRows = 300, kCols = 400, kHorizon = 210;
const cv::Rect kCrown(120, 60, 160, 120), kStem(190, 150, 20, 80);

struct MadePhoto {
  cv::Mat3f pixels;  // Linear.
  cv::Mat1f alpha;
};

// A tree before a blue sky; below it a meadow, which is not smooth.
MadePhoto TreeOnAMeadow() {
  MadePhoto photo{cv::Mat3f(kRows, kCols), cv::Mat1f(kRows, kCols, 0.0f)};
  cv::Mat1f leaf(kRows, kCols);
  cv::RNG random(1);
  random.fill(leaf, cv::RNG::UNIFORM, 0.6, 1.4);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kCols; ++column) {
      const float down = static_cast<float>(row) / kRows, l = leaf(row, column);
      cv::Vec3f display(0.35f + 0.3f * down, 0.55f + 0.25f * down, 0.85f);
      if (row >= kHorizon) display = cv::Vec3f(0.35f * l, 0.42f * l, 0.15f * l);
      if (kCrown.contains({column, row}) || kStem.contains({column, row})) {
        display = cv::Vec3f(0.15f * l, 0.2f * l, 0.1f * l);
        photo.alpha(row, column) = 1;
      }
      for (int c = 0; c < 3; ++c)
        photo.pixels(row, column)[c] = LinearFromSrgb(display[c]);
    }
  }
  return photo;
}

TEST(SkyEnds, WhereTheMeadowBeginsAlsoBehindTheTree) {
  const MadePhoto photo = TreeOnAMeadow();
  const cv::Mat1f ends = SkyEnds(photo.pixels, photo.alpha);
  ASSERT_EQ(ends.size(), cv::Size(kCols, 1));
  for (int column = 0; column < kCols; ++column) {
    // What is smooth is told over 5 pixels: its edge to 3
    EXPECT_NEAR(ends(column), kHorizon, 3) << column;
  }
}

TEST(SkyEnds, TheMatteStaysAsItIs) {
  const MadePhoto photo = TreeOnAMeadow();
  const cv::Mat1f before = photo.alpha.clone();
  Camera camera;
  camera.width_px = kCols;
  camera.height_px = kRows;
  camera.focal_px = {400, 400};
  camera.center_px = {kCols / 2.0, kHorizon};
  SkySamples(photo.pixels, photo.alpha, camera, {0, 0, 1}, 0);
  SkyEnds(photo.pixels, photo.alpha);
  EXPECT_EQ(cv::norm(photo.alpha, before, cv::NORM_INF), 0);
}

TEST(SkyEnds, AreRowsOfThePhotosOwnSize) {
  const MadePhoto photo = TreeOnAMeadow();
  MadePhoto large;
  cv::resize(photo.pixels, large.pixels, {}, 4, 4, cv::INTER_NEAREST);
  cv::resize(photo.alpha, large.alpha, {}, 4, 4, cv::INTER_NEAREST);
  const cv::Mat1f ends = SkyEnds(large.pixels, large.alpha);
  ASSERT_EQ(ends.size(), cv::Size(4 * kCols, 1));
  EXPECT_NEAR(ends(40), 4 * kHorizon, 12);
}

TEST(SkyEnds, WhatIsLikeTheSkyBelowTheGroundIsNone) {
  MadePhoto photo = TreeOnAMeadow();
  // A lake
  photo.pixels(cv::Rect(20, 250, 60, 30)).setTo(photo.pixels(200, 40));
  EXPECT_NEAR(SkyEnds(photo.pixels, photo.alpha)(50), kHorizon, 3);
}

TEST(SkyEnds, APhotoWithoutSkyHasNone) {
  const MadePhoto photo = TreeOnAMeadow();
  const cv::Rect meadow(0, 235, kCols, 60);
  const cv::Mat1f ends = SkyEnds(photo.pixels(meadow), photo.alpha(meadow));
  EXPECT_EQ(cv::countNonZero(ends), 0);
}

}  // namespace
}  // namespace relight
