// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/import_cameras.h"

#include "relight/base/error.h"
#include "relight/base/write_file.h"
#include "tests/support/camera_texts.h"
#include "tests/support/scratch_folder.h"

#include <gtest/gtest.h>

#include <fstream>
#include <functional>

namespace relight {
namespace {

using tests::MadeCamera;

// What the issue asks for: two programs' pixels agree that well.
constexpr double kSamePixel = 0.01;

// The files of one import, by name.
using Files = std::map<std::string, std::string>;

void Put(const tests::ScratchFolder& folder, const Files& files) {
  // Nothing has to reach the disk, thousands of times: not WriteTextWhole, and no file
  // made empty and written again, which file systems flush too
  for (const auto& [name, text] : files) {
    std::filesystem::remove(folder / name);
    std::ofstream(folder / name, std::ios::binary) << text;
  }
}

CalibratedScene Import(const Files& files,
                       const std::string& format,
                       const PhotoSizes& photos,
                       UnknownPhotos unknown = UnknownPhotos::kRefuse) {
  const tests::ScratchFolder folder;
  Put(folder, files);
  return ImportCameras(format, folder.Path(), photos, unknown);
}

std::string Complaint(const Files& files,
                      const std::string& format = "",
                      const PhotoSizes& photos = {}) {
  try {
    Import(files, format, photos);
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

std::string Changed(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// Random points in each camera's frame land on the same pixels. `world` takes the points
// from the world of the made cameras to that of the scene.
void ExpectSamePixels(
    const CalibratedScene& scene,
    const std::vector<MadeCamera>& made,
    const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& world =
        [](const Eigen::Vector3d& point) { return point; }) {
  ASSERT_EQ(scene.cameras.size(), made.size());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> anywhere(-4, 4);
  for (std::size_t i = 0; i < made.size(); ++i) {
    const MadeCamera& c = made[i];
    const Camera& camera = scene.cameras[i].camera;
    EXPECT_EQ(scene.cameras[i].view, c.view);
    EXPECT_EQ(camera.width_px, c.w);
    EXPECT_EQ(camera.height_px, c.h);
    int seen = 0;
    for (int n = 0; n < 2000; ++n) {
      const Eigen::Vector3d point(
          anywhere(random), anywhere(random), 4 + anywhere(random));
      const Eigen::Vector2d wanted = tests::PixelOf(c, point);
      if (wanted[0] < 0 || wanted[1] < 0 || wanted[0] > c.w || wanted[1] > c.h) continue;
      const auto found = camera.Project(world(point));
      ASSERT_TRUE(found) << c.view;
      ASSERT_LT((*found - wanted).norm(), kSamePixel) << c.view;
      ++seen;
    }
    EXPECT_GT(seen, 1000) << c.view;
  }
}

// Six cameras with what every format can hold: one focal length, k1 and k2.
std::vector<MadeCamera> Plain() { return tests::MadeCameras(6); }

// And with what most hold: k3, tangential distortion, a centre off the middle.
std::vector<MadeCamera> Full() {
  std::vector<MadeCamera> cameras = tests::MadeCameras(6);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    MadeCamera& c = cameras[i];
    c.cx = 0.02 * c.w;
    c.cy = -0.03 * c.h;
    c.k3 = -0.02;
    c.p1 = 0.0011;
    c.p2 = -0.0023 + 0.0004 * static_cast<double>(i);
  }
  return cameras;
}

std::vector<MadeCamera> WithK4(double k4) {
  std::vector<MadeCamera> cameras = Full();
  for (MadeCamera& c : cameras) c.k4 = k4;
  return cameras;
}

std::vector<MadeCamera> WithAspect() {
  std::vector<MadeCamera> cameras = Full();
  for (MadeCamera& c : cameras) c.aspect = 1.004;
  return cameras;
}

std::vector<MadeCamera> Fisheyes() {
  std::vector<MadeCamera> cameras = tests::MadeCameras(4);
  for (MadeCamera& c : cameras) {
    c.fisheye = true;
    c.f *= 0.6;
    c.k3 = -0.01;
    c.k4 = 0.003;
  }
  return cameras;
}

Files ColmapText(const std::vector<MadeCamera>& cameras) {
  return {{"cameras.txt", tests::ColmapCamerasText(cameras)},
          {"images.txt", tests::ColmapImagesText(cameras)}};
}
Files ColmapBinary(const std::vector<MadeCamera>& cameras) {
  return {{"cameras.bin", tests::ColmapCamerasBinary(cameras)},
          {"images.bin", tests::ColmapImagesBinary(cameras)}};
}
Files Bundler(const std::vector<MadeCamera>& cameras) {
  return {{"bundle.out", tests::BundlerText(cameras)},
          {"list.txt", tests::BundlerList(cameras)}};
}
Files Transforms(const std::vector<MadeCamera>& cameras) {
  return {{"transforms.json", tests::TransformsText(cameras)}};
}
Files Metashape(const std::vector<MadeCamera>& cameras, const Place* place = nullptr) {
  return {{"cameras.xml", tests::MetashapeText(cameras, place)}};
}
Files Table(const std::vector<MadeCamera>& cameras) {
  return {{"cameras.csv", tests::RealityCaptureTable(cameras)}};
}
Files Sidecars(const std::vector<MadeCamera>& cameras) {
  Files files;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    files[cameras[i].view + ".xmp"] = tests::RealityCaptureXmp(cameras[i], i % 2 == 0);
  }
  return files;
}

// --- The same pixels -------------------------------------------------------------------

TEST(ImportCameras, TheSameCamerasComeOutOfEveryFormat) {
  const std::vector<MadeCamera> cameras = Plain();
  const PhotoSizes photos = tests::SizesOf(cameras);
  for (const Files& files : {ColmapText(cameras),
                             ColmapBinary(cameras),
                             Bundler(cameras),
                             Transforms(cameras),
                             Metashape(cameras),
                             Table(cameras),
                             Sidecars(cameras)}) {
    SCOPED_TRACE(files.begin()->first);
    const CalibratedScene scene = Import(files, "", photos);
    ExpectSamePixels(scene, cameras);
    EXPECT_FALSE(scene.enu_origin);
  }
}

TEST(ImportCameras, LensesKeepEverythingThatTheFormatHolds) {
  const std::vector<MadeCamera> full = Full(), aspect = WithAspect();
  const PhotoSizes photos = tests::SizesOf(full);
  ExpectSamePixels(Import(ColmapText(aspect), "colmap", {}), aspect);
  ExpectSamePixels(Import(ColmapBinary(aspect), "colmap", {}), aspect);
  ExpectSamePixels(Import(Transforms(aspect), "transforms", {}), aspect);
  ExpectSamePixels(Import(Metashape(aspect), "metashape", {}), aspect);
  ExpectSamePixels(Import(Table(full), "realitycapture", photos), full);
  ExpectSamePixels(Import(Sidecars(aspect), "realitycapture", photos), aspect);
}

// A term r^8, which a Camera has not: Metashape's and RealityCapture's own orders of
// size.
TEST(ImportCameras, TheFourthRadialTermIsFollowed) {
  for (const double k4 : {-0.08, 0.05}) {
    const std::vector<MadeCamera> cameras = WithK4(k4);
    const PhotoSizes photos = tests::SizesOf(cameras);
    ExpectSamePixels(Import(Transforms(cameras), "", photos), cameras);
    ExpectSamePixels(Import(Metashape(cameras), "", photos), cameras);
    ExpectSamePixels(Import(Table(cameras), "", photos), cameras);
    ExpectSamePixels(Import(Sidecars(cameras), "", photos), cameras);
  }
}

TEST(ImportCameras, FisheyesOfMetashapeAndNerfstudio) {
  const std::vector<MadeCamera> cameras = Fisheyes();
  ExpectSamePixels(Import(Transforms(cameras), "", {}), cameras);
  ExpectSamePixels(Import(Metashape(cameras), "", {}), cameras);
}

// Metashape's world is geocentric then: ENU around the cameras comes out, and it is where
// the ellipsoid's formulas put it.
TEST(ImportCameras, AMetashapeChunkOnTheEarthBecomesEnu) {
  for (const Place& place : {Place{47.37, 8.54, 430}, Place{-33.9, -151.2, 12}}) {
    const std::vector<MadeCamera> cameras = WithAspect();
    const CalibratedScene scene = Import(Metashape(cameras, &place), "", {});
    ASSERT_TRUE(scene.enu_origin);
    EXPECT_NEAR(scene.enu_origin->latitude_deg, place.latitude_deg, 1e-4);
    EXPECT_NEAR(scene.enu_origin->longitude_deg, place.longitude_deg, 1e-4);
    EXPECT_NEAR(scene.enu_origin->altitude_m, place.altitude_m, 6);
    const tests::Ecef from = tests::EcefAt(place), to = tests::EcefAt(*scene.enu_origin);
    ExpectSamePixels(scene, cameras, [&](const Eigen::Vector3d& point) {
      const Eigen::Vector3d ecef = from.origin + from.enu * point;
      return Eigen::Vector3d(to.enu.transpose() * (ecef - to.origin));
    });
    // The cameras are their own middle
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const NamedCamera& named : scene.cameras) {
      middle += named.camera.PositionInWorld() / static_cast<double>(cameras.size());
    }
    EXPECT_LT(middle.norm(), 1e-6);  // Rounding of metres from the Earth's middle
  }
}

// The published pair of one camera of RealityCapture: its XMP and its row in the table.
TEST(ImportCameras, RealityCapturesAnglesAreThoseOfItsRotation) {
  const CalibratedScene scene =
      Import({{"a.csv",
               "#name,x,y,alt,heading,pitch,roll,f\n"
               "a.jpg,0,0,0,163.736597399311,83.4154313461628,174.386496244756,24\n"}},
             "",
             {{"a", {400, 300}}});
  Eigen::Matrix3d rotation;
  rotation << 0.982594073038806, 0.185426733553445, -0.0112166890261935,
      -0.032113633044729, 0.11008102707942, -0.993403685341366, -0.18296885582437,
      0.976472781986697, 0.114119690840277;
  EXPECT_TRUE(
      scene.cameras.at(0).camera.camera_from_world.linear().isApprox(rotation, 1e-12));
}

// Blender writes one angle for all, neither sizes nor extensions.
TEST(ImportCameras, BlendersTransformsTakeTheSizesOfThePhotos) {
  const std::string text =
      R"({"camera_angle_x": 0.6911112070083618, "frames": [{"file_path": "./train/r_0",
      "rotation": 0.0125, "transform_matrix": [[1, 0, 0, 0.5], [0, 0, -1, -4],
      [0, 1, 0, 1], [0, 0, 0, 1]]}]})";
  const CalibratedScene scene =
      Import({{"transforms_train.json", text}}, "", {{"r_0", {800, 600}}});
  const Camera& camera = scene.cameras.at(0).camera;
  EXPECT_NEAR(camera.focal_px.x(), 400 / std::tan(0.6911112070083618 / 2), 1e-9);
  EXPECT_EQ(camera.focal_px.x(), camera.focal_px.y());
  EXPECT_EQ(camera.center_px, Eigen::Vector2d(400, 300));
  // It looks to the north, level
  EXPECT_TRUE(camera.ForwardInWorld().isApprox(Eigen::Vector3d(0, 1, 0), 1e-12));
  const auto right = camera.Project({1, 0, 1});
  ASSERT_TRUE(right);
  EXPECT_GT(right->x(), 400);
  EXPECT_TRUE(Says(Complaint({{"transforms.json", text}}),
                   {"transforms.json", "the size of the photo \"r_0\"", "add it"}));
}

