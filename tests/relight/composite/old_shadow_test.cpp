// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/old_shadow.h"

#include "relight/base/angles.h"
#include "relight/photo/read_photo.h"
#include "tests/support/made_cameras.h"
#include "tests/support/reference_tree.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <random>

namespace relight {
namespace {

using tests::Ball;
using tests::LookingAt;
using tests::SameBytes;

Daylight ClearDay(double azimuth_deg, double elevation_deg) {
  const double azimuth_rad = RadFromDeg(azimuth_deg);
  const double elevation_rad = RadFromDeg(elevation_deg);
  return MakeDaylight({azimuth_rad,
                       elevation_rad,
                       DirectionFromAzimuthElevation(azimuth_rad, elevation_rad)});
}

// The same shadow with other maps; a copy would share them.
GroundShadow With(GroundShadow shadow, double sun, double sky) {
  shadow.sun.values = shadow.sun.values.clone();
  shadow.sky.values = shadow.sky.values.clone();
  if (sun >= 0) shadow.sun.values.setTo(cv::Scalar::all(sun));
  if (sky >= 0) shadow.sky.values.setTo(cv::Scalar::all(sky));
  return shadow;
}
constexpr double kAsItIs = -1;

// A ball of leaves over a lawn of one colour, looked down at.
struct Scene {
  Camera camera = LookingAt({4, -9, 7}, {0, 1, 0}, 160, 120, 130);
  GroundShadow morning = Shadow(110, 45), evening = Shadow(250, 40);
  cv::Mat3f lawn = cv::Mat3f(120, 160, cv::Vec3f(0.2f, 0.3f, 0.1f));
  cv::Mat1f no_tree = cv::Mat1f::zeros(120, 160);

