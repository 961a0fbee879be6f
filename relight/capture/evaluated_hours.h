// SPDX-License-Identifier: Apache-2.0
#pragma once

// Relit pictures against true ones, hour by hour: which belong together, and a page with
// the figures over the hours and the pictures side by side.

#include "relight/base/progress.h"
#include "relight/photo/read_photo.h"
#include "relight/ratio/relighting_score.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

// A picture of the result and the true one of the same hour.
struct HourPair {
  std::string name;  // Of the hour: "2011-07-22 17:30", "17:30", or the files' name.
  std::optional<double> hour = {};  // Since midnight, when the name holds a time.
  std::filesystem::path result, truth;
};

struct HourPairs {
  std::vector<HourPair> pairs;     // By time, then by name.
  std::vector<std::string> notes;  // What belongs to nothing.
};

// Pictures of two folders with one name (without extension), or with one time in their
// names: HHMM, HH:MM, HH-MM or HHhMM at the end, after the start or what is no digit or
// letter; with a date YYYY-MM-DD before it, where both names have one, that too. Throws
// InputError when nothing matches, and when a time fits several files.
HourPairs MatchHours(const std::filesystem::path& results,
                     const std::filesystem::path& truths);

// How pictures are read and scored.
struct EvaluateOptions {
  std::optional<std::filesystem::path> input = {};  // What was relit.
  std::optional<std::filesystem::path> alpha = {};  // The true matte.
  ReadPhotoOptions photo = {};                      // Of truth and input.
  RelightingScoreOptions score = {};
};

// Throws InputError that names the files.
RelightingPictures ReadRelightingPictures(const std::filesystem::path& result,
                                          const std::filesystem::path& truth,
                                          const EvaluateOptions& options);

struct EvaluatedHour {
  HourPair pair;
  RelightingScore score;
  cv::Mat3b result, truth, error;  // Small, as a screen shows them.
};

// Result and truth under one exposure: the truth's 99th percentile at 0.8 of white.
EvaluatedHour EvaluateHour(const HourPair& pair, const EvaluateOptions& options);

// Means of the rows that all hours have; psnr_low and the like are means of decibels.
RelightingScore MeanScore(const std::vector<EvaluatedHour>& hours);

// One HTML file that needs no network. The same bytes for the same hours.
std::string EvaluationPage(const std::string& title,
                           const std::vector<EvaluatedHour>& hours);

// Names of figures as tables and JSON have them, and the value of one.
std::vector<std::string> FigureNames();
std::optional<double> FigureOf(const RelightingFigures& figures, const std::string& name);

// The rows that a score has: "result", "nothing", ….
std::vector<std::pair<std::string, RelightingFigures>> RowsOf(
    const RelightingScore& score);

}  // namespace relight