// A photo that lies on its side in its file, as telephones write it: the camera is that
// of the upright photo, where a pixel (u, v) of the file stands at another place.
TEST(ImportCameras, MetashapesPhotosAreTurnedUpright) {
  const std::vector<MadeCamera> cameras = WithAspect();
  const MadeCamera& c = cameras[0];
  const std::string upright = tests::MetashapeText({c}, nullptr);
  struct Turn {
    const char* orientation;
    std::function<Eigen::Vector2d(Eigen::Vector2d)> place;
  };
  const Turn turns[] = {
      {"1", [](Eigen::Vector2d at) { return at; }},
      {"6", [&](Eigen::Vector2d at) { return Eigen::Vector2d(c.h - at[1], at[0]); }},
      {"3",
       [&](Eigen::Vector2d at) { return Eigen::Vector2d(c.w - at[0], c.h - at[1]); }},
      {"8", [&](Eigen::Vector2d at) { return Eigen::Vector2d(at[1], c.w - at[0]); }}};
  for (const auto& [orientation, place] : turns) {
    const std::string tag = "<orientation>" + std::string(orientation) + "</orientation>";
    const std::string text =
        Changed(upright, "</transform></camera>", "</transform>" + tag + "</camera>");
    const Camera camera = Import({{"a.xml", text}}, "", {}).cameras.at(0).camera;
    const bool on_its_side = orientation[0] == '6' || orientation[0] == '8';
    EXPECT_EQ(camera.width_px, on_its_side ? c.h : c.w);
    for (const Eigen::Vector3d& point :
         {Eigen::Vector3d(0, 0, 2), {1.5, -1, 5}, {-2, 2, 6}}) {
      const auto found = camera.Project(point);
      ASSERT_TRUE(found);
      EXPECT_LT((*found - place(tests::PixelOf(c, point))).norm(), kSamePixel) << tag;
    }
    // Its pixels were turned after all: the photo is as the file of cameras has it
    EXPECT_EQ(Import({{"a.xml", text}}, "", {{c.view, {c.w, c.h}}})
                  .cameras.at(0)
                  .camera.width_px,
              c.w);
  }
  EXPECT_TRUE(
      Says(Complaint({{"a.xml",
                       Changed(upright,
                               "</transform></camera>",
                               "</transform><orientation>2</orientation></camera>")}}),
           {"view_10", "mirrored"}));
}

