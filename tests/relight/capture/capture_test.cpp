// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture_cameras.h"

#include "relight/base/error.h"
#include "tests/relight/capture/temporary_folder.h"

#include <gtest/gtest.h>

#include <array>

namespace relight {
namespace {

namespace fs = std::filesystem;
using tests::Holds;
using tests::MessageOf;

const fs::path kSample = fs::path(RELIGHT_SAMPLES_DIR) / "maple";

class CaptureTest : public tests::TemporaryFolder {
 protected:
  static fs::path Photo(const std::string& view) {
    return kSample / "photos" / (view + ".jpg");
  }
  Capture Init(const std::vector<fs::path>& photos) {
    return InitCapture(folder_ / "c", photos);
  }
};

TEST_F(CaptureTest, TheSampleIsOne) {
  const Capture capture = OpenCapture(kSample);
  EXPECT_EQ(capture.file.views.size(), 12u);
  EXPECT_TRUE(fs::exists(capture.PhotoOf(FindView(capture, "view_07"))));
  EXPECT_EQ(CamerasOf(capture).size(), 12u);
  EXPECT_EQ(FileOfView(capture, "trimaps", "view_07"),
            kSample / "trimaps" / "view_07.png");
  EXPECT_EQ(FileOfView(capture, "trimaps", "view_77"), std::nullopt);
}

TEST_F(CaptureTest, APhotoFindsItsCapture) {
  const auto found = CaptureOfPhoto(Photo("view_07"));
  ASSERT_TRUE(found);
  EXPECT_TRUE(fs::equivalent(found->folder, kSample));
  EXPECT_EQ(found->view, "view_07");
  // Named like a view, beside the photos or in the folder
  EXPECT_EQ(CaptureOfPhoto(kSample / "view_03.xcf")->view, "view_03");
  EXPECT_FALSE(CaptureOfPhoto(kSample / "view_03_1700.png"));
  EXPECT_FALSE(CaptureOfPhoto(folder_ / "view_03.jpg"));
}

TEST_F(CaptureTest, WhatIsNoCaptureIsSaid) {
  EXPECT_TRUE(Holds(MessageOf<InputError>([&] { OpenCapture(folder_ / "x"); }),
                    "no such folder"));
  EXPECT_TRUE(
      Holds(MessageOf<InputError>([&] { OpenCapture(folder_); }), "relight init"));
}

TEST_F(CaptureTest, UnknownViewsListThoseThereAre) {
  const std::string message =
      MessageOf<InputError>([&] { FindView(OpenCapture(kSample), "view_12"); });
  EXPECT_TRUE(Holds(message, "view_12") && Holds(message, "view_00, view_01")) << message;
}

TEST_F(CaptureTest, TheUsersOptionsWinOverTheFiles) {
  CaptureFile file;
  file.options["cells"] = {"40", "capture.toml:3"};
  file.options["turbidity"] = {"4", "capture.toml:4"};
  const CaptureOptions options = OptionsFrom(file, {{"cells", "50"}, {"tone", "camera"}});
  EXPECT_EQ(options.volume.cells, 50);
  EXPECT_EQ(options.light.turbidity, 4.0);
  EXPECT_EQ(options.photo.tone, Tone::kCamera);
}

TEST_F(CaptureTest, BadOptionsSayWhoGaveThem) {
  for (const auto& [name, value] :
       {std::pair{"cells", "4.5"}, {"cells", "1"}, {"cels", "40"}, {"method", "best"}}) {
    SCOPED_TRACE(name);
    CaptureFile file;
    file.options[name] = {value, "capture.toml:3"};
    const std::string of_file = MessageOf<InputError>([&] { OptionsFrom(file, {}); });
    EXPECT_TRUE(Holds(of_file, "capture.toml:3: ")) << of_file;
    EXPECT_TRUE(Holds(of_file, name)) << of_file;
    const std::string of_user = MessageOf<OptionError>([&] {
      OptionsFrom({}, {{name, value}});
    });
    EXPECT_FALSE(Holds(of_user, "capture.toml")) << of_user;
  }
}

TEST_F(CaptureTest, InitCopiesPhotosAndKeepsWhatIsThere) {
  Init({Photo("view_01"), Photo("view_00")});
  const fs::path toml = folder_ / "c" / "capture.toml";
  EXPECT_EQ(Read(folder_ / "c/photos/view_00.jpg"), Read(Photo("view_00")));
  Write("c/capture.toml", "# mine\nheading = 3.0\n" + Read(toml));
  const Capture more = Init({Photo("view_00"), Photo("view_02")});
  ASSERT_EQ(more.file.views.size(), 3u);
  EXPECT_EQ(more.file.views[2].name, "view_02");
  EXPECT_EQ(Read(toml).rfind("# mine\nheading = 3.0\n", 0), 0u);
  EXPECT_EQ(OpenCapture(folder_ / "c").file.views.size(), 3u);
}

TEST_F(CaptureTest, InitTakesNoTwoPhotosOfOneName) {
  Write("other/view_00.jpg", Read(Photo("view_01")));
  const std::string given = MessageOf<InputError>([&] {
    Init({Photo("view_00"), folder_ / "other/view_00.jpg"});
  });
  EXPECT_TRUE(Holds(given, "rename one")) << given;
  Init({Photo("view_00")});
  const std::string there =
      MessageOf<InputError>([&] { Init({folder_ / "other/view_00.jpg"}); });
  EXPECT_TRUE(Holds(there, "another photo is the view \"view_00\" already")) << there;
  EXPECT_EQ(Read(folder_ / "c/photos/view_00.jpg"), Read(Photo("view_00")));
}

TEST_F(CaptureTest, ImportTellsWhatDoesNotMatch) {
  const Capture capture = Init({Photo("view_00"), Photo("view_05")});
  CamerasRequest request;
  request.import = kSample / "cameras";
  const std::string message =
      MessageOf<InputError>([&] { MakeCameras(capture, request); });
  EXPECT_TRUE(Holds(message, "cameras without a photo in the capture: view_01"))
      << message;
  EXPECT_TRUE(Holds(message, "--matching-only")) << message;
  EXPECT_FALSE(fs::exists(folder_ / "c" / "cameras"));
  request.matching_only = true;
  const CamerasSummary summary = MakeCameras(capture, request);
  EXPECT_TRUE(summary.georeference && summary.georeference->kept_frame);
  EXPECT_TRUE(summary.missing.empty());
  const auto all = CamerasOf(OpenCapture(kSample)), kept = CamerasOf(capture);
  ASSERT_EQ(kept.size(), 2u);
  for (const auto& [name, camera] : kept) {
    // Written with all digits of a double
    EXPECT_TRUE(camera.camera_from_world.isApprox(all.at(name).camera_from_world, 1e-15));
  }
}

TEST_F(CaptureTest, CamerasThatDoNotFitAreSaid) {
  const Capture capture = Init({Photo("view_00")});
  EXPECT_TRUE(Holds(MessageOf<InputError>([&] { CamerasOf(capture); }), "--import PATH"));
  fs::copy(kSample / "cameras", folder_ / "c" / "cameras");
  const std::string message = MessageOf<InputError>([&] { CamerasOf(capture); });
  EXPECT_TRUE(Holds(message, "has no photo in capture.toml")) << message;
}

}  // namespace
}  // namespace relight
