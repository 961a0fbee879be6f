// SPDX-License-Identifier: Apache-2.0
#include "relight/composite/frame_page.h"
#include "relight/composite/contact_sheet.h"
#include "relight/composite/frame_preview.h"

#include <gtest/gtest.h>

#include <numbers>

namespace relight {
namespace {

TEST(FramePage, HoldsItsPicturesAndNoTextOfOthersRuns) {
  const std::string page = FramePage(
      "</title><script>alert(1)</script>",
      {{.name = "a", .label = "</script><b>", .light = "37\u00b0", .jpeg = "Man"},
       {.name = "b", .label = "b", .light = "\xff", .jpeg = "Ma"},
       {.name = "c", .label = "c", .light = "", .jpeg = "M"}});
  for (const char* base64 : {"\"TWFu\"", "\"TWE=\"", "\"TQ==\""}) {  // RFC 4648, 4
    EXPECT_NE(page.find(base64), std::string::npos) << base64;
  }
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  EXPECT_EQ(page.find("</script>"), page.rfind("</script>"));
  EXPECT_EQ(page.find("http"), std::string::npos);
}

TEST(FramePreview, IsTheMeanInLinearLight) {
  cv::Mat3f halves(4, 4, cv::Vec3f(0, 0, 0));
  halves.colRange(0, 2).setTo(cv::Scalar::all(1));
  const cv::Mat3b one = PreviewOf({.pixels = halves}, 1);
  ASSERT_EQ(one.size(), cv::Size(1, 1));
  EXPECT_EQ(one(0, 0), cv::Vec3b(188, 188, 188));  // sRGB of 0.5
  const cv::Mat3b same = PreviewOf({.pixels = halves}, 100);
  EXPECT_EQ(same.size(), halves.size());
  // Nothing there: the grey below, 0.6 of white in linear light
  const Photo clear{.pixels = halves, .alpha = cv::Mat1f::zeros(4, 4)};
  EXPECT_EQ(PreviewOf(clear, 4)(0, 0), cv::Vec3b(203, 203, 203));
}

TEST(ContactSheet, HasEveryFrameOnce) {
  ContactSheet sheet(5, {600, 400});
  const cv::Vec3b colors[] = {
      {200, 0, 0}, {0, 200, 0}, {0, 0, 200}, {200, 200, 0}, {0, 200, 200}};
  for (const cv::Vec3b& color : colors) {
    sheet.Add(cv::Mat3b(400, 600, color), "12:00", std::numbers::pi / 2, 0.5);
  }
  for (const cv::Vec3b& color : colors) {
    cv::Mat1b found;
    cv::inRange(sheet.picture(), color, color, found);
    EXPECT_NEAR(cv::countNonZero(found), 320 * 213, 10);
  }
  EXPECT_THROW(sheet.Add(cv::Mat3b(400, 600), "", 0, 0.5), std::logic_error);
}

}  // namespace
}  // namespace relight