  static GroundShadow Shadow(double azimuth_deg, double elevation_deg) {
    return MakeGroundShadow(Ball({0, 0, 3}, 1.5, 0.8, 30),
                            ClearDay(azimuth_deg, elevation_deg));
  }
  static constexpr double kHalfDay_rad = 1.7;
};

TEST(OldShadow, TheSameHourIsTheSamePhoto) {
  const Scene scene;
  std::mt19937 random(4);
  std::uniform_real_distribution<float> uniform(0, 1);
  cv::Mat3f photo(scene.lawn.size()), foreground(scene.lawn.size());
  cv::Mat1f alpha(scene.lawn.size());
  for (cv::Vec3f& color : photo) color = {uniform(random), uniform(random), 0.4f};
  for (cv::Vec3f& color : foreground) color = {uniform(random), uniform(random), 0.4f};
  for (float& a : alpha) a = std::max(0.f, 2 * uniform(random) - 1);
  const cv::Mat3f ratio =
      GroundRatio(ShadowInPhoto(photo, alpha, scene.morning, scene.camera),
                  scene.morning,
                  scene.camera,
                  0.0);
  EXPECT_TRUE(SameBytes(ratio, cv::Mat3f(ratio.size(), cv::Vec3f::all(1))));
  EXPECT_TRUE(SameBytes(ReshadowedPhoto(photo, alpha, foreground, ratio), photo));
}

// The old shadow goes, the new one comes, where the volume itself cast the old one.
TEST(OldShadow, MovesTheShadowOverAPlainLawn) {
  const Scene scene;
  const cv::Mat3f before = ShadowImage(scene.morning, scene.camera);
  const cv::Mat3f after = ShadowImage(scene.evening, scene.camera);
  const cv::Mat3f photo = scene.lawn.mul(before);
  const cv::Mat3f expected = scene.lawn.mul(after);
  for (const bool flecks : {false, true}) {
    const OldShadowOptions options{.floor = 0.05, .volume_only = !flecks};
    const cv::Mat3f ratio = GroundRatio(
        ShadowInPhoto(photo, scene.no_tree, scene.morning, scene.camera, options),
        scene.evening,
        scene.camera,
        Scene::kHalfDay_rad,
        options);
    const cv::Mat3f moved = ReshadowedPhoto(photo, scene.no_tree, scene.lawn, ratio);
    // Nothing is deeper than the floor, so the volume's own shadow is undone exactly;
    // flecks are read from the photo: the lawn's level is blended, and what is nearly
    // sunlit counts as sunlit (15 % of the sun)
    const double tolerance = flecks ? 0.25 : 1e-5;
    double worst = 0;
    for (int row = 0; row < moved.rows; ++row) {
      for (int column = 0; column < moved.cols; ++column) {
        worst = std::max<double>(
            worst, std::abs(moved(row, column)[1] / expected(row, column)[1] - 1));
      }
    }
    EXPECT_LT(worst, tolerance) << (flecks ? "with flecks" : "without");
  }
}

// Flecks of full sun in the shadow stay as bright as they are, shade is lifted.
TEST(OldShadow, KnowsTheFlecksOfSun) {
  const Scene scene;
  const cv::Mat3f mean = ShadowImage(scene.morning, scene.camera);
  const cv::Mat3f lit = ShadowImage(With(scene.morning, 1, kAsItIs), scene.camera);
  const cv::Mat3f dark = ShadowImage(With(scene.morning, 0, kAsItIs), scene.camera);
  cv::Mat3f photo = scene.lawn.clone();
  cv::Mat1b fleck(photo.size(), 0);
  std::mt19937 random(5);
  int in_shadow = 0;
  for (int row = 0; row < photo.rows; ++row) {
    for (int column = 0; column < photo.cols; ++column) {
      const bool shaded = mean(row, column)[1] < 0.7f * lit(row, column)[1];
      fleck(row, column) = !shaded || random() % 3 == 0 ? 1 : 0;
      in_shadow += shaded;
      const cv::Vec3f light =
          fleck(row, column) != 0 ? lit(row, column) : dark(row, column);
      photo(row, column) = photo(row, column).mul(light);
    }
  }
  ASSERT_GT(in_shadow, 200);
  const cv::Mat3f seen =
      ShadowInPhoto(photo, scene.no_tree, scene.morning, scene.camera).seen;
  for (int row = 0; row < photo.rows; ++row) {
    for (int column = 0; column < photo.cols; ++column) {
      if (mean(row, column)[1] >= 0.7f * lit(row, column)[1]) continue;
      const cv::Vec3f& truth =
          fleck(row, column) != 0 ? lit(row, column) : dark(row, column);
      // The level of the lawn is blended inwards over the shadow's own edge: some per
      // cent
      EXPECT_NEAR(seen(row, column)[1], truth[1], 0.1) << row << ", " << column;
    }
  }
}

TEST(OldShadow, ChangesThePartThatIsGroundAlone) {
  const cv::Mat3f photo(1, 1, cv::Vec3f(0.5f, 0.4f, 0.3f));
  const cv::Mat3f foreground(1, 1, cv::Vec3f(0.8f, 0.2f, 0.1f));
  const cv::Mat3f ratio(1, 1, cv::Vec3f(0.5f, 2.f, 1.f));
  const cv::Mat3f half = ReshadowedPhoto(photo, cv::Mat1f(1, 1, 0.5f), foreground, ratio);
  EXPECT_FLOAT_EQ(half(0, 0)[0], 0.4f + 0.1f * 0.5f);  // a F + r (I - a F)
  EXPECT_FLOAT_EQ(half(0, 0)[1], 0.1f + 0.3f * 2.f);
  EXPECT_FLOAT_EQ(half(0, 0)[2], 0.3f);
  const cv::Mat3f tree = ReshadowedPhoto(photo, cv::Mat1f(1, 1, 1.f), photo, ratio);
  EXPECT_EQ(tree(0, 0), photo(0, 0));
}

TEST(OldShadow, IsFlooredAndLeavesTheSky) {
  const Scene scene;
  GroundShadow black = With(scene.morning, 0, 0);
  black.sun_share.setConstant(0.5f);  // Grey, at its edge too
  const GroundShadow none = With(scene.morning, 1, 1);
  const Camera level = LookingAt({0, -9, 2}, {0, 1, 2}, 160, 120, 130);
  const cv::Mat3f ratio = GroundRatio(
      ShadowInPhoto(scene.lawn, scene.no_tree, black, level, {.volume_only = true}),
      none,
      level,
      Scene::kHalfDay_rad);
  double most = 0;
  cv::minMaxLoc(ratio.reshape(1), nullptr, &most);
  EXPECT_NEAR(most, (1 + 0.2) / 0.2, 0.05);  // (M9) with i near 0, t = 1
  EXPECT_EQ(ratio(10, 80), cv::Vec3f::all(1));
}

// Rendered ground: dividing by our shadow must bring the bare ground back by half or
// more.
TEST(OldShadow, HalvesTheErrorOfARenderedGround) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/maple/ground/ground.json");
  RELIGHT_SKIP_WITHOUT_SHARED("reference/cabral2011/maple/volume.json");
  const tests::ReferenceTree tree = tests::ReadReferenceTree("maple");
  const Camera& camera = tree.CameraOf("view_00");
  const std::filesystem::path folder = tests::SharedPath("data/maple/ground");
  for (const auto& entry : tests::ReadJson(folder / "ground.json")) {
    if (!entry.at("tree").get<bool>()) continue;
    std::string file = entry.at("file").get<std::string>();
    const cv::Mat3f with = ReadPhoto(folder / file).pixels;
    file.replace(file.find("_tree"), 5, "_bare");
    const cv::Mat3f bare = ReadPhoto(folder / file).pixels;
    const GroundShadow shadow =
        MakeGroundShadow(tree.grid,
                         ClearDay(entry.at("sun_azimuth_deg").get<double>(),
                                  entry.at("sun_elevation_deg").get<double>()));
    const cv::Mat1f no_tree = cv::Mat1f::zeros(bare.size());  // It is not seen here
    const auto error = [&](const cv::Mat3f* divisor) {
      double sum = 0;
      for (int row = 0; row < bare.rows; ++row) {
        for (int column = 0; column < bare.cols; ++column) {
          const cv::Vec3f& truth = bare(row, column);
          if (!(truth[0] + truth[1] + truth[2] > 0)) continue;
          for (int c = 0; c < 3; ++c) {
            const float s = divisor == nullptr ? 1.f : (*divisor)(row, column)[c];
            sum += std::pow(with(row, column)[c] / std::max(0.05f, s) - truth[c], 2);
          }
        }
      }
      return std::sqrt(sum);
    };
    const auto [volume, seen] = ShadowInPhoto(with, no_tree, shadow, camera);
    const double before = error(nullptr);
    std::cout << file.substr(0, 12) << ": error left, volume's shadow "
              << error(&volume) / before << ", as the photo shows it "
              << error(&seen) / before << "\n";
    EXPECT_LT(error(&seen), 0.5 * before);
  }
}

}  // namespace
}  // namespace relight
