// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/camera.h"

#include "tests/support/made_cameras.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

// Newton's method stops at 1e-12 on the plane z = 1, of a focal length of 1000 pixels.
constexpr double kPixels = 1e-8;

Camera Skewed(const Lens& lens) {
  Camera camera = tests::LookingAt({7, -9, 2}, {0.5, 0.2, 4}, 1200, 900, 1000);
  camera.focal_px = {1000, 1030};
  camera.center_px = {590, 460};
  camera.lens = lens;
  return camera;
}

// Lenses of each model: pinhole, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV and
// OPENCV_FISHEYE, pincushion and barrel.
const Lens kLenses[] = {
    {},
    {.k1 = -0.12},
    {.k1 = -0.2, .k2 = 0.05},
    {.k1 = 0.1, .k2 = 0.02, .p1 = 0.001, .p2 = -0.002},
    {.k1 = -0.25, .k2 = 0.08, .p1 = -0.003, .p2 = 0.002},
    {.k1 = 0.3,
     .k2 = -0.05,
     .p1 = 0.001,
     .p2 = -0.002,
     .k3 = 0.02,
     .k4 = 0.4,
     .k5 = -0.1,
     .k6 = 0.03},
    {.k1 = -0.03, .k2 = 0.01, .k3 = -0.004, .k4 = 0.001, .model = LensModel::kFisheye}};

TEST(Camera, ARayLeadsBackToItsPixel) {
  for (const Lens& lens : kLenses) {
    const Camera camera = Skewed(lens);
    for (double y = 0.5; y < camera.height_px; y += 45) {
      for (double x = 0.5; x < camera.width_px; x += 45) {
        const Eigen::Vector3d ray = camera.RayInWorld({x, y});
        EXPECT_NEAR(ray.norm(), 1, 1e-12);
        for (const double distance_m : {0.1, 8.0, 1e4}) {
          const auto seen = camera.Project(camera.PositionInWorld() + distance_m * ray);
          ASSERT_TRUE(seen);
          // Far points lose digits: 1e4 m in a double are 2e-12 m apart
          EXPECT_LT((*seen - Eigen::Vector2d(x, y)).norm(), kPixels)
              << "k1 " << lens.k1 << " at " << x << ", " << y;
        }
      }
    }
  }
}

TEST(Camera, APointIsOnTheRayOfItsPixel) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-2, 2);
  for (const Lens& lens : kLenses) {
    const Camera camera = Skewed(lens);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d point(
          uniform(random), uniform(random), 4 + uniform(random) / 2);
      const auto pixel = camera.Project(point);
      ASSERT_TRUE(pixel);
      const Eigen::Vector3d to_point = point - camera.PositionInWorld();
      EXPECT_LT(AngleBetween(camera.RayInWorld(*pixel), to_point), 1e-11);
    }
  }
}

// (C1) by hand: x = 0.2, y = -0.1, r^2 = 0.05.
TEST(Camera, DistortsAsTheFormulaSays) {
  Camera camera;
  camera.width_px = camera.height_px = 1000;
  camera.focal_px = {100, 200};
  camera.center_px = {500, 400};
  camera.lens = {.k1 = 0.4, .k2 = -2.0, .p1 = 0.03, .p2 = 0.05};
  const double radial = 1 + 0.4 * 0.05 - 2.0 * 0.0025;
  const double x = 0.2 * radial + 2 * 0.03 * 0.2 * -0.1 + 0.05 * (0.05 + 2 * 0.04);
  const double y = -0.1 * radial + 2 * 0.05 * 0.2 * -0.1 + 0.03 * (0.05 + 2 * 0.01);
  const auto seen = camera.Project({0.4, -0.2, 2.0});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->x(), 100 * x + 500, 1e-10);
  EXPECT_NEAR(seen->y(), 200 * y + 400, 1e-10);
}

// (C2) by hand: x = 0.3, y = 0.4, r = 0.5; and FULL_OPENCV's fraction at the same point.
TEST(Camera, DistortsFisheyesAndFractionsAsTheFormulasSay) {
  Camera camera;
  camera.width_px = camera.height_px = 1000;
  camera.focal_px = {100, 200};
  camera.center_px = {500, 400};
  camera.lens = {.k1 = 0.1, .k2 = -0.2, .k3 = 0.3, .k4 = -0.4};
  camera.lens.model = LensModel::kFisheye;
  const double t = std::atan(0.5), t2 = t * t;
  const double angle =
      t * (1 + 0.1 * t2 - 0.2 * t2 * t2 + 0.3 * std::pow(t, 6) - 0.4 * std::pow(t, 8));
  auto seen = camera.Project({0.6, 0.8, 2.0});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->x(), 100 * 0.3 * angle / 0.5 + 500, 1e-10);
  EXPECT_NEAR(seen->y(), 200 * 0.4 * angle / 0.5 + 400, 1e-10);

  camera.lens = {.k1 = 0.1, .k2 = 0.2, .k3 = 0.3, .k4 = 0.4, .k5 = 0.5, .k6 = 0.6};
  const double q = (1 + 0.1 * 0.25 + 0.2 * 0.0625 + 0.3 * 0.015625) /
                   (1 + 0.4 * 0.25 + 0.5 * 0.0625 + 0.6 * 0.015625);
  seen = camera.Project({0.6, 0.8, 2.0});
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->x(), 100 * 0.3 * q + 500, 1e-10);
  EXPECT_NEAR(seen->y(), 200 * 0.4 * q + 400, 1e-10);
}

