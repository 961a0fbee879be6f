// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/colmap_model.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "tests/support/made_cameras.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <fstream>

namespace relight {
namespace {

constexpr const char* kCamera = "1 PINHOLE 480 600 1100 1110 240 300\n";
constexpr const char* kImage = "1 1 0 0 0 0.5 -1 8 1 photos/a.jpg\n\n";

std::vector<NamedCamera> Read(const std::string& cameras, const std::string& images) {
  const tests::ScratchFolder folder;
  WriteTextWhole(folder / "cameras.txt", cameras);
  WriteTextWhole(folder / "images.txt", images);
  return ReadColmap(folder.Path()).cameras;
}

// What the InputError of a model says; "" when it was read.
std::string Complaint(const std::string& cameras, const std::string& images) {
  try {
    Read(cameras, images);
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

testing::AssertionResult Says(const std::string& text,
                              const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    if (text.find(part) == std::string::npos) {
      return testing::AssertionFailure() << "\"" << part << "\" is not in: " << text;
    }
  }
  return testing::AssertionSuccess();
}

TEST(ColmapModel, ReadsEachModelsParameters) {
  struct Case {
    const char* line;
    Eigen::Vector2d focal, center;
    Lens lens;
  };
  const Case cases[] = {
      {"SIMPLE_PINHOLE 480 600 1100 240 300", {1100, 1100}, {240, 300}, {}},
      {"PINHOLE 480 600 1100 1110 240 300", {1100, 1110}, {240, 300}, {}},
      {"SIMPLE_RADIAL 480 600 1100 240 300 -0.1", {1100, 1100}, {240, 300}, {.k1 = -0.1}},
      {"RADIAL 480 600 1100 240 300 -0.1 0.02",
       {1100, 1100},
       {240, 300},
       {.k1 = -0.1, .k2 = 0.02}},
      {"OPENCV 480 600 1100 1110 240 300 -0.1 0.02 0.003 -0.004",
       {1100, 1110},
       {240, 300},
       {.k1 = -0.1, .k2 = 0.02, .p1 = 0.003, .p2 = -0.004}},
      {"FULL_OPENCV 480 600 1100 1110 240 300 -0.1 0.02 0.003 -0.004 .01 .02 .03 .04",
       {1100, 1110},
       {240, 300},
       {.k1 = -0.1,
        .k2 = 0.02,
        .p1 = 0.003,
        .p2 = -0.004,
        .k3 = 0.01,
        .k4 = 0.02,
        .k5 = 0.03,
        .k6 = 0.04}},
      {"OPENCV_FISHEYE 480 600 1100 1110 240 300 -0.1 0.02 0.003 -0.004",
       {1100, 1110},
       {240, 300},
       {.k1 = -0.1, .k2 = 0.02, .k3 = 0.003, .k4 = -0.004, .model = LensModel::kFisheye}},
      {"SIMPLE_RADIAL_FISHEYE 480 600 1100 240 300 -0.1",
       {1100, 1100},
       {240, 300},
       {.k1 = -0.1, .model = LensModel::kFisheye}},
      {"RADIAL_FISHEYE 480 600 1100 240 300 -0.1 0.02",
       {1100, 1100},
       {240, 300},
       {.k1 = -0.1, .k2 = 0.02, .model = LensModel::kFisheye}}};
  for (const Case& c : cases) {
    const auto read = Read("# cameras\n7 " + std::string(c.line) + "\n",
                           "# images\n1 1 0 0 0 0.5 -1 8 7 photos/a.jpg\n\n");
    ASSERT_EQ(read.size(), 1u);
    EXPECT_EQ(read[0].view, "a");
    const Camera& camera = read[0].camera;
    EXPECT_EQ(camera.width_px, 480);
    EXPECT_EQ(camera.height_px, 600);
    EXPECT_EQ(camera.focal_px, c.focal) << c.line;
    EXPECT_EQ(camera.center_px, c.center) << c.line;
    EXPECT_EQ(camera.lens, c.lens) << c.line;
    EXPECT_TRUE(camera.PositionInWorld().isApprox(Eigen::Vector3d(-0.5, 1, -8)));
    // Each model's rays come back, through the lens that was read
    for (const Eigen::Vector2d& at : {Eigen::Vector2d(3, 5), Eigen::Vector2d(400, 250)}) {
      const auto seen =
          camera.Project(camera.PositionInWorld() + 5 * camera.RayInWorld(at));
      ASSERT_TRUE(seen);
      EXPECT_LT((*seen - at).norm(), 1e-8);  // Newton's stop times the focal length
    }
  }
}

// A quaternion (w, x, y, z) of 90 degrees about x: world z is up, the camera looks along
// +y.
TEST(ColmapModel, ThePoseIsCameraFromWorld) {
  const auto read =
      Read(kCamera, "1 0.70710678118654757 0.70710678118654757 0 0 0 0 10 1 a.jpg\n\n");
  const Camera& camera = read.at(0).camera;
  EXPECT_TRUE(camera.ForwardInWorld().isApprox(Eigen::Vector3d(0, 1, 0), 1e-12));
  const Eigen::Vector3d point(1, 2, 3);  // R = (x, -z, y): (1, -3, 2) + (0, 0, 10)
  const auto seen = camera.Project(point);
  ASSERT_TRUE(seen);
  EXPECT_NEAR(seen->x(), 1100.0 * 1 / 12 + 240, 1e-9);
  EXPECT_NEAR(seen->y(), 1110.0 * -3 / 12 + 300, 1e-9);
}

TEST(ColmapModel, ViewsComeInTheOrderOfTheirNames) {
  const auto read = Read(kCamera,
                         "1 1 0 0 0 0 0 8 1 c.jpg\n1 2 3 4 5 6\n"
                         "2 1 0 0 0 0 0 8 1 sub/a b.jpg\r\n\r\n"
                         "3 1 0 0 0 0 0 8 1 b.jpg");
  ASSERT_EQ(read.size(), 3u);
  EXPECT_EQ(read[0].view, "a b");
  EXPECT_EQ(read[1].view, "b");
  EXPECT_EQ(read[2].view, "c");
}

TEST(ColmapModel, WhatIsWrittenIsReadAgain) {
  std::vector<NamedCamera> cameras;
  std::mt19937 random(5);
  for (int i = 0; i < 20; ++i) {
    Camera camera = tests::LookingAt(20 * tests::RandomDirection(random),
                                     tests::RandomDirection(random),
                                     640 + i,
                                     480,
                                     700.1 + i / 3.0);
    if (i % 2 == 1) camera.lens = {.k1 = -0.1 / (i + 1), .k2 = 0.01, .p1 = 1e-3, .p2 = 0};
    cameras.push_back({"view_" + std::to_string(10 + i), camera});
  }
  const tests::ScratchFolder folder;
  WriteColmap(folder / "new/sparse", {.cameras = cameras});
  const auto read = ReadColmap(folder / "new/sparse").cameras;
  ASSERT_EQ(read.size(), cameras.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    const Camera &a = read[i].camera, &b = cameras[i].camera;
    EXPECT_EQ(read[i].view, cameras[i].view);
    EXPECT_EQ(a.width_px, b.width_px);
    EXPECT_EQ(a.height_px, b.height_px);
    EXPECT_EQ(a.focal_px, b.focal_px);  // 17 digits: every bit
    EXPECT_EQ(a.center_px, b.center_px);
    EXPECT_EQ(a.lens, b.lens);
    // A matrix through a quaternion and back: rounding of a few products
    EXPECT_TRUE(a.camera_from_world.isApprox(b.camera_from_world, 1e-14));
  }
}

TEST(ColmapModel, ComplaintsNameFileLineAndRemedy) {
  const std::string remedy = "export the model again";
  EXPECT_TRUE(Says(Complaint("# one\n\n1 PINHOLE 480 600 1100 1110 240\n", kImage),
                   {"cameras.txt:3: ", "has 4 parameters, found 3", remedy}));
  EXPECT_TRUE(Says(Complaint("1 PINHOLE 480 600 1100 x 240 300\n", kImage),
                   {"cameras.txt:1: ", "not a number", remedy}));
  EXPECT_TRUE(Says(Complaint("1 PINHOLE wide 600 1100 1100 240 300\n", kImage),
                   {"cameras.txt:1: ", "expected CAMERA_ID MODEL WIDTH HEIGHT", remedy}));
  EXPECT_TRUE(Says(Complaint("1 PINHOLE 480 600 -5 1100 240 300\n", kImage),
                   {"images.txt: ", "not positive"}));
  EXPECT_TRUE(Says(Complaint("1 PINHOLE 0 600 5 1100 240 300\n", kImage),
                   {"images.txt: ", "not positive"}));
  EXPECT_TRUE(Says(Complaint(std::string(kCamera) + kCamera, kImage),
                   {"cameras.txt:2: ", "camera 1 is there twice"}));
  EXPECT_TRUE(
      Says(Complaint("1 FISHEYE 480 600 1100 240 300\n", kImage),
           {"cameras.txt:1: ", "FISHEYE is not read", "colmap image_undistorter"}));
  EXPECT_TRUE(Says(Complaint(kCamera, "1 1 0 0 0 0 0 8 2 a.jpg\n\n"),
                   {"images.txt:1: ", "camera 2 is not in cameras.txt"}));
  EXPECT_TRUE(Says(Complaint(kCamera, "1 1 0 0 0 0 0 8\n\n"),
                   {"images.txt:1: ", "expected IMAGE_ID QW"}));
  EXPECT_TRUE(
      Says(Complaint(kCamera, std::string(kImage) + "2 2 0 0 0 0 0 8 1 b.jpg\n\n"),
           {"images.txt:3: ", "not a rotation"}));
  EXPECT_TRUE(
      Says(Complaint(kCamera, std::string(kImage) + "2 1 0 0 0 0 0 8 1 a.png\n\n"),
           {"images.txt: ", "second image of the name a", "rename"}));
  EXPECT_TRUE(
      Says(Complaint(kCamera, "# nothing\n"), {"images.txt: ", "no camera in it"}));
}

// The bytes of a binary model, as COLMAP 3.8 writes it.
class Bytes {
 public:
  template <class... Values>
  explicit Bytes(Values... values) {
    (Add(values), ...);
  }
  template <class Value>
  void Add(Value value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void Add(const char* name) { text_.append(name, std::strlen(name) + 1); }
  const std::string& Text() const { return text_; }

 private:
  std::string text_;
};

using u64 = std::uint64_t;
using u32 = std::uint32_t;

std::string BinaryCameras() {
  return Bytes(u64{2},
               u32{7},
               4,
               u64{480},
               u64{600},  // OPENCV
               1100.,
               1110.,
               240.,
               300.,
               -0.1,
               0.02,
               0.003,
               -0.004,
               u32{9},
               0,
               u64{480},
               u64{600},  // SIMPLE_PINHOLE
               900.,
               240.,
               300.)
      .Text();
}
std::string BinaryImages() {
  return Bytes(u64{2},
               u32{1},
               1.,
               0.,
               0.,
               0.,
               .5,
               -1.,
               8.,
               u32{7},
               "photos/b.jpg",
               u64{1},
               10.,
               20.,
               u64{3},  // One point
               u32{2},
               0.6,
               0.8,
               0.,
               0.,
               0.,
               0.,
               8.,
               u32{9},
               "a.jpg",
               u64{0})
      .Text();
}
std::string BinaryPoints() {
  return Bytes(u64{1},
               u64{3},
               1.,
               2.,
               3.,
               std::uint8_t{1},
               std::uint8_t{2},
               std::uint8_t{3},
               0.5,
               u64{2},
               u32{1},
               u32{0},
               u32{2},
               u32{0})
      .Text();
}

CalibratedScene ReadBinary(const std::string& cameras,
                           const std::string& images,
                           const std::string& points) {
  const tests::ScratchFolder folder;
  // Not WriteTextWhole: nothing has to reach the disk, thousands of times
  std::ofstream(folder / "cameras.bin") << cameras;
  std::ofstream(folder / "images.bin") << images;
  std::ofstream(folder / "points3D.bin") << points;
  return ReadColmap(folder.Path());
}

TEST(ColmapModel, ReadsBinaryFiles) {
  const CalibratedScene scene =
      ReadBinary(BinaryCameras(), BinaryImages(), BinaryPoints());
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[0].view, "a");
  EXPECT_EQ(scene.cameras[0].camera.focal_px, Eigen::Vector2d(900, 900));
  const Camera& b = scene.cameras[1].camera;
  EXPECT_EQ(b.lens, (Lens{.k1 = -0.1, .k2 = 0.02, .p1 = 0.003, .p2 = -0.004}));
  EXPECT_TRUE(b.PositionInWorld().isApprox(Eigen::Vector3d(-0.5, 1, -8)));
  ASSERT_EQ(scene.points.size(), 1u);
  EXPECT_EQ(scene.points[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene.points[0].views, 2);
}

// Cut off at every byte, and with every byte made 255: an error or a scene, no crash, and
// no memory for counts that the file cannot hold.
TEST(ColmapModel, BinaryFilesSurviveCuttingAndDamage) {
  const std::string files[] = {BinaryCameras(), BinaryImages(), BinaryPoints()};
  for (int which = 0; which < 3; ++which) {
    for (std::size_t at = 0; at < files[which].size(); ++at) {
      std::string cut[] = {files[0], files[1], files[2]};
      cut[which].resize(at);
      EXPECT_THROW(ReadBinary(cut[0], cut[1], cut[2]), InputError) << which << " " << at;
      cut[which] = files[which];
      cut[which][at] = '\xff';
      try {
        ReadBinary(cut[0], cut[1], cut[2]);
      } catch (const InputError& error) {
        EXPECT_STRNE(error.what(), "");
      }
    }
  }
}

// A file whose lines of points were stripped would lose every second photo.
TEST(ColmapModel, AnImageInThePlaceOfPointsIsNotSwallowed) {
  EXPECT_TRUE(
      Says(Complaint(kCamera, "1 1 0 0 0 0 0 8 1 a.jpg\n2 1 0 0 0 0 0 8 1 b.jpg\n"),
           {"images.txt:2: ", "points"}));
}

TEST(ColmapModel, MissingFilesAreNamed) {
  const tests::ScratchFolder folder;
  WriteTextWhole(folder / "cameras.txt", kCamera);
  try {
    ReadColmap(folder.Path());
    FAIL();
  } catch (const InputError& error) {
    EXPECT_TRUE(Says(error.what(), {"images.txt", "not there", "COLMAP model"}));
  }
}

TEST(ColmapModel, NamesThatLeadOutAreRefused) {
  for (const char* name : {"../a.jpg",
                           "photos/../../a.jpg",
                           "/etc/a.jpg",
                           "a\\b.jpg",
                           "a\tb.jpg",
                           "photos/",
                           ".."}) {
    const std::string said =
        Complaint(kCamera, "1 1 0 0 0 0 0 8 1 " + std::string(name) + "\n\n");
    EXPECT_TRUE(Says(said, {"images.txt:1: ", "is refused"})) << name;
  }
}

TEST(ColmapModel, ReadsTheCamerasOfARenderedTree) {
  RELIGHT_SKIP_WITHOUT_SHARED("data/maple/sparse");
  const auto read = ReadColmap(tests::SharedPath("data/maple/sparse")).cameras;
  ASSERT_EQ(read.size(), 12u);
  for (const NamedCamera& named : read) {
    // All look at the tree, whose foot is the origin, from the ground around it
    const Eigen::Vector3d eye = named.camera.PositionInWorld();
    EXPECT_GT(eye.z(), 0.5) << named.view;
    EXPECT_LT(eye.z(), 5.0) << named.view;
    const auto crown = named.camera.Project({0, 0, 4.5});
    ASSERT_TRUE(crown) << named.view;
    EXPECT_LT((*crown - Eigen::Vector2d(240, 300)).norm(), 60) << named.view;
  }
}

}  // namespace
}  // namespace relight
