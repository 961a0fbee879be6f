// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/light_options.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/photo/image_file.h"
#include "tests/support/scratch_folder.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

constexpr double kHigh_rad = RadFromDeg(40), kLow_rad = RadFromDeg(-3);

TEST(LightOptions, AutoIsOneModelOfTheRunByItsLowestSun) {
  const RunLight high = LightOfRun({}, kHigh_rad), low = LightOfRun({}, kLow_rad);
  EXPECT_EQ(SkyInWords(high.input), "preetham");
  EXPECT_EQ(SkyInWords(high.target), "preetham");
  EXPECT_TRUE(high.one_sky);
  EXPECT_TRUE(high.notes.empty());
  EXPECT_EQ(SkyInWords(low.input), "atmosphere");
  EXPECT_EQ(SkyInWords(low.target), "atmosphere");
  EXPECT_TRUE(low.one_sky);
  ASSERT_EQ(low.notes.size(), 1u);
  EXPECT_NE(low.notes[0].find("atmosphere"), std::string::npos);
}

TEST(LightOptions, TheWeatherOfThePhotoIsClearUnlessItIsSaid) {
  const RunLight covered = LightOfRun({.sky = "overcast"}, kHigh_rad);
  EXPECT_EQ(SkyInWords(covered.input), "preetham");
  EXPECT_EQ(SkyInWords(covered.target), "cie:1");
  EXPECT_FALSE(covered.one_sky);
  const RunLight cleared = LightOfRun({.input_sky = "overcast"}, kHigh_rad);
  EXPECT_EQ(SkyInWords(cleared.input), "cie:1");
  EXPECT_EQ(SkyInWords(cleared.target), "preetham");
  const RunLight same = LightOfRun({.sky = "atmosphere"}, kHigh_rad);
  EXPECT_EQ(SkyInWords(same.input), "atmosphere");
  EXPECT_TRUE(same.one_sky);
  const RunLight twice = LightOfRun({.sky = "cie:12", .input_sky = "cie:12"}, kHigh_rad);
  EXPECT_TRUE(twice.one_sky);
  EXPECT_EQ(SkyInWords(LightOfRun({.cloud = 0.5}, kHigh_rad).target),
            "preetham under 0.5 of clouds");
}

TEST(LightOptions, PairsOfAnotherLevelAreWarnedAbout) {
  for (const LightOptions& options :
       {LightOptions{.sky = "preetham", .input_sky = "atmosphere"},
        LightOptions{.sky = "atmosphere", .input_sky = "overcast"}}) {
    const RunLight light = LightOfRun(options, kHigh_rad);
    ASSERT_EQ(light.notes.size(), 1u);
    EXPECT_NE(light.notes[0].find("level"), std::string::npos);
  }
  const RunLight level = LightOfRun({.sky = "overcast"}, kHigh_rad);
  ASSERT_EQ(level.notes.size(), 1u);
  EXPECT_EQ(level.notes[0].find("level"), std::string::npos);
}

TEST(LightOptions, RefusesWhatDoesNotGoTogether) {
  for (const LightOptions& options :
       {LightOptions{.method = Method::kCabral2011, .sky = "overcast"},
        LightOptions{.method = Method::kCabral2011, .turbidity = 3.0},
        LightOptions{.method = Method::kCabral2011, .cloud = 0.5},
        LightOptions{.sky = "overcast", .cloud = 0.5},
        LightOptions{.sky = "cie:16"},
        LightOptions{.sky = "sunny"},
        LightOptions{.input_sky = "cie:"},
        LightOptions{.sunset_correction = true},
        LightOptions{.cloud = 1.5},
        LightOptions{.sky = "panorama:"},
        LightOptions{.panorama_heading_deg = 10.0},
        LightOptions{.sky = "atmosphere", .panorama_scale = 2.0},
        LightOptions{.sky = "preetham", .ground_albedo = 0.5},
        LightOptions{.method = Method::kCabral2011, .ground_albedo = 0.5},
        LightOptions{.ground_albedo = 1.5}}) {
    EXPECT_THROW(LightOfRun(options, kHigh_rad), OptionError);
  }
}

TEST(LightOptions, TheGroundsAlbedoGoesToTheAtmosphere) {
  EXPECT_EQ(LightOfRun({.sky = "atmosphere", .ground_albedo = 0.7}, kHigh_rad)
                .target.ground_albedo,
            0.7);
  EXPECT_EQ(LightOfRun({.ground_albedo = 0.7}, kLow_rad).target.ground_albedo, 0.7);
  // Auto is preetham by day, which knows no ground: said, not refused
  const RunLight day = LightOfRun({.ground_albedo = 0.7}, kHigh_rad);
  EXPECT_FALSE(day.target.ground_albedo.has_value());
  ASSERT_EQ(day.notes.size(), 1u);
  EXPECT_NE(day.notes[0].find("--ground-albedo is not used"), std::string::npos);
  // But for the ground's own light on the tree
  EXPECT_TRUE(LightOfRun({.ground_albedo = 0.7}, kHigh_rad, true).notes.empty());
  EXPECT_NO_THROW(LightOfRun({.sky = "preetham", .ground_albedo = 0.5}, kHigh_rad, true));
}

TEST(LightOptions, APanoramaIsASkyOfItsOwnLevelOrOfTheDays) {
  const tests::ScratchFolder folder;
  const std::string file = (folder / "grey.exr").string();
  WriteLinear(file, {{"", cv::Mat3f(32, 64, cv::Vec3f::all(1))}});
  const RunLight wanted = LightOfRun({.sky = "panorama:" + file}, kHigh_rad);
  EXPECT_EQ(SkyInWords(wanted.input), "preetham");  // The photo's stays clear
  EXPECT_EQ(SkyInWords(wanted.target), "panorama:grey.exr");
  ASSERT_EQ(wanted.notes.size(), 1u);
  EXPECT_EQ(wanted.notes[0].find("level"), std::string::npos);
  const RunLight scaled =
      LightOfRun({.sky = "panorama:" + file, .panorama_scale = 5000.0}, kHigh_rad);
  ASSERT_EQ(scaled.notes.size(), 1u);
  EXPECT_NE(scaled.notes[0].find("level"), std::string::npos);
  const RunLight both =
      LightOfRun({.sky = "panorama:" + file, .input_sky = "panorama:" + file}, kHigh_rad);
  EXPECT_TRUE(both.one_sky);
  EXPECT_THROW(LightOfRun({.sky = "panorama:" + file + ".gone"}, kHigh_rad), InputError);
}

TEST(LightOptions, OnlySkiesWithATwilightTakeASunBelowTheHorizon) {
  EXPECT_EQ(LowestTargetSun({}), kLowestTwilight_deg);
  EXPECT_EQ(LowestTargetSun({.sky = "preetham"}), 0.0);
  EXPECT_EQ(LowestTargetSun({.sky = "overcast"}), 0.0);
  EXPECT_EQ(LowestInputSun({.sky = "overcast"}), kLowestTwilight_deg);
  EXPECT_EQ(LowestInputSun({.input_sky = "overcast"}), 0.0);
  EXPECT_EQ(LowestTargetSun({.method = Method::kCabral2011}), 0.0);
}

}  // namespace
}  // namespace relight
