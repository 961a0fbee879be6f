// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/prepared_view.h"

#include "relight/base/error.h"
#include "relight/photo/color.h"
#include "tests/relight/capture/temporary_folder.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include <cmath>

namespace relight {
namespace {

// A round crown on a stem, of one colour, on nothing.
Photo CutOutTree(int width, int height) {
  Photo photo;
  photo.pixels = cv::Mat3f(height, width, cv::Vec3f(0.1f, 0.2f, 0.05f));
  photo.alpha = cv::Mat1f::zeros(height, width);
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      const double x = (column + 0.5) / width - 0.5, y = (row + 0.5) / height - 0.4;
      const bool crown = x * x + y * y < 0.09;
      const bool stem = std::abs(x) < 0.05 && y > 0 && y < 0.5;
      if (crown || stem) photo.alpha(row, column) = 1;
    }
  }
  return photo;
}

ViewRequest InMemory() {
  ViewRequest request;
  request.source = "pasted";
  request.picture = CutOutTree(80, 100);
  request.lit_from = "180,45";
  return request;
}

TEST(PreparedView, APictureInMemoryNeedsNoFile) {
  const ViewPlan plan = PlanView(InMemory(), false, {"hour", {}});
  EXPECT_FALSE(plan.capture);
  EXPECT_EQ(plan.name, "pasted");
  const PreparedView view = PrepareView(plan);
  EXPECT_EQ(cv::norm(view.photo.pixels, CutOutTree(80, 100).pixels, cv::NORM_INF), 0);
  EXPECT_EQ(view.cut.matte_source, "the photo's alpha");
  EXPECT_EQ(view.camera.width_px, 80);
  EXPECT_GT(view.tree.occupied.cell.size(), 0u);
}

TEST(PreparedView, WhatAPictureInMemoryCannotTellIsMissing) {
  ViewRequest request = InMemory();
  request.lit_from.reset();
  const std::string message = tests::MessageOf<InputError>([&] {
    PlanView(request, true, {"hour", {}});
  });
  for (const char* word : {"pasted", "--taken", "--zone", "--place", "--heading"})
    EXPECT_TRUE(tests::Holds(message, word)) << message;
}

TEST(PreparedView, ACamerasToneIsTakenOffAPictureInMemory) {
  ViewRequest request = InMemory();
  request.options["tone"] = "camera";
  const Photo photo = PixelsOf(PlanView(request, false, {"hour", {}}));
  const float expected =
      LinearFromSrgb(static_cast<float>(DisplayFromCamera(SrgbFromLinear(0.2f))));
  EXPECT_FLOAT_EQ(photo.pixels(50, 40)[1], expected);
}

TEST(PreparedView, SmallerKeepsColoursAndShares) {
  PreparedView view;
  view.photo = CutOutTree(80, 100);
  // What is not tree is white there: none of it may leak into the tree's colours
  view.photo.pixels.setTo(cv::Scalar::all(1), view.photo.alpha == 0);
  view.cut.foreground = view.photo.pixels;
  view.cut.alpha = view.photo.alpha;
  view.camera.width_px = 80;
  view.camera.height_px = 100;
  view.camera.focal_px = {90, 90};
  const PreparedView small = Smaller(view, 25);
  EXPECT_EQ(small.photo.pixels.size(), cv::Size(20, 25));
  EXPECT_EQ(small.camera.width_px, 20);
  EXPECT_DOUBLE_EQ(small.camera.focal_px.x(), 22.5);
  // Means over areas of 4 x 4 keep the mean
  EXPECT_NEAR(cv::mean(small.cut.alpha)[0], cv::mean(view.cut.alpha)[0], 1e-6);
  for (int row = 0; row < 25; ++row) {
    for (int column = 0; column < 20; ++column) {
      if (small.cut.alpha(row, column) < 0.5f) continue;
      // The weight of what is no tree is 0.001: 0.8 * 0.001 at most
      EXPECT_NEAR(small.cut.foreground(row, column)[1], 0.2f, 1e-3f);
    }
  }
  EXPECT_EQ(Smaller(view, 100).photo.pixels.size(), cv::Size(80, 100));
}

}  // namespace
}  // namespace relight
