// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/panorama.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/photo/image_file.h"
#include "relight/sky/daylight.h"
#include "relight/sky/sky_panorama.h"
#include "tests/support/made_light.h"
#include "tests/support/scratch_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace relight {
namespace {

using std::numbers::pi;

using tests::SunAt;

double Luminance(const Eigen::Array3d& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

// Sum of value times solid angle above the horizon, as the pixels are.
Eigen::Array3d IntegralOf(const cv::Mat3f& image) {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  ForEachSkyPixel(image,
                  [&](const Eigen::Vector3d&, double weight_sr, const Eigen::Array3d& c) {
                    sum += weight_sr * c;
                  });
  return sum;
}

// A grey sky with a disc of `radius_deg` in it.
cv::Mat3f SkyWithDisc(
    int height, const Eigen::Vector3d& sun, double radius_deg, float sky, float disc) {
  cv::Mat3f image(height, 2 * height, cv::Vec3f::all(sky));
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      const Eigen::Vector3d at = LatLongDirection(image.size(), column, row);
      if (DegFromRad(AngleBetween(at, sun)) < radius_deg) {
        image(row, column) = cv::Vec3f::all(disc);
      }
    }
  }
  return image;
}

TEST(Panorama, PixelsCoverTheSkyOnce) {
  for (const int height : {8, 9, 64}) {  // An odd height has a row on the horizon
    double all = 0, on_ground = 0;
    ForEachSkyPixel(
        cv::Mat3f(height, 2 * height, cv::Vec3f::all(1)),
        [&](const Eigen::Vector3d& direction, double weight_sr, const Eigen::Array3d&) {
          all += weight_sr;
          on_ground += weight_sr * std::max(0.0, direction.z());
        });
    EXPECT_NEAR(all, 2 * pi, 1e-12);
    // Middles of rows stand for their cosines: an error of the square of a row's height
    EXPECT_NEAR(on_ground, pi, 3.0 / (height * height) * pi);
  }
}

TEST(Panorama, NorthIsInTheMiddleAndEastOnItsRight) {
  const cv::Size size(64, 32);
  EXPECT_NEAR(AzimuthOf(LatLongDirection(size, 31.5, 15.5)), 0, 1e-12);
  EXPECT_NEAR(DegFromRad(AzimuthOf(LatLongDirection(size, 47.5, 15.5))), 90, 1e-9);
  EXPECT_GT(LatLongDirection(size, 10, 0).z(), 0.99);
}

TEST(Panorama, ItsSunIsFoundAndSunAndSkyAreThePanorama) {
  for (const double radius_deg : {0.3, 0.9, 2.5}) {
    const Eigen::Vector3d sun =
        DirectionFromAzimuthElevation(RadFromDeg(200), RadFromDeg(33));
    cv::Mat3f image = SkyWithDisc(512, sun, radius_deg, 1.0f, 5000.0f);
    const Eigen::Array3d all = IntegralOf(image);
    const std::optional<PanoramaSun> found = CutOutSun(image);
    ASSERT_TRUE(found) << radius_deg;
    // A disc of few whole pixels: its middle is known to a part of a pixel of 0.35 deg
    EXPECT_LT(DegFromRad(AngleBetween(found->direction, sun)), 0.15) << radius_deg;
    // Floats of 5000 are rounded to 2^-12
    EXPECT_TRUE((IntegralOf(image) + found->irradiance).isApprox(all, 1e-6));
    EXPECT_NEAR(IntegralOf(image)[1], 2 * pi, 1e-5);  // What is left is the grey sky
    EXPECT_EQ(found->clipped, radius_deg > 0.5);      // Wider than any sun, and flat
  }
}

TEST(Panorama, AnOvercastSkyHasNoSun) {
  for (const int type : {1, 5, 8, 12, 15}) {
    Daylight day =
        MakeDaylight(SunAt(200, 33), {.model = SkyModel::kCie, .cie_type = type});
    day.sun_irradiance.setZero();
    cv::Mat3f image = DrawPanorama(day, 256);
    const cv::Mat3f before = image.clone();
    EXPECT_FALSE(CutOutSun(image)) << type;
    EXPECT_EQ(cv::norm(image, before, cv::NORM_INF), 0);
  }
  cv::Mat3f black(64, 128, cv::Vec3f::all(0));
  EXPECT_FALSE(CutOutSun(black));
}

TEST(Panorama, AOneHotPixelOfLittleLightIsNoSun) {
  cv::Mat3f image(512, 1024, cv::Vec3f::all(1));
  image(100, 100) = cv::Vec3f::all(50);  // 0.2 % of the sky's light
  EXPECT_FALSE(CutOutSun(image));
}

