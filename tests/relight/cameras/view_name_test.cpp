// SPDX-License-Identifier: Apache-2.0
#include "relight/cameras/view_name.h"

#include "relight/base/error.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

TEST(ViewName, IsTheFileWithoutFoldersAndExtension) {
  EXPECT_EQ(ViewNameOf("photos/IMG_0412.JPG"), "IMG_0412");
  EXPECT_EQ(ViewNameOf("a.b.png"), "a.b");
  EXPECT_EQ(ViewNameOf("view_00"), "view_00");
}

TEST(ViewName, PathsInsideTheCaptureAreTaken) {
  for (const char* path :
       {"a.jpg", "photos/a.jpg", "a..b.jpg", "..a.jpg", "été/ä b.jpg"}) {
    EXPECT_NO_THROW(RequireInsideCapture(path, "capture.toml:3")) << path;
  }
}

TEST(ViewName, PathsThatLeadOutAreRefusedWithTheirSource) {
  using std::string_view_literals::operator""sv;
  for (const std::string_view path : {""sv,
                                      ".."sv,
                                      "../a"sv,
                                      "a/../../b"sv,
                                      "/a"sv,
                                      "a/"sv,
                                      "a\nb"sv,
                                      "a\0b"sv,
                                      "a\x7f"sv,
                                      "c:\\a"sv}) {
    try {
      RequireInsideCapture(path, "capture.toml:3");
      ADD_FAILURE() << path;
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find("capture.toml:3: "), 0u) << error.what();
    }
  }
}

}  // namespace
}  // namespace relight
