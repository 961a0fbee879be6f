// SPDX-License-Identifier: Apache-2.0
#pragma once

// What a day of frames of one view takes: the hours, what they are called, and where they
// go.

#include "relight/capture/view_plan.h"

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// As on the command line.
struct DayRequest : ViewRequest {
  std::optional<std::string> dates;       // "2011-07-22,2011-12-21"; the photo's own.
  std::string hours = "sunrise..sunset";  // "9..18", "9:30..sunset".
  std::string every = "30m";              // "15m", "1h", "1h30m".
  std::optional<std::filesystem::path> output;  // Folder of the frames.
  std::string exposure = "same";                // same, auto, or EV; one for all frames.
  std::string format = "png";                   // png or exr.
  bool alone = false;                           // Tree and shadow on transparency.
  std::optional<std::filesystem::path> over;    // A backdrop in place of the photo.
};

struct DayFrame {
  HourLight light;
  std::string name;  // "2011-07-22_1730".
};

struct DayPlan {
  DayRequest request;
  ViewPlan view;
  std::filesystem::path folder;
  std::vector<DayFrame> frames;    // In the order of time.
  std::vector<DayFrame> left_out;  // The sun is below the horizon.
  std::vector<std::string> notes;
};

// Hours of the clock of one day, [0, 24 h]: of `hours`, each `every` from the first. A
// sunrise or sunset counts as the next, or last, whole multiple of `every` since midnight
// that has the sun above the horizon. Throws OptionError for texts that cannot be read.
std::vector<std::chrono::minutes> HoursOf(const std::string& hours,
                                          const std::string& every,
                                          std::chrono::minutes sunrise,
                                          std::chrono::minutes sunset);

// "2011-07-22,2011-12-21". Throws OptionError.
std::vector<std::chrono::year_month_day> ParseDates(const std::string& text);

// Throws InputError with everything that is missing, when no hour of all has the sun up,
// and when the photo has no background and neither `alone` nor `over` is asked;
// OptionError for texts that cannot be read.
DayPlan PlanDay(const DayRequest& request);

}  // namespace relight
