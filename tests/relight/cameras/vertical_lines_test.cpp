// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/vertical_lines.h"

#include "relight/base/angles.h"
#include "relight/cameras/camera.h"
#include "relight/cameras/photo_orientation.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include <iostream>
#include <random>

namespace relight {
namespace {

constexpr double kFocal_px = 900;
const cv::Size kSize(1200, 900);
const Eigen::Vector2d kCenter(600, 450);

cv::Point Sixteenths(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround((pixel.x() - 0.5) * 16)),
          static_cast<int>(std::lround((pixel.y() - 0.5) * 16))};
}

Camera Unposed() {
  Camera camera;
  camera.focal_px = {kFocal_px, kFocal_px};
  camera.center_px = kCenter;
  return camera;
}

// Posts and walls of many greys, seen by a camera pitched and rolled.
cv::Mat1b Street(double pitch_deg, double roll_deg, double k1 = 0) {
  Camera camera = Unposed();
  camera.lens.k1 = k1;
  camera.camera_from_world.linear() =
      RotationFromUp(UpFromPitchAndRoll(RadFromDeg(pitch_deg), RadFromDeg(roll_deg)), 0);
  cv::Mat1b picture(kSize, 120);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> aside(-8, 8), grey(0, 255);
  for (int i = 0; i < 24; ++i) {
    const double x = aside(random), width = 0.3;
    std::vector<cv::Point> corners;
    for (int k = 0; k < 40; ++k) {  // Up one side in small steps, for a lens bends it
      const double z = -1.5 + 4.5 * (k < 20 ? k : 39 - k) / 19;
      const auto seen = camera.Project({x + (k < 20 ? 0 : width), 10, z});
      if (seen) corners.push_back(Sixteenths(*seen));
    }
    cv::fillPoly(picture,
                 std::vector<std::vector<cv::Point>>{corners},
                 cv::Scalar(grey(random)),
                 cv::LINE_AA,
                 4);
  }
  return picture;
}

TEST(VerticalLines, FindsHowAStreetWasPhotographed) {
  for (const auto& [pitch_deg, roll_deg] :
       {std::pair(0.0, 0.0), {12.0, 0.0}, {-9.0, 4.0}, {20.0, -6.0}}) {
    const auto found = FindUprightLines(Street(pitch_deg, roll_deg), Unposed());
    ASSERT_TRUE(found) << pitch_deg << ", " << roll_deg;
    std::cout << found->lines << " lines, share " << found->share << ", error "
              << found->error_deg << " deg\n";
    // A line's edge is known to a tenth of a pixel over a few hundred: 0.02 deg; the
    // meeting point far off makes ten times that of pitch
    EXPECT_NEAR(DegFromRad(PitchOf(found->up_in_camera)), pitch_deg, 0.3);
    EXPECT_NEAR(DegFromRad(RollOf(found->up_in_camera)), roll_deg, 0.1);
    EXPECT_GE(found->lines, 8);
    EXPECT_LE(found->error_deg, 1);
  }
}

// Taken for straight, the same street is pitched by 4 degrees less.
TEST(VerticalLines, SeesThatTheLensBends) {
  const auto found = FindUprightLines(Street(12, 2, -0.12), Unposed());
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->lens.k1, -0.12, 0.04);  // k1 is tried in steps of 0.03 here
  EXPECT_NEAR(DegFromRad(PitchOf(found->up_in_camera)), 12, 1);
  EXPECT_NEAR(DegFromRad(RollOf(found->up_in_camera)), 2, 0.3);
  EXPECT_TRUE(FindUprightLines(Street(12, 2), Unposed())->lens.IsPinhole());
}

// Branches go everywhere.
TEST(VerticalLines, IsUnsureOfATree) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    cv::Mat1b picture(kSize, 200);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> x(0, kSize.width), y(0, kSize.height),
        turn(-0.35, 0.35), length(40, 150);
    for (int i = 0; i < 150; ++i) {
      const Eigen::Vector2d foot(x(random), y(random));
      const double angle = turn(random), l = length(random);
      cv::line(picture,
               Sixteenths(foot),
               Sixteenths(foot + l * Eigen::Vector2d(std::sin(angle), std::cos(angle))),
               cv::Scalar(60),
               2,
               cv::LINE_AA,
               4);
    }
    EXPECT_FALSE(FindUprightLines(picture, Unposed())) << seed;
  }
}

TEST(VerticalLines, IsUnsureOfOnePole) {
  cv::Mat1b picture(kSize, 200);
  for (int i = 0; i < 6; ++i)
    cv::line(picture, {600 + 9 * i, 100}, {600 + 9 * i, 800}, cv::Scalar(50), 3);
  EXPECT_FALSE(FindUprightLines(picture, Unposed()));
  EXPECT_FALSE(FindUprightLines(cv::Mat1b(kSize, 90), Unposed()));
}

}  // namespace
}  // namespace relight
