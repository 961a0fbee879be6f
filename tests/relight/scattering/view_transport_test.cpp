// SPDX-License-Identifier: Apache-2.0
#include "relight/scattering/view_transport.h"

#include "relight/scattering/single_scattering.h"
#include "relight/sh/sky_coefficients.h"
#include "relight/sky/solar_position.h"
#include "tests/support/made_cameras.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

// Shares and coefficients as half floats: 2^-11 of each.
constexpr double kHalfFloats = 1e-3;

struct Scene {
  ExtinctionGrid grid = tests::RandomCanopy({20, 18, 22}, 0.15, 1.5, /*seed=*/3);
  OccupiedVoxels occupied = FindOccupied(grid);
  SkyTransmittance sky = ProjectTransmittance(grid, occupied, {.directions = 256});
  Camera camera = tests::LookingAt({4, -8, 1.6}, {0, 0, 1.5}, 120, 90, 200);
};

Daylight Afternoon() {
  SolarPosition sun;
  sun.azimuth_rad = 4.2;
  sun.elevation_rad = 0.6;
  sun.direction = DirectionFromAzimuthElevation(sun.azimuth_rad, sun.elevation_rad);
  return MakeDaylight(sun);
}

TEST(ViewTransport, GivesTheImagesOfSingleScattering) {
  const Scene scene;
  const Daylight daylight = Afternoon();
  cv::Mat1b mask(90, 120, uchar{255});
  mask.rowRange(0, 31).setTo(0);
  const ArrivingLight light =
      LightArriving(scene.grid, scene.occupied, scene.sky, daylight);
  const ScatteringImages exact =
      SingleScattering(scene.grid, scene.occupied, {&light, 1}, scene.camera, mask);
  const ViewTransport view =
      MakeViewTransport(scene.grid, scene.occupied, scene.sky, scene.camera, mask);
  const cv::Mat3f sky = SkyImage(view, SkyCoefficients(daylight));
  const cv::Mat3f sun =
      SunImage(view,
               SunTransmittance(scene.grid, scene.occupied, daylight.sun_direction),
               daylight.sun_irradiance);
  EXPECT_LT(cv::norm(sky, exact.lights[0].sky), kHalfFloats * cv::norm(sky));
  EXPECT_LT(cv::norm(sun, exact.lights[0].sun), kHalfFloats * cv::norm(sun));
  EXPECT_GT(cv::norm(sky), 0);
  EXPECT_GT(cv::norm(sun), 0);
  for (std::size_t p = 0; p < view.pixel.size(); ++p) {
    const int row = view.pixel[p] / 120, column = view.pixel[p] % 120;
    ASSERT_GE(row, 31);
    ASSERT_EQ(view.weight[p], exact.weight(row, column));
  }
}

TEST(ViewTransport, DoesNotDependOnThreads) {
  const Scene scene;
  const ShCoefficients sky = SkyCoefficients(Afternoon());
  const auto with = [&](int threads) {
    const tests::WithThreads limit(threads);
    return SkyImage(
        MakeViewTransport(scene.grid, scene.occupied, scene.sky, scene.camera), sky);
  };
  EXPECT_TRUE(tests::SameBytes(with(1), with(2)));
}

// Two skies at once are the sum of each, where neither is floored.
TEST(ViewTransport, IsLinearInTheSky) {
  const Scene scene;
  const ViewTransport view =
      MakeViewTransport(scene.grid, scene.occupied, scene.sky, scene.camera);
  const ShCoefficients a = SkyCoefficients(UniformDaylight({1, 2, 3}));
  const ShCoefficients b = SkyCoefficients(UniformDaylight({5, 4, 3}, true));
  const cv::Mat3f sum = SkyImage(view, a) + SkyImage(view, b);
  EXPECT_LT(cv::norm(SkyImage(view, a + b), sum, cv::NORM_INF),
            1e-5 * cv::norm(sum, cv::NORM_INF));  // Sums of 36 floats
}

TEST(ViewTransport, StopsWhenAsked) {
  const Scene scene;
  EXPECT_THROW(
      MakeViewTransport(
          scene.grid, scene.occupied, scene.sky, scene.camera, {}, Progress([](double) {
            return false;
          })),
      Cancelled);
}

}  // namespace
}  // namespace relight