// What the format of before 1.2 is taken for.
TEST(ImportCameras, OldPhotoScanCountsFromTheCorner) {
  const std::string text = R"(<document version="1.1.0"><chunk><sensors>
    <sensor id="0" type="frame"><resolution width="640" height="480"/>
    <calibration type="frame" class="adjusted"><fx>600</fx><fy>610</fy><cx>330</cx>
    <cy>235</cy><skew>0</skew><k1>-0.1</k1><p1>0.001</p1><p2>0.002</p2></calibration>
    </sensor></sensors><cameras><camera id="0" label="a.jpg" sensor_id="0"><transform>
    1 0 0 0 0 1 0 0 0 0 1 -5 0 0 0 1</transform></camera></cameras></chunk></document>)";
  const Camera camera = Import({{"a.xml", text}}, "", {}).cameras.at(0).camera;
  EXPECT_EQ(camera.focal_px, Eigen::Vector2d(600, 610));
  EXPECT_EQ(camera.center_px, Eigen::Vector2d(330, 235));
  EXPECT_EQ(camera.lens, (Lens{.k1 = -0.1, .p1 = 0.001, .p2 = 0.002}));
}

TEST(ImportCameras, BundlersUnregisteredPhotosAreLeftOut) {
  std::vector<MadeCamera> cameras = tests::MadeCameras(3);
  Files files = Bundler(cameras);
  files["list.txt"] += "photos/lost one.jpg\n";
  std::string& text = files["bundle.out"];
  text.replace(text.find("3 1\n"), 4, "4 1\n");
  text.insert(text.find("1 2 3\n"), "0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n");
  const CalibratedScene scene = Import(files, "", tests::SizesOf(cameras));
  ExpectSamePixels(scene, cameras);
  ASSERT_EQ(scene.points.size(), 1u);
  EXPECT_EQ(scene.points[0].position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(scene.points[0].views, 2);
  ASSERT_EQ(scene.notes.size(), 1u);
  EXPECT_TRUE(Says(scene.notes[0], {"1 of the photos", "not registered"}));
}

TEST(ImportCameras, WhatHadToBeAssumedIsNoted) {
  const std::vector<MadeCamera> cameras = Full();
  const CalibratedScene table = Import(Table(cameras), "", tests::SizesOf(cameras));
  ASSERT_EQ(table.notes.size(), 1u);
  EXPECT_TRUE(Says(table.notes[0], {"t1, t2", "order"}));
  const CalibratedScene metashape = Import(Metashape(cameras), "", {});
  ASSERT_EQ(metashape.notes.size(), 1u);
  EXPECT_TRUE(Says(metashape.notes[0], {"1 of the cameras", "not aligned"}));
}

// --- Out again -------------------------------------------------------------------------

TEST(ImportCameras, WhatIsExportedIsImportedAgain) {
  for (const std::vector<MadeCamera>& cameras : {WithAspect(), Fisheyes()}) {
    const CalibratedScene scene = Import(Transforms(cameras), "", {});
    const std::map<std::string, std::string> names = {{"view_10", "photos/view_10.JPG"}};
    const tests::ScratchFolder folder;
    for (const std::string format : {"colmap", "transforms"}) {
      const auto path = folder / format;
      ExportCameras(format, path, scene, names);
      EXPECT_EQ(GuessCameraFormat(path), format);
      ExpectSamePixels(ImportCameras("", path, {}), cameras);
    }
    EXPECT_TRUE(Says(ReadText(folder / "transforms/transforms.json"),
                     {"\"photos/view_10.JPG\"", "\"view_11\""}));
    ExportCameras("transforms", folder / "my.json", scene);
    ExpectSamePixels(ImportCameras("", folder / "my.json", {}), cameras);
  }
}

TEST(ImportCameras, ExportRefusesWhatAFormatCannotHold) {
  const tests::ScratchFolder folder;
  CalibratedScene scene = Import(Transforms(Full()), "", {});
  scene.cameras[1].camera.lens.k5 = 0.1;
  const auto says = [&](const std::string& format) -> std::string {
    try {
      ExportCameras(format, folder / "x", scene);
      return "";
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_TRUE(Says(says("transforms"), {"view_11", "k5", "export colmap"}));
  EXPECT_EQ(says("colmap"), "");
  scene.cameras[1].camera.lens = {.model = LensModel::kFisheye};
  EXPECT_TRUE(Says(says("transforms"), {"fisheyes", "export colmap"}));
  EXPECT_TRUE(Says(says("bundler"), {"\"bundler\"", "colmap, transforms"}));
}

// --- Guessing --------------------------------------------------------------------------

TEST(ImportCameras, TheFormatIsGuessed) {
  const std::vector<MadeCamera> cameras = tests::MadeCameras(2);
  const std::pair<Files, std::string> cases[] = {{ColmapText(cameras), "colmap"},
                                                 {ColmapBinary(cameras), "colmap"},
                                                 {Bundler(cameras), "bundler"},
                                                 {Transforms(cameras), "transforms"},
                                                 {Metashape(cameras), "metashape"},
                                                 {Table(cameras), "realitycapture"},
                                                 {Sidecars(cameras), "realitycapture"}};
  for (const auto& [files, format] : cases) {
    const tests::ScratchFolder folder;
    Put(folder, files);
    EXPECT_EQ(GuessCameraFormat(folder.Path()), format);
    EXPECT_EQ(GuessCameraFormat(folder / files.begin()->first), format);
    // A single file of COLMAP stands for its folder, a single XMP file for one camera
    const auto scene =
        ImportCameras("", folder / files.begin()->first, tests::SizesOf(cameras));
    EXPECT_EQ(scene.cameras.size(), files.contains("view_10.xmp") ? 1 : cameras.size());
  }
  EXPECT_TRUE(Says(Complaint({{"a.json", "{}"}, {"list.txt", "a.jpg\n"}}),
                   {"not recognised", "colmap, bundler, transforms, metashape"}));
  Files two = Transforms(cameras);
  two.merge(Metashape(cameras));
  EXPECT_TRUE(Says(Complaint(two), {"several formats", "metashape, transforms"}));
  EXPECT_TRUE(Says(Complaint(two, "pix4d"), {"\"pix4d\"", "realitycapture"}));
  const tests::ScratchFolder folder;
  EXPECT_THROW(ImportCameras("", folder / "nothing", {}), InputError);
  EXPECT_THROW(ImportCameras("metashape", folder / "nothing", {}), InputError);
}

// --- Errors ----------------------------------------------------------------------------

TEST(ImportCameras, AMissingPhotoIsNamedOrLeftOut) {
  const std::vector<MadeCamera> cameras = tests::MadeCameras(3);
  PhotoSizes photos = tests::SizesOf(cameras);
  photos.erase("view_11");
  for (const Files& files : {Bundler(cameras), Table(cameras), Sidecars(cameras)}) {
    EXPECT_TRUE(Says(Complaint(files, "", photos), {"\"view_11\"", "relight init"}));
    EXPECT_EQ(Import(files, "", photos, UnknownPhotos::kLeaveOut).cameras.size(), 2u);
  }
}

TEST(ImportCameras, ComplaintsNameFilePlaceAndRemedy) {
  const std::vector<MadeCamera> cameras = tests::MadeCameras(2);
  const PhotoSizes photos = tests::SizesOf(cameras);

  Files bundler = Bundler(cameras);
  const std::string bundle = bundler["bundle.out"];
  const auto bundler_says = [&](const std::string& text) {
    return Complaint(
        {{"bundle.out", text}, {"list.txt", bundler["list.txt"]}}, "bundler", photos);
  };
  EXPECT_TRUE(Says(Complaint({{"bundle.out", bundle}}, "", photos),
                   {"bundle.out: ", "list.txt is missing", "one name a line"}));
  EXPECT_TRUE(Says(bundler_says(Changed(bundle, "v0.3", "v0.1")),
                   {"bundle.out:1: ", "v0.3", "export"}));
  EXPECT_TRUE(Says(bundler_says(Changed(bundle, "\n2 1\n", "\n3 1\n")),
                   {"bundle.out:2: ", "has names, 2", "export"}));
  EXPECT_TRUE(Says(bundler_says(bundle.substr(0, 200)), {"bundle.out:", "export"}));

  const std::string transforms = tests::TransformsText(cameras);
  const auto transforms_says = [&](const std::string& from, const std::string& to) {
    return Complaint({{"transforms.json", Changed(transforms, from, to)}}, "transforms");
  };
  EXPECT_TRUE(Says(transforms_says("]}\n", ""), {"transforms.json:", "no JSON"}));
  EXPECT_TRUE(Says(transforms_says("frames", "pictures"), {"no list \"frames\""}));
  EXPECT_TRUE(Says(transforms_says("\"OPENCV\"", "\"EQUIRECTANGULAR\""),
                   {"frame 0", "EQUIRECTANGULAR", "undistort"}));
  EXPECT_TRUE(Says(transforms_says("\"fl_x\": ", "\"fl_x\": \"wide\", \"a\": "),
                   {"frame 0", "fl_x is no number"}));
  EXPECT_TRUE(Says(transforms_says("\"w\": 640", "\"w\": 0"), {"frame 0", "size"}));
  EXPECT_TRUE(Says(transforms_says("transform_matrix", "matrix"),
                   {"frame 0", "transform_matrix is no matrix"}));

  // Found by a fuzzer: no double is that large
  EXPECT_TRUE(Says(transforms_says("\"w\": 640", "\"w\": 1e999"), {"too large"}));

  const auto metashape_says = [&](const std::string& more) {
    return Complaint({{"a.xml", tests::MetashapeText(cameras, nullptr, more)}});
  };
  EXPECT_TRUE(
      Says(metashape_says("<b2>0.5</b2>"), {"a.xml: ", "K-1", "skew", "undistorted"}));
  const std::string metashape = tests::MetashapeText(cameras, nullptr);
  const auto changed_says = [&](const std::string& from, const std::string& to) {
    return Complaint({{"a.xml", Changed(metashape, from, to)}}, "metashape");
  };
  EXPECT_TRUE(Says(changed_says("</document>", "</doc>"), {"a.xml:", "no XML"}));
  EXPECT_TRUE(Says(changed_says("<chunk", "<lump"), {"a.xml:", "no XML"}));
  EXPECT_TRUE(Says(changed_says("type=\"frame\" class=\"adjusted\"",
                                "type=\"spherical\" class=\"adjusted\""),
                   {"a.xml: ", "K-0", "spherical", "undistorted"}));
  EXPECT_TRUE(Says(changed_says("<cx>", "<cx>x"), {"a.xml: ", "<cx> is no number"}));
  EXPECT_TRUE(Says(changed_says("sensor_id=\"0\"", "sensor_id=\"7\""),
                   {"a.xml: ", "sensor \"7\"", "not in the file"}));

  const std::string table = tests::RealityCaptureTable(cameras);
  const auto table_says = [&](const std::string& from, const std::string& to) {
    return Complaint({{"a.csv", Changed(table, from, to)}}, "realitycapture", photos);
  };
  EXPECT_TRUE(Says(table_says(",heading", ",direction"),
                   {"a.csv: ", "no column \"heading\"", "export again"}));
  EXPECT_TRUE(Says(table_says("view_11.jpg,", "view_11.jpg,east,"),
                   {"a.csv:4: ", "17 columns, not 16"}));
  EXPECT_TRUE(
      Says(table_says("view_10.jpg,", "view_10.jpg,x"), {"a.csv:3: ", "x is no"}));

  // Found by a fuzzer: a column of a name that is there before
  EXPECT_TRUE(Says(table_says(",alt,", ",alt,alt,"), {"16 columns, not 17"}));
  EXPECT_EQ(Complaint({{"a.csv",
                        "#name,x,x,y,alt,heading,pitch,roll,f\n"
                        "view_10.jpg,1,9,2,3,0,90,0,24\n"}},
                      "realitycapture",
                      photos),
            "");

  const std::string xmp = tests::RealityCaptureXmp(cameras[0], true);
  const auto xmp_says = [&](const std::string& from, const std::string& to) {
    return Complaint({{"view_10.xmp", Changed(xmp, from, to)}}, "realitycapture", photos);
  };
  EXPECT_TRUE(Says(xmp_says("brown4t2", "division"),
                   {"view_10.xmp: ", "\"division\"", "Brown3"}));
  EXPECT_TRUE(Says(xmp_says("Skew=\"0\"", "Skew=\"0.01\""), {"view_10.xmp: ", "skew"}));
  EXPECT_TRUE(
      Says(xmp_says("Rotation=\"", "Rotation=\"5 "), {"view_10.xmp: ", "9 numbers"}));
  EXPECT_TRUE(
      Says(xmp_says("FocalLength35mm", "Focal"), {"view_10.xmp: ", "FocalLength"}));
  EXPECT_TRUE(Says(xmp_says("xcr:Position", "xcr:Place"), {"no camera"}));
}

// What a Camera cannot be is refused only when it would be seen.
TEST(ImportCameras, TermsTooSmallToBeSeenAreIgnored) {
  const std::vector<MadeCamera> cameras = Full();
  const auto with = [&](const std::string& more) {
    return Files{{"a.xml", tests::MetashapeText(cameras, nullptr, more)}};
  };
  ExpectSamePixels(Import(with("<b2>0.005</b2><p3>0.0001</p3>"), "", {}), cameras);
  EXPECT_TRUE(Says(Complaint(with("<p3>2</p3>")), {"p3 or p4", "undistorted"}));
  EXPECT_TRUE(Says(Complaint(with("<b2>0.1</b2>")), {"skew (b2)", "undistorted"}));
}

TEST(ImportCameras, NamesDoNotLeadOut) {
  std::vector<MadeCamera> cameras = tests::MadeCameras(1);
  for (const char* view : {"../../a", "/etc/a", "C:\\photos\\a"}) {
    cameras[0].view = view;
    Files table = Table(cameras);
    EXPECT_EQ(Import(table, "", {{"a", {640, 480}}}).cameras[0].view, "a");
  }
  for (const char* view : {"..",
                           "a\x01"
                           "b",
                           ""}) {
    const std::string text =
        Changed(tests::RealityCaptureTable(tests::MadeCameras(1)), "view_10.jpg", view);
    EXPECT_TRUE(
        Says(Complaint({{"a.csv", text}}, "", {{view, {640, 480}}}), {"refused"}));
  }
}

// --- Damage ----------------------------------------------------------------------------

// Cut off at every byte, and with every byte made something else: an error or a scene.
TEST(ImportCameras, FilesSurviveCuttingAndDamage) {
  const std::vector<MadeCamera> cameras = tests::MadeCameras(2);
  const PhotoSizes photos = tests::SizesOf(cameras);
  const Place place{47, 8, 400};
  const std::pair<Files, std::string> cases[] = {
      {ColmapText(cameras), "colmap"},
      {ColmapBinary(cameras), "colmap"},
      {Bundler(cameras), "bundler"},
      {Transforms(cameras), "transforms"},
      {Metashape(cameras, &place), "metashape"},
      {Table(cameras), "realitycapture"},
      {Sidecars(cameras), "realitycapture"}};
  for (const auto& [files, format] : cases) {
    const tests::ScratchFolder folder;
    Put(folder, files);
    int refused = 0, read = 0;
    const auto survives = [&] {
      try {
        ImportCameras(format, folder.Path(), photos);
        ++read;
      } catch (const InputError& error) {
        EXPECT_STRNE(error.what(), "");
        ++refused;
      }
    };
    for (const auto& [name, text] : files) {
      for (std::size_t at = 0; at < text.size(); ++at) {
        Put(folder, {{name, text.substr(0, at)}});
        survives();
        for (const char byte : {'\xff', '\0', '9', '-'}) {
          std::string damaged = text;
          damaged[at] = byte;
          Put(folder, {{name, damaged}});
          survives();
        }
      }
      Put(folder, {{name, text}});
    }
    EXPECT_GT(refused, 500) << format;
    EXPECT_GT(read, 100) << format;
  }
}

}  // namespace
}  // namespace relight
