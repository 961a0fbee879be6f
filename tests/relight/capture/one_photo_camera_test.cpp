// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/one_photo_camera.h"

#include "relight/base/angles.h"
#include "relight/base/error.h"
#include "relight/cameras/colmap_model.h"
#include "tests/relight/capture/temporary_folder.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

using OnePhotoCameraTest = tests::TemporaryFolder;

PhotoFacts Facts() {
  PhotoFacts facts;
  facts.file = "oak.jpg";
  facts.width = 400;
  facts.height = 300;
  facts.heading_deg = 90;
  facts.focal_35mm_mm = 28;
  return facts;
}

cv::Mat3b Plain() { return cv::Mat3b(300, 400, cv::Vec3b(90, 120, 150)); }

OnePhotoCamera Find(const OnePhotoRequest& request, const PhotoFacts& facts = Facts()) {
  return FindOnePhotoCamera(request, facts, Plain());
}

TEST(OnePhotoCamera, TakesWhatExifKnowsAndSaysWhatItDoesNot) {
  const OnePhotoCamera found = Find({.photo = "oak.jpg"});
  EXPECT_NEAR(found.heading_deg, 90, 1e-9);
  EXPECT_EQ(found.heading_from, "EXIF");
  EXPECT_EQ(found.focal_from, "EXIF");
  EXPECT_NEAR(found.height_m, 1.6, 1e-12);
  EXPECT_TRUE(tests::Holds(found.tilt_from, "level")) << found.tilt_from;
  EXPECT_FALSE(found.sun);
  EXPECT_LT((found.camera.PositionInWorld() - Eigen::Vector3d(0, 0, 1.6)).norm(), 1e-12);

  PhotoFacts bare = Facts();
  bare.focal_35mm_mm.reset();
  EXPECT_EQ(Find({.photo = "oak.jpg"}, bare).focal_35mm_mm, 26);
  EXPECT_TRUE(tests::Holds(Find({.photo = "oak.jpg"}, bare).focal_from, "4:3 phone"));
}

TEST(OnePhotoCamera, TheHorizonIsARowOrTwoPixels) {
  const OnePhotoCamera row = Find({.photo = "oak.jpg", .horizon = "170"});
  const OnePhotoCamera two = Find({.photo = "oak.jpg", .horizon = "0,170,400,170"});
  EXPECT_NEAR(row.pitch_deg, DegFromRad(std::atan(20 / row.camera.focal_px.x())), 1e-9);
  EXPECT_NEAR(row.pitch_deg, two.pitch_deg, 1e-9);
  EXPECT_GT(Find({.photo = "oak.jpg", .horizon = "0,180,400,160"}).roll_deg, 1);
}

TEST(OnePhotoCamera, TheFootIsTheOrigin) {
  const OnePhotoCamera found =
      Find({.photo = "oak.jpg", .horizon = "140", .foot = "250,200"});
  EXPECT_LT((found.camera.Project({0, 0, 0}).value() - Eigen::Vector2d(250, 200)).norm(),
            1e-6);
  EXPECT_NEAR(found.camera.PositionInWorld().z(), 1.6, 1e-9);
  EXPECT_EQ(found.origin_is, "the tree's foot");
}

TEST(OnePhotoCamera, TheSunIsSeenFromTheCamera) {
  OnePhotoRequest request{.photo = "oak.jpg", .horizon = "170"};
  request.place = "40.35,-74.65";
  request.taken = "2011-07-22T13:00-04:00";
  const OnePhotoCamera found = Find(request);
  ASSERT_TRUE(found.sun);
  EXPECT_NEAR(DegFromRad(found.sun->azimuth_from_ahead_rad),
              DegFromRad(found.sun->position.azimuth_rad) - 90,
              1e-9);
  EXPECT_GT(found.sun->in_camera.x(), 0.3);  // In the south of one who looks east
  EXPECT_LT(found.sun->in_camera.y(), -0.8);
}

TEST(OnePhotoCamera, RefusesWhatCannotBeRead) {
  const auto message = [](OnePhotoRequest request) {
    request.photo = "oak.jpg";
    return tests::MessageOf<OptionError>([&] { Find(request); });
  };
  for (const char* horizon : {"x", "1,2", "1,2,3,4,5", "", "10,5,10,200", "1e9", "nan"}) {
    const std::string said = message({.horizon = horizon});
    EXPECT_TRUE(tests::Holds(said, "--horizon")) << horizon << ": " << said;
  }
  EXPECT_TRUE(tests::Holds(message({.focal_35mm_mm = 1}), "--focal-35mm"));
  EXPECT_TRUE(tests::Holds(message({.camera_height_m = -1}), "--camera-height"));
  EXPECT_TRUE(tests::Holds(message({.points = {"1,2"}}), "X,Y=LAT,LON"));
  EXPECT_TRUE(
      tests::Holds(message({.heading = "N", .points = {"1,2=3,4"}}), "--heading"));
  EXPECT_TRUE(tests::Holds(message({.foot = "200,10"}), "--foot"));
  PhotoFacts bare = Facts();
  bare.heading_deg.reset();
  EXPECT_TRUE(tests::Holds(
      tests::MessageOf<InputError>([&] { Find({.photo = "oak.jpg"}, bare); }),
      "--heading SW"));
}

TEST_F(OnePhotoCameraTest, IsKeptBesideThePhoto) {
  const auto photo = folder_ / "my oak.jpg";
  const OnePhotoCamera found = Find({.photo = photo, .horizon = "0,160,400,150"});
  EXPECT_FALSE(CameraBeside(photo, 400, 300));
  WriteOnePhotoCamera(CameraFolderOf(photo), photo, found, OverlayOf(found, Plain()));
  const auto back = CameraBeside(photo, 800, 600);
  ASSERT_TRUE(back);
  EXPECT_NEAR(back->focal_px.x(), 2 * found.camera.focal_px.x(), 1e-6);
  EXPECT_LT(
      (back->camera_from_world.matrix() - found.camera.camera_from_world.matrix()).norm(),
      1e-9);
  EXPECT_TRUE(std::filesystem::exists(CameraFolderOf(photo) / "overlay.jpg"));

  const std::string said =
      tests::MessageOf<InputError>([&] { CameraBeside(photo, 800, 500); });
  EXPECT_TRUE(tests::Holds(said, "800 x 500") && tests::Holds(said, "relight cameras"));

  // Twice is no matter, another photo's cameras are not written over
  WriteOnePhotoCamera(CameraFolderOf(photo), photo, found, OverlayOf(found, Plain()));
  EXPECT_TRUE(tests::Holds(
      tests::MessageOf<InputError>([&] {
        WriteOnePhotoCamera(
            CameraFolderOf(photo), folder_ / "elm.jpg", found, OverlayOf(found, Plain()));
      }),
      "not written over"));
}

}  // namespace
}  // namespace relight