// Written as relight sky writes it.
std::filesystem::path Written(const tests::ScratchFolder& folder,
                              const Daylight& day,
                              bool said = true) {
  const auto file = folder / "sky.exr";
  std::map<std::string, std::string> metadata;
  if (said) metadata = {{"relight:unit", "cd/m2"}, {"relight:heading_deg", "0"}};
  WriteLinear(file, {{"", DrawPanorama(day)}}, metadata);
  return file;
}

DaylightOptions OfPanorama(const std::filesystem::path& file) {
  return {.model = SkyModel::kPanorama,
          .panorama = std::make_shared<const Panorama>(ReadPanorama(file))};
}

TEST(Panorama, WhatIsDrawnIsReadAsTheSameLight) {
  const tests::ScratchFolder folder;
  for (const DaylightOptions& options : {DaylightOptions{},
                                         DaylightOptions{.turbidity = 6.0},
                                         DaylightOptions{.model = SkyModel::kAtmosphere},
                                         DaylightOptions{.model = SkyModel::kCie},
                                         DaylightOptions{.cloud = 0.5}}) {
    for (const double elevation_deg : {4.0, 40.0}) {
      const SolarPosition sun = SunAt(222, elevation_deg);
      const Daylight day = MakeDaylight(sun, options);
      const Daylight read = MakeDaylight(sun, OfPanorama(Written(folder, day)));
      EXPECT_TRUE(read.sun_direction.isApprox(day.sun_direction, 1e-15));
      const double sun_lx = Luminance(day.sun_irradiance);
      // The glow within a degree of the sun goes over to it: below 1.5 % of the sun
      EXPECT_NEAR(Luminance(read.sun_irradiance), sun_lx, 0.015 * sun_lx)
          << elevation_deg << " " << static_cast<int>(options.model);
      EXPECT_EQ(read.sun_irradiance.isZero(), sun_lx == 0);
      for (const double azimuth_deg : {20.0, 150.0, 300.0}) {
        const Eigen::Vector3d at =
            DirectionFromAzimuthElevation(RadFromDeg(azimuth_deg), RadFromDeg(40));
        // Interpolated between pixels of 0.35 deg
        EXPECT_TRUE(read.SkyRadiance(at).isApprox(day.SkyRadiance(at), 2e-3));
      }
      EXPECT_TRUE((read.SkyRadiance({0.6, 0, -0.8}) == 0).all());
    }
  }
}

TEST(Panorama, IsTurnedUntilItsSunStandsAtTheHoursAzimuth) {
  const tests::ScratchFolder folder;
  const Daylight day = MakeDaylight(SunAt(100, 30));
  const DaylightOptions options = OfPanorama(Written(folder, day, /*said=*/false));
  const SolarPosition sun = SunAt(250, 32);  // Within 5 degrees after the turn
  const Daylight turned = MakeDaylight(sun, options);
  EXPECT_TRUE(turned.sun_direction.isApprox(sun.direction, 1e-15));
  const Eigen::Vector3d a = DirectionFromAzimuthElevation(RadFromDeg(60), 0.5);
  const Eigen::Vector3d b = DirectionFromAzimuthElevation(RadFromDeg(210), 0.5);
  const double level = Luminance(turned.SkyRadiance(b)) / Luminance(day.SkyRadiance(a));
  EXPECT_TRUE(
      turned.SkyRadiance(b).isApprox(level * day.SkyRadiance(a), 5e-3));  // Half a pixel
  ASSERT_EQ(PanoramaNotes(sun, options).size(), 3u);  // Turned, moved, without a unit
  EXPECT_NE(PanoramaNotes(sun, options)[0].find("150.0 deg"), std::string::npos);

  // As bright on the ground as the clear day there: the sums' grids part by 1 %
  const auto ground = [](const Daylight& of) {
    double sum = Luminance(of.sun_irradiance) * of.sun_direction.z();
    const cv::Mat3f image(256, 512, cv::Vec3f::all(0));
    ForEachSkyPixel(image, [&](const Eigen::Vector3d& at, double weight_sr, const auto&) {
      sum += weight_sr * at.z() * Luminance(of.SkyRadiance(at));
    });
    return sum;
  };
  EXPECT_NEAR(ground(turned) / ground(MakeDaylight(sun)), 1, 0.01);
}

TEST(Panorama, AHeadingIsKeptAndAnotherHoursSunStaysWithItsSky) {
  const tests::ScratchFolder folder;
  const Daylight day = MakeDaylight(SunAt(100, 30));
  DaylightOptions options = OfPanorama(Written(folder, day, /*said=*/false));
  options.panorama_heading_deg = 90.0;
  options.panorama_scale = 1.0;
  const SolarPosition sun = SunAt(250, 20);
  const Daylight kept = MakeDaylight(sun, options);
  // Found to a tenth of a pixel
  EXPECT_LT(DegFromRad(AngleBetween(kept.sun_direction, SunAt(190, 30).direction)), 0.05);
  EXPECT_NEAR(Luminance(kept.sun_irradiance) / Luminance(day.sun_irradiance), 1, 0.015);
  const std::vector<std::string> notes = PanoramaNotes(sun, options);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("azimuth 250.0, elevation 20.0"), std::string::npos);

  options.panorama_scale = 2.0;
  EXPECT_TRUE(
      MakeDaylight(sun, options).sun_irradiance.isApprox(2 * kept.sun_irradiance, 1e-12));
}

