// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/ground_shadow.h"

#include "relight/base/angles.h"
#include "relight/photo/read_photo.h"
#include "relight/sh/sky_coefficients.h"
#include "tests/support/made_cameras.h"
#include "tests/support/reference_tree.h"
#include "tests/support/shared_data.h"
#include "tests/support/synthetic_canopy.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

namespace relight {
namespace {

using tests::Ball;
using tests::LookingAt;
using tests::SameBytes;
using tests::Slab;
using tests::WithThreads;

// A sun without a sky.
Daylight SunAlone(double azimuth_deg, double elevation_deg) {
  Daylight daylight;
  daylight.sun_direction =
      DirectionFromAzimuthElevation(RadFromDeg(azimuth_deg), RadFromDeg(elevation_deg));
  daylight.sun_irradiance = Eigen::Array3d::Constant(1e5);
  return daylight;
}

Daylight ClearDay(double azimuth_deg, double elevation_deg) {
  const double azimuth_rad = RadFromDeg(azimuth_deg);
  const double elevation_rad = RadFromDeg(elevation_deg);
  return MakeDaylight({azimuth_rad,
                       elevation_rad,
                       DirectionFromAzimuthElevation(azimuth_rad, elevation_rad)});
}

double Luminance(const cv::Vec3f& c) {
  return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
}

TEST(GroundShadow, AnEmptyVolumeLeavesAllLight) {
  const GroundShadow shadow =
      MakeGroundShadow(Slab({8, 8, 8}, 0.5, 0.0), ClearDay(120, 40));
  const Camera camera = LookingAt({9, -9, 3}, {0, 0, 0}, 60, 40, 60);
  const cv::Mat3f image = ShadowImage(shadow, camera);
  EXPECT_TRUE(SameBytes(image, cv::Mat3f(image.size(), cv::Vec3f::all(1))));
}

// A slab lets exp(-sigma d / sin e) through.
TEST(GroundShadow, ASlabTransmitsAsBeerLambert) {
  const ExtinctionGrid slab = Slab({80, 80, 4}, 0.5, 0.4);
  for (const double elevation_deg : {90.0, 60.0, 35.0}) {
    const GroundShadow shadow = MakeGroundShadow(slab, SunAlone(70, elevation_deg));
    const double expected = std::exp(-0.4 * 2 / std::sin(RadFromDeg(elevation_deg)));
    // The sun is not a point: over its disc the path varies by tan(0.27 deg)^2
    EXPECT_NEAR(shadow.At({0, 0})[1], expected, 1e-3) << elevation_deg;
  }
}

// Under the edge of an opaque roof h above the ground, the disc of radius r = h tan(d/2)
// shows above the edge by the part that a chord at u r cuts off.
TEST(GroundShadow, HasThePenumbraOfTheSunsDisc) {
  const double cell_m = 0.05, height_m = 40;
  const ExtinctionGrid roof = Slab({40, 40, 1}, cell_m, 1000);
  const GroundShadow shadow =
      MakeGroundShadow(roof, SunAlone(0, 90), {.ground_z_m = -height_m});
  const double r = height_m * std::tan(RadFromDeg(kSunDiameter_deg) / 2);
  const double edge_m = 20 * cell_m + cell_m / 2;  // Interpolated: opaque half a voxel on
  EXPECT_EQ(shadow.At({edge_m + 1.3 * r, 0})[0], 1.0f);
  EXPECT_LT(shadow.At({edge_m - 1.4 * r, 0})[0], 1e-3f);
  for (const double u : {-0.6, -0.3, 0.0, 0.3, 0.6}) {
    const double shown = 1 - (std::acos(u) - u * std::sqrt(1 - u * u)) / std::numbers::pi;
    // 37 points of the disc, and texels an eighth of it wide
    EXPECT_NEAR(shadow.At({edge_m + u * r, 0})[0], shown, 0.06) << u;
  }
}

// A uniform sky under a square roof: 1 - F, with the view factor of a rectangle whose
// corner is above the point, four times.
TEST(GroundShadow, HidesTheViewFactorOfARoof) {
  const double cell_m = 0.1, height_m = 2;
  const ExtinctionGrid roof = Slab({40, 40, 1}, cell_m, 1000);
  const double a = (20 * cell_m + cell_m / 2) / (height_m + cell_m / 2);
  const double b = std::sqrt(1 + a * a);
  const double hidden = 4 * (a / b * std::atan(a / b)) / std::numbers::pi;
  const GroundShadow shadow =
      MakeGroundShadow(roof,
                       UniformDaylight(Eigen::Array3d(1000, 2000, 3000)),
                       {.ground_z_m = -height_m, .sky_directions = 1024});
  const cv::Vec3f left = shadow.At({0, 0});
  // 1024 directions: those that the roof's edge parts are some 100, each counts 0.001
  EXPECT_NEAR(left[0], 1 - hidden, 0.01);
  // A grey sky's shadow is grey whatever its level
  EXPECT_NEAR(left[1], left[0], 1e-6);
  EXPECT_NEAR(left[2], left[0], 1e-6);
}

TEST(GroundShadow, FallsAwayFromTheSun) {
  const Eigen::Vector3d center(1, -2, 5);
  const Daylight daylight = SunAlone(200, 40);
  const GroundShadow shadow = MakeGroundShadow(Ball(center, 1, 2, 20), daylight);
  Eigen::Vector3d sum(0, 0, 0);
  const double step_m = 0.05;
  for (double y = -10; y < 20; y += step_m) {
    for (double x = -10; x < 20; x += step_m) {
      const double dark = 1 - shadow.At({x, y})[0];
      sum += dark * Eigen::Vector3d(x, y, 1);
    }
  }
  const Eigen::Vector3d& sun = daylight.sun_direction;
  const Eigen::Vector2d expected = (center - center.z() / sun.z() * sun).head<2>();
  // Half a texel: the ball's own symmetry makes the centroid exact but for the sampling
  EXPECT_NEAR(sum.x() / sum.z(), expected.x(), 0.025);
  EXPECT_NEAR(sum.y() / sum.z(), expected.y(), 0.025);
}

TEST(GroundShadow, OfTheSunIsBlue) {
  const Daylight daylight = ClearDay(180, 45);
  const GroundShadow shadow = MakeGroundShadow(Slab({40, 40, 1}, 0.1, 1000), daylight);
  const Eigen::Vector2d point(0, 1);  // The slab lies on the ground: all is hidden
  EXPECT_LT(shadow.At(point)[2], 1e-3f);

  const GroundShadow high =
      MakeGroundShadow(Slab({40, 40, 1}, 0.1, 1000), daylight, {.ground_z_m = -20});
  const cv::Vec3f left = high.At({0, 20.05});  // Where the sun behind the slab is seen
  EXPECT_GT(left[2], 1.3f * left[1]);
  EXPECT_GT(left[1], 1.1f * left[0]);
  // The sky alone, but for 1 % that so small a slab hides of it
  const Eigen::Array3d sun = daylight.sun_irradiance * daylight.sun_direction.z();
  const Eigen::Array3d sky =
      GroundShadowOptions().sky_level * HorizontalSkyIrradiance(daylight);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(left[c], sky[c] / (sun[c] + sky[c]), 0.01);
}

TEST(GroundShadow, IsNotCastByWhatIsBelowTheGround) {
  const GroundShadow shadow =
      MakeGroundShadow(Slab({20, 20, 4}, 0.5, 2), ClearDay(90, 50), {.ground_z_m = 2.0});
  EXPECT_EQ(shadow.At({0, 0}), cv::Vec3f::all(1));
  // Half of the slab's 2 m is above the ground here
  const GroundShadow half =
      MakeGroundShadow(Slab({20, 20, 4}, 0.5, 2), SunAlone(90, 90), {.ground_z_m = 1.0});
  EXPECT_NEAR(half.At({0, 0})[0], std::exp(-2.0), 1e-3);  // The disc, as above
}

// Where the map of the sky ends there is no step, and what is left out is not seen.
TEST(GroundShadow, EndsWithoutAStep) {
  for (const Daylight& daylight :
       {ClearDay(100, 30), UniformDaylight(Eigen::Array3d::Constant(1e4))}) {
    const GroundShadow shadow = MakeGroundShadow(Ball({0, 0, 5}, 4, 1, 40), daylight);
    double before = shadow.At({0, 0})[1], largest_step = 0;
    for (double y = 0; y > -80; y -= 0.02) {
      const double now = shadow.At({0.3, y})[1];
      if (y < -12) largest_step = std::max(largest_step, std::abs(now - before));
      before = now;
    }
    EXPECT_LT(largest_step, 0.5 / 255);
    const GroundMap& map = shadow.sky;
    EXPECT_GT(Luminance(shadow.At(map.corner_m +
                                  map.texel_m * Eigen::Vector2d(2, map.values.rows / 2))),
              1 - 1.0 / 255);
  }
}

TEST(GroundShadow, IsSeenWhereTheGroundIs) {
  const GroundShadow shadow =
      MakeGroundShadow(Ball({0, 0, 4}, 2, 1, 30), ClearDay(220, 35), {.ground_z_m = 0.3});
  const Camera camera = LookingAt({6, -8, 12}, {0, 2, 0.3}, 600, 900, 500);
  const cv::Mat3f image = ShadowImage(shadow, camera);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-6, 6);
  int seen = 0, dark = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d point(uniform(random), uniform(random));
    const auto pixel = camera.Project({point.x(), point.y(), 0.3});
    if (!pixel || pixel->x() < 1 || pixel->y() < 1 || pixel->x() >= 599 ||
        pixel->y() >= 899) {
      continue;
    }
    ++seen;
    dark += shadow.At(point)[1] < 0.5f;
    const cv::Vec3f at =
        image(static_cast<int>(pixel->y()), static_cast<int>(pixel->x()));
    // A pixel is 3 cm of ground, a fifth of a voxel: the shadow changes by no more there
    EXPECT_NEAR(at[1], shadow.At(point)[1], 0.15);
  }
  EXPECT_GT(seen, 500);
  EXPECT_GT(dark, 20);
}

