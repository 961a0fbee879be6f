// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/capture_times.h"

#include "relight/base/angles.h"
#include "tests/relight/capture/temporary_folder.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

namespace fs = std::filesystem;
using tests::Holds;

const Place kPrinceton{.latitude_deg = 40.35, .longitude_deg = -74.65};

ViewTime At(const std::string& view, const std::string& when) {
  return {view, ParseWhen(when, {}), {}};
}

ViewTime Of(const std::string& view, double north_m, double east_m) {
  Place place = kPrinceton;
  place.latitude_deg += north_m / 111195.0;
  place.longitude_deg += east_m / (111195.0 * std::cos(RadFromDeg(40.35)));
  return {view, {}, place};
}

TEST(CaptureTimes, AnHourIsNotDoubted) {
  const std::vector<ViewTime> times = {At("a", "2011-07-22T12:00-04:00"),
                                       At("b", "2011-07-22T13:00-04:00"),
                                       {"c", {}, {}}};  // Without a time
  EXPECT_TRUE(DoubtsOfTimes(times, kPrinceton).empty());
  EXPECT_TRUE(DoubtsOfTimes({}, {}).empty());
}

TEST(CaptureTimes, TheChangeOfLightIsSaidInWords) {
  const std::vector<ViewTime> times = {At("last", "2011-07-22T17:00-04:00"),
                                       At("middle", "2011-07-22T15:00-04:00"),
                                       At("first", "2011-07-22T13:30-04:00")};
  const auto compass = DoubtsOfTimes(times, kPrinceton);
  ASSERT_EQ(compass.size(), 1u);
  for (const char* part : {"from 13:30 (first) to 17:00 (last), 3 h 30 min apart",
                           "from the south, 69° high",
                           "from the west, 37° high"}) {
    EXPECT_TRUE(Holds(compass[0], part)) << compass[0];
  }
  // A camera that looks west
  const auto seen = DoubtsOfTimes(times, kPrinceton, RadFromDeg(270));
  EXPECT_TRUE(Holds(seen.at(0), "from the left, 69° high")) << seen[0];
  EXPECT_TRUE(Holds(seen.at(0), "from the front, 37° high")) << seen[0];
  const auto nowhere = DoubtsOfTimes(times, {});
  EXPECT_FALSE(Holds(nowhere.at(0), "sun")) << nowhere[0];
}

TEST(CaptureTimes, APhotoOfAnotherDayIsNamed) {
  const std::vector<ViewTime> times = {At("a", "2011-07-22T12:00-04:00"),
                                       At("b", "2011-07-22T12:10-04:00"),
                                       At("odd", "2011-07-25T18:00-04:00")};
  const auto doubts = DoubtsOfTimes(times, kPrinceton);
  ASSERT_EQ(doubts.size(), 1u);  // Its hour is not counted among the others'
  EXPECT_TRUE(Holds(doubts[0], "odd was taken on another day, 2011-07-25")) << doubts[0];
  EXPECT_TRUE(Holds(doubts[0], "2011-07-22")) << doubts[0];
}

TEST(CaptureTimes, APlaceFarFromTheOthersIsNamed) {
  std::vector<ViewTime> times;
  for (int i = 0; i < 12; ++i) {
    const double turn = RadFromDeg(30.0 * i);
    times.push_back(
        Of("v" + std::to_string(i), 15 * std::cos(turn), 15 * std::sin(turn)));
  }
  EXPECT_TRUE(DoubtsOfPlaces(times).empty());
  times.push_back(Of("gps_error", 40, 20));
  EXPECT_TRUE(DoubtsOfPlaces(times).empty());
  times.push_back(Of("other", -300, 0));
  const auto doubts = DoubtsOfPlaces(times);
  ASSERT_EQ(doubts.size(), 1u);
  EXPECT_TRUE(Holds(doubts[0], "other seems to show another tree")) << doubts[0];
  EXPECT_TRUE(Holds(doubts[0], "taken 3")) << doubts[0];  // Some 300 m
  // Two places are each other's others
  EXPECT_TRUE(DoubtsOfPlaces(std::vector{times[0], times[13]}).empty());
  // Over the line where longitudes begin anew
  std::vector<ViewTime> fiji = {{"a", {}, Place{-17, 179.9999, 0}},
                                {"b", {}, Place{-17, -179.9999, 0}},
                                {"c", {}, Place{-17, 180, 0}}};
  EXPECT_TRUE(DoubtsOfPlaces(fiji).empty());
}

TEST(CaptureTimes, TheSampleIsNotDoubted) {
  const Capture capture = OpenCapture(fs::path(RELIGHT_SAMPLES_DIR) / "maple");
  const auto times = ViewTimesOf(capture);
  ASSERT_EQ(times.size(), 12u);
  EXPECT_TRUE(times[3].time.has_value());
  for (const std::string& doubt : DoubtsOfCapture(capture)) ADD_FAILURE() << doubt;
}

using CaptureTimesTest = tests::TemporaryFolder;

TEST_F(CaptureTimesTest, APhotoThatIsGoneIsNoError) {
  Write("capture.toml", "[[view]]\nphoto = \"photos/a.jpg\"\n");
  const auto times = ViewTimesOf(OpenCapture(folder_));
  ASSERT_EQ(times.size(), 1u);
  EXPECT_FALSE(times[0].time || times[0].place);
  EXPECT_TRUE(DoubtsOfCapture(OpenCapture(folder_)).empty());
}

}  // namespace
}  // namespace relight
