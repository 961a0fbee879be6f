// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture_folder.h"

#include "relight/base/error.h"
#include "tests/relight/capture/temporary_folder.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

namespace fs = std::filesystem;
using CaptureFolderTest = tests::TemporaryFolder;
using tests::Holds;
using tests::MessageOf;

TEST_F(CaptureFolderTest, IsMadeAndMayBeThere) {
  EXPECT_EQ(MakeFolderOf(folder_, "cache/foreground"), folder_ / "cache/foreground");
  EXPECT_TRUE(fs::is_directory(folder_ / "cache/foreground"));
  EXPECT_EQ(MakeFolderOf(folder_, "cache"), folder_ / "cache");
}

TEST_F(CaptureFolderTest, ACaptureMayBeALinkItself) {
  fs::create_directory(folder_ / "real");
  fs::create_directory_symlink(folder_ / "real", folder_ / "link");
  MakeFolderOf(folder_ / "link", "out");
  EXPECT_TRUE(fs::is_directory(folder_ / "real" / "out"));
}

TEST_F(CaptureFolderTest, LinksInsideAreFollowedAndLinksOutAreRefused) {
  const fs::path capture = folder_ / "capture";
  fs::create_directories(capture / "made_before");
  fs::create_directory_symlink("made_before", capture / "mattes");
  EXPECT_NO_THROW(MakeFolderOf(capture, "mattes"));
  fs::create_directory(folder_ / "capture_of_another");
  for (const fs::path& target : {folder_ / "capture_of_another",
                                 fs::path(".."),
                                 folder_,
                                 folder_ / "not_there_yet"}) {
    SCOPED_TRACE(target);
    fs::remove(capture / "out");
    fs::create_directory_symlink(target, capture / "out");
    const std::string message =
        MessageOf<InputError>([&] { MakeFolderOf(capture, "out"); });
    EXPECT_TRUE(Holds(message, (capture / "out").string())) << message;
    EXPECT_TRUE(Holds(message, "leads out of the capture")) << message;
    MessageOf<InputError>([&] { MakeFolderOf(capture, "out/deeper"); });
    EXPECT_FALSE(fs::exists(folder_ / "not_there_yet"));
  }
}

TEST_F(CaptureFolderTest, AFileInItsPlaceIsSaid) {
  Write("cache", "a file");
  EXPECT_TRUE(
      Holds(MessageOf<InputError>([&] { MakeFolderOf(folder_, "cache"); }), "cache"));
  EXPECT_EQ(Read(folder_ / "cache"), "a file");
}

}  // namespace
}  // namespace relight