TEST(GroundShadow, IsOneAboveTheHorizon) {
  const GroundShadow shadow =
      MakeGroundShadow(Ball({0, 0, 4}, 2, 1, 30), ClearDay(220, 35));
  const Camera camera = LookingAt({10, -14, 2}, {0, 0, 2.5}, 90, 80, 60);
  const cv::Mat3f image = ShadowImage(shadow, camera);
  int above = 0;
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.cols; ++column) {
      if (camera.RayInWorld({column + 0.5, row + 1.0}).z() < 0) continue;
      EXPECT_EQ(image(row, column), cv::Vec3f::all(1));
      ++above;
    }
  }
  EXPECT_GT(above, 90 * 30);
}

TEST(GroundShadow, IsTheSameInBandsAndForAnyNumberOfThreads) {
  const ExtinctionGrid grid = tests::RandomCanopy({31, 27, 40}, 0.1, 3, 5);
  const Daylight daylight = ClearDay(75, 12);
  const Camera camera = LookingAt({8, 3, 1.6}, {0, 0, 1}, 131, 97, 110);
  const auto image = [&](int threads) {
    const WithThreads with(threads);
    return ShadowImage(MakeGroundShadow(grid, daylight), camera);
  };
  const cv::Mat3f once = image(1);
  EXPECT_TRUE(SameBytes(once, image(4)));
  const GroundShadow shadow = MakeGroundShadow(grid, daylight);
  for (int row = 0; row < camera.height_px; row += 13) {
    const int end = std::min(row + 13, camera.height_px);
    EXPECT_TRUE(
        SameBytes(ShadowRows(shadow, camera, row, end), once.rowRange(row, end).clone()));
  }
}

