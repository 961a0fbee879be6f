// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/evaluated_hours.h"

#include "relight/base/error.h"
#include "tests/support/scratch_folder.h"

#include <gtest/gtest.h>

#include <fstream>

namespace relight {
namespace {

class MatchHoursTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(results());
    std::filesystem::create_directory(truths());
  }
  std::filesystem::path results() const { return scratch_ / "results"; }
  std::filesystem::path truths() const { return scratch_ / "truths"; }
  // Names decide; what the files hold is not read.
  void Result(const std::string& name) { std::ofstream(results() / name) << "x"; }
  void Truth(const std::string& name) { std::ofstream(truths() / name) << "x"; }

  tests::ScratchFolder scratch_;
};

TEST_F(MatchHoursTest, ByTimesInNames) {
  for (const char* name : {"2011-07-22_0900.png", "2011-07-22_1730.png"}) Result(name);
  for (const char* name : {"view_00_1730.exr", "oak 09h00.jpg", "notes.txt"}) Truth(name);
  const HourPairs matched = MatchHours(results(), truths());
  ASSERT_EQ(matched.pairs.size(), 2u);
  EXPECT_EQ(matched.pairs[0].name, "2011-07-22 09:00");
  EXPECT_EQ(matched.pairs[0].truth.filename(), "oak 09h00.jpg");
  EXPECT_EQ(matched.pairs[1].hour, 17.5);
  EXPECT_TRUE(matched.notes.empty());
}

TEST_F(MatchHoursTest, ByNamesBeforeTimes) {
  Result("a_1200.png");
  Truth("a_1200.exr");
  Truth("b_1200.exr");
  const HourPairs matched = MatchHours(results(), truths());
  ASSERT_EQ(matched.pairs.size(), 1u);
  EXPECT_EQ(matched.pairs[0].truth.filename(), "a_1200.exr");
  EXPECT_EQ(matched.notes.size(), 1u);  // b_1200.exr has no result
}

TEST_F(MatchHoursTest, DatesOfBothMustAgree) {
  Result("2011-07-22_1200.png");
  Truth("oak_2011-07-23_1200.jpg");
  EXPECT_THROW(MatchHours(results(), truths()), InputError);
  Truth("oak_2011-07-22_1200.jpg");
  EXPECT_EQ(MatchHours(results(), truths()).pairs[0].truth.filename(),
            "oak_2011-07-22_1200.jpg");
}

TEST_F(MatchHoursTest, ADateIsNoTime) {
  Result("oak-2011-07-22.png");  // Not 07:22
  Truth("view_0722.png");
  EXPECT_THROW(MatchHours(results(), truths()), InputError);
}

TEST_F(MatchHoursTest, WhatFitsTwiceIsRefused) {
  Result("2011-07-22_1200.png");
  Truth("view_00_1200.exr");
  Truth("view_04_1200.exr");
  EXPECT_THROW(MatchHours(results(), truths()), InputError);
}

}  // namespace
}  // namespace relight