// A barrel lens brings points from outside the picture back into it: they are not seen.
TEST(Camera, DoesNotSeeWhereTheLensFoldsBack) {
  Camera camera = Skewed({.k1 = -0.3});
  camera.camera_from_world.setIdentity();
  EXPECT_TRUE(camera.Project({0.5, 0, 1}));
  EXPECT_FALSE(camera.Project({1.2, 0, 1}));  // x (1 - 0.3 x^2) falls beyond 1.05
  camera.lens = {.k1 = -0.3, .model = LensModel::kFisheye};
  EXPECT_TRUE(camera.Project({1, 0, 1}));
  EXPECT_FALSE(camera.Project({3, 0, 1}));  // t (1 - 0.3 t^2) falls beyond t = 1.05
}

TEST(Camera, SeesNothingBehindItself) {
  const Camera camera = Skewed({});
  const Eigen::Vector3d eye = camera.PositionInWorld();
  EXPECT_FALSE(camera.Project(eye - 3 * camera.ForwardInWorld()));
  EXPECT_FALSE(camera.Project(eye));
  EXPECT_TRUE(camera.Project(eye + 3 * camera.ForwardInWorld()));
}

TEST(Camera, TheMiddleOfThePhotoLooksForward) {
  const Camera camera = Skewed({});
  EXPECT_LT(AngleBetween(camera.RayInWorld(camera.center_px), camera.ForwardInWorld()),
            1e-12);
  EXPECT_TRUE(camera.PositionInWorld().isApprox(Eigen::Vector3d(7, -9, 2), 1e-12));
}

// A stored pixel and its place in the upright picture see along one ray.
TEST(Camera, KeepsItsRaysWhenThePhotoIsTurnedUpright) {
  for (const Lens& lens : kLenses) {
    const Camera stored = Skewed(lens);
    for (const int orientation : {1, 3, 6, 8}) {
      const Camera upright = stored.Upright(orientation);
      const bool lies = orientation == 6 || orientation == 8;
      EXPECT_EQ(upright.width_px, lies ? 900 : 1200);
      EXPECT_EQ(upright.height_px, lies ? 1200 : 900);
      EXPECT_NEAR(upright.camera_from_world.linear().determinant(), 1, 1e-12);
      for (const Eigen::Vector2d& at : {Eigen::Vector2d(0.5, 0.5),
                                        Eigen::Vector2d(1199.5, 0.5),
                                        Eigen::Vector2d(333.3, 777.7)}) {
        const Eigen::Vector2d there =
            orientation == 3   ? Eigen::Vector2d(1200, 900) - at
            : orientation == 6 ? Eigen::Vector2d(900 - at.y(), at.x())
            : orientation == 8 ? Eigen::Vector2d(at.y(), 1200 - at.x())
                               : at;
        EXPECT_LT(AngleBetween(upright.RayInWorld(there), stored.RayInWorld(at)), 1e-10)
            << orientation;
      }
    }
  }
}

// Docs: pixel (0, 0) is centred at (0.5, 0.5), so that sizes scale positions.
TEST(Camera, KeepsItsRaysWhenThePhotoIsResized) {
  for (const Lens& lens : kLenses) {
    const Camera camera = Skewed(lens);
    const std::pair<int, int> sizes[] = {
        {600, 450}, {2400, 1800}, {400, 900}, {317, 211}};
    for (const auto& [width, height] : sizes) {
      const Camera resized = camera.Resized(width, height);
      EXPECT_EQ(resized.width_px, width);
      EXPECT_EQ(resized.height_px, height);
      for (const Eigen::Vector2d& at : {Eigen::Vector2d(0.5, 0.5),
                                        Eigen::Vector2d(1199.5, 0.5),
                                        Eigen::Vector2d(333.3, 777.7)}) {
        const Eigen::Vector2d there(at.x() * width / 1200, at.y() * height / 900);
        EXPECT_LT(AngleBetween(resized.RayInWorld(there), camera.RayInWorld(at)), 1e-11);
      }
    }
  }
}

}  // namespace
}  // namespace relight