TEST(GroundShadow, TellsHowMuchGroundIsSeen) {
  const Camera down = LookingAt({0, 0, 5}, {0, 0, 0}, 40, 30, 40);
  EXPECT_EQ(GroundShare(down, 0.0), 1.0);
  EXPECT_EQ(GroundShare(down, 9.0), 0.0);
  const Camera level = LookingAt({0, 0, 5}, {10, 0, 5}, 40, 30, 40);
  EXPECT_NEAR(GroundShare(level, 0.0), 0.5, 0.02);  // 32 rows are looked at
}

// Rendered ground with and without the tree, by a path tracer with another sky.
TEST(GroundShadow, FallsWhereTheRenderedOneDoes) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/maple/ground/ground.json");
  RELIGHT_SKIP_WITHOUT_SHARED("reference/cabral2011/maple/volume.json");
  const tests::ReferenceTree tree = tests::ReadReferenceTree("maple");
  const Camera& camera = tree.CameraOf("view_00");
  const auto top = camera.Project({0, 0, tree.true_box.max().z()});
  const auto foot = camera.Project({0, 0, 0});
  ASSERT_TRUE(top && foot);
  const double crown_px = foot->y() - top->y();

  const std::filesystem::path folder = tests::SharedPath("data/maple/ground");
  for (const auto& entry : tests::ReadJson(folder / "ground.json")) {
    if (!entry.at("tree").get<bool>()) continue;
    std::string file = entry.at("file").get<std::string>();
    const cv::Mat3f with = ReadPhoto(folder / file).pixels;
    file.replace(file.find("_tree"), 5, "_bare");
    const cv::Mat3f bare = ReadPhoto(folder / file).pixels;
    const Daylight daylight = ClearDay(entry.at("sun_azimuth_deg").get<double>(),
                                       entry.at("sun_elevation_deg").get<double>());

    const auto start = std::chrono::steady_clock::now();
    const GroundShadow shadow = MakeGroundShadow(tree.grid, daylight);
    const cv::Mat3f image = ShadowImage(shadow, camera);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

    double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0;
    Eigen::Vector2d at_a(0, 0), at_b(0, 0);
    for (int row = 0; row < bare.rows; ++row) {
      for (int column = 0; column < bare.cols; ++column) {
        const double lit = Luminance(bare(row, column));
        if (!(lit > 0)) continue;
        const double truth = 1 - Luminance(with(row, column)) / lit;
        const double ours =
            1 - Luminance(bare(row, column).mul(image(row, column))) / lit;
        ++n;
        a += truth;
        b += ours;
        aa += truth * truth;
        bb += ours * ours;
        ab += truth * ours;
        at_a += truth * Eigen::Vector2d(column, row);
        at_b += ours * Eigen::Vector2d(column, row);
      }
    }
    ASSERT_GT(n, 10000);
    const double correlation =
        (ab - a * b / n) / std::sqrt((aa - a * a / n) * (bb - b * b / n));
    const double off_px = (at_a / a - at_b / b).norm();
    std::cout << file.substr(0, 12) << ": correlation " << correlation << ", centroid "
              << 100 * off_px / crown_px
              << " % of the crown's height off, mean darkening " << b / n << " (truth "
              << a / n << "), " << seconds << " s\n";
    EXPECT_GT(correlation, 0.8);  // What is asked; 0.97 is reached
    EXPECT_LT(off_px, 0.05 * crown_px);
    EXPECT_NEAR(b / a, 1, 0.15);  // As much shadow as there is, whatever its place
  }
}

}  // namespace
}  // namespace relight
