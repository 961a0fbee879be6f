// SPDX-License-Identifier: Apache-2.0
#include "relight/capture/day_plan.h"

#include "relight/base/error.h"

#include <gtest/gtest.h>

namespace relight {
namespace {

using std::chrono::minutes;
using Hours = std::vector<int>;

// In minutes of the clock; the sun is up from 5:47 to 20:22.
Hours Of(const std::string& hours, const std::string& every) {
  Hours all;
  for (const minutes at : HoursOf(hours, every, minutes(347), minutes(1222))) {
    all.push_back(static_cast<int>(at.count()));
  }
  return all;
}

TEST(DayPlan, HoursFromTheFirstToTheLast) {
  EXPECT_EQ(Of("9..11", "1h"), (Hours{540, 600, 660}));
  EXPECT_EQ(Of("9:15..11", "1h"), (Hours{555, 615}));
  EXPECT_EQ(Of("17..17", "30m"), (Hours{1020}));
  EXPECT_EQ(Of("0..24", "12h"), (Hours{0, 720, 1440}));
  EXPECT_EQ(Of("9..12", "1h30m"), (Hours{540, 630, 720}));
}

TEST(DayPlan, SunriseAndSunsetAreRoundedIntoTheDay) {
  EXPECT_EQ(Of("sunrise..7", "30m"), (Hours{360, 390, 420}));
  EXPECT_EQ(Of("19:30..sunset", "30m"), (Hours{1170, 1200}));
  EXPECT_EQ(Of("sunrise..sunset", "6h"), (Hours{360, 720, 1080}));
  EXPECT_TRUE(Of("sunset..sunrise", "1h").empty());
}

TEST(DayPlan, RefusesWhatItCannotRead) {
  for (const char* hours : {"",
                            "9",
                            "9..",
                            "..9",
                            "9..8",
                            "9..25",
                            "9:60..10",
                            "-1..9",
                            "9..10..11",
                            "dawn..9",
                            "9.5..10"}) {
    EXPECT_THROW(Of(hours, "1h"), OptionError) << hours;
  }
  for (const char* every : {"", "1", "0m", "25h", "1m1h", "1.5h", "-1h", "h", "1h30"}) {
    EXPECT_THROW(Of("9..10", every), OptionError) << every;
  }
}

TEST(DayPlan, DatesInTheOrderOfTimeEachOnce) {
  using namespace std::chrono;
  EXPECT_EQ(ParseDates("2011-12-21,2011-06-21,2011-12-21"),
            (std::vector<year_month_day>{2011y / 6 / 21, 2011y / 12 / 21}));
  EXPECT_EQ(ParseDates("2012-02-29").size(), 1u);
  for (const char* text : {"",
                           "2011-02-29",
                           "2011-6-21",
                           "2011-06-21,",
                           "21.06.2011",
                           "2011-06-21T09:00",
                           "2011/06/21"}) {
    EXPECT_THROW(ParseDates(text), OptionError) << text;
  }
}

}  // namespace
}  // namespace relight
