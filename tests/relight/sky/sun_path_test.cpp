// SPDX-License-Identifier: Apache-2.0
#include "relight/sky/sun_path.h"

#include "relight/base/angles.h"

#include <gtest/gtest.h>

#include <string>

namespace relight {
namespace {

int Count(const std::string& text, const std::string& what) {
  int count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos;
       at = text.find(what, at + 1)) {
    ++count;
  }
  return count;
}

std::string PathAt(double latitude_deg, unsigned month, double now_deg = -1) {
  const std::chrono::year_month_day date{
      std::chrono::year(2011), std::chrono::month(month), std::chrono::day(21)};
  return SunPathSvg({.latitude_deg = latitude_deg, .longitude_deg = 0.0},
                    date,
                    std::chrono::minutes(0),
                    {0.0, RadFromDeg(now_deg), {}});
}

constexpr const char* kHourMark = "r=\"3\" fill=\"#d60\"";

TEST(SunPath, HasADotForEachHourOfTheDay) {
  EXPECT_EQ(Count(PathAt(50, 6), kHourMark),
            17);                                  // 4 to 20 h
  EXPECT_EQ(Count(PathAt(0, 3), kHourMark), 12);  // 7 to 18 h by UTC, 7 minutes late
}

TEST(SunPath, PolarDayGoesRoundAndPolarNightHasNone) {
  EXPECT_EQ(Count(PathAt(80, 6), kHourMark), 24);
  EXPECT_EQ(Count(PathAt(80, 12), kHourMark), 0);
  EXPECT_EQ(Count(PathAt(-80, 12), kHourMark), 24);  // South of the equator it is summer
}

TEST(SunPath, ShowsTheSunWhereItIsUp) {
  EXPECT_EQ(Count(PathAt(50, 6, 30), "r=\"8\""), 1);
  EXPECT_EQ(Count(PathAt(50, 6, -3), "r=\"8\""), 0);
}

}  // namespace
}  // namespace relight
