// SPDX-License-Identifier: Apache-2.0
#pragma once

// A day of frames: what `relight day` runs. Into the folder go
//
//   2011-07-22_1730.png   the frames; one that is there already is kept, so that a run
//                         which was stopped goes on
//   sun.csv               sun and light of each
//   contact_sheet.png  index.html  day.mp4
//   relight_day.json      by which a further run knows that the frames are its own

#include "relight/capture/day_plan.h"
#include "relight/capture/prepared_view.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

struct DayResult {
  std::vector<std::filesystem::path> frames;
  int made = 0, kept = 0;  // Of these.
  std::filesystem::path sun_table, contact_sheet, page;
  std::optional<std::filesystem::path> video;  // Where ffmpeg is installed.
  RunLight light;                              // Of photo and frames.
  double exposure_ev = 0.0;                    // Of all frames.
  std::vector<std::string> notes;              // What a user should know.
};

// Throws InputError, Cancelled; whole frames stay, and no part of one. A folder with
// another run in it is refused, unless the request's `force` says to make it anew.
DayResult RunDay(const DayPlan& plan, const StageStart& start = {});

}  // namespace relight