TEST(Panorama, WithoutASunItHasTheLevelOfACoveredDay) {
  const tests::ScratchFolder folder;
  const auto file = folder / "grey.exr";
  WriteLinear(file, {{"", cv::Mat3f(64, 128, cv::Vec3f::all(0.5f))}});
  const SolarPosition sun = SunAt(120, 40);
  const Daylight grey = MakeDaylight(sun, OfPanorama(file));
  const Daylight covered = MakeDaylight(sun, {.model = SkyModel::kCie, .cie_type = 5});
  EXPECT_TRUE(grey.sun_irradiance.isZero());
  // A uniform sky of 64 rows beside the uniform sky: 3 / 64^2 by PixelsCoverTheSkyOnce
  EXPECT_TRUE(grey.SkyRadiance({0, 0, 1}).isApprox(covered.SkyRadiance({0, 0, 1}), 1e-3));
  try {
    MakeDaylight(SunAt(120, -3), OfPanorama(file));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("--panorama-scale"), std::string::npos);
  }
}

TEST(Panorama, ALargeFileKeepsItsLight) {
  const tests::ScratchFolder folder;
  const auto file = folder / "large.exr";
  cv::Mat3f image(2500, 5000);  // Shrunk by no whole number
  cv::RNG random(8);
  random.fill(image, cv::RNG::UNIFORM, 0.5, 1.5);
  const Eigen::Array3d all = IntegralOf(image);
  WriteLinear(file, {{"", image}}, {}, LinearDepth::kFloat);
  const Panorama panorama = ReadPanorama(file);
  EXPECT_EQ(panorama.sky.cols, 1024);
  EXPECT_FALSE(panorama.sun);
  // Sums of 8 million floats that are kept as floats
  EXPECT_TRUE(IntegralOf(panorama.sky).isApprox(all, 1e-6));
}

TEST(Panorama, RefusesWhatIsNoSkyByNameAndPixel) {
  const tests::ScratchFolder folder;
  const auto file = folder / "bad.exr";
  const auto refusal = [&](const cv::Mat3f& image) -> std::string {
    WriteLinear(file, {{"", image}});
    try {
      ReadPanorama(file);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  const auto with = [](const cv::Vec3f& color) {
    cv::Mat3f image(32, 64, cv::Vec3f::all(1));
    image(5, 7) = color;
    return image;
  };
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  for (const auto& [image, word] :
       {std::pair(with({1, kNaN, 1}), "NaN"),
        std::pair(with({1, 1, kInf}), "infinite"),
        std::pair(with({-1, -1, -1}), "light below 0"),
        std::pair(with({0, -0.5f, 1}), "light below 0"),
        std::pair(cv::Mat3f(32, 60, cv::Vec3f::all(1)), "60 x 32"),
        std::pair(cv::Mat3f(16, 64, cv::Vec3f::all(1)), "black rows below"),
        std::pair(cv::Mat3f(64, 64, cv::Vec3f::all(1)), "mirror ball"),
        std::pair(cv::Mat3f(4, 8, cv::Vec3f::all(1)), "larger")}) {
    const std::string said = refusal(image);
    EXPECT_NE(said.find(word), std::string::npos) << word << ": " << said;
    EXPECT_NE(said.find("bad.exr"), std::string::npos);
  }
  EXPECT_NE(refusal(with({1, kNaN, 1})).find("column 7, row 5"), std::string::npos);
  // A deep blue, outside of Rec.709 and yet light
  EXPECT_EQ(refusal(with({-0.05f, 0.4f, 1})), "");
}

TEST(SkyPanorama, IsMappedForTheEyeByItsMean) {
  const cv::Mat3f mapped =
      ToneMappedPanorama(cv::Mat3f(64, 128, cv::Vec3f(3000, 3000, 3000)));
  EXPECT_NEAR(mapped(10, 10)[1], 1 - std::exp(-0.5), 1e-6);  // The mean itself
  const cv::Mat3f clear = ToneMappedPanorama(DrawPanorama(MakeDaylight(SunAt(180, 40))));
  double low = 0, high = 0;
  cv::minMaxLoc(clear.reshape(1), &low, &high);
  EXPECT_EQ(low, 0);
  EXPECT_LE(high, 1);
  EXPECT_GT(high, 0.99);  // The sun
}

}  // namespace
}  // namespace relight
