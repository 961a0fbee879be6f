// SPDX-License-Identifier: Apache-2.0
#pragma once

// What relighting one photo to another hour takes: everything is looked up before any
// work, and what is missing is said in one message.

#include "relight/capture/capture.h"
#include "relight/photo/capture_time.h"
#include "relight/sky/solar_position.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace relight {

inline constexpr const char* kLayers = ".ora";  // Tree and shadow as layers.

// As on the command line; texts are read by the parsers of relight/photo/capture_time.h.
struct HourRequest {
  std::filesystem::path source;  // Capture folder, or one photo.
  std::optional<std::string> view;
  std::optional<std::filesystem::path> photo;  // In place of the view's own.
  std::optional<std::string> to;               // WHEN.
  std::optional<std::filesystem::path> like;   // A photo whose hour and place are wanted.
  std::optional<std::filesystem::path> output;
  std::optional<std::string> place, zone, taken, heading;
  std::optional<std::string> lit_from, to_light;  // "AZ,EL" [deg] as the camera sees it.
  std::optional<std::filesystem::path> matte;
  std::optional<double> distance_m;  // One photo alone: camera to tree.
  std::string exposure = "same";     // same, auto, or EV.
  bool whole = false;
  bool keep_shadow = false;  // With `whole`: the ground as taken, its shadow too.
  std::optional<std::filesystem::path> shadow;  // Of the wanted hour, on the ground.
  std::optional<std::filesystem::path> over;    // A backdrop: the result is flat on it.
  bool force = false;
  std::optional<std::filesystem::path> irradiance, ratio;
  bool components = false;
  int quality = 95;
  std::map<std::string, std::string> options;  // CaptureOptions by name.
};

// A light of the run: where the sun is, how that is known, and in words.
struct HourLight {
  SolarPosition sun;
  std::optional<LocalTime> time;  // Unset when only a direction was given.
  std::string words;              // As the view's camera sees it.
};

struct PlannedStage {
  std::string name;  // "mattes", "volume", "light", "relight".
  std::string what;  // "closed-form mattes of 12 photos".
  double expected_s = 0.0;
};

// Everything looked up; nothing made yet.
struct HourPlan {
  HourRequest request;
  CaptureOptions options;
  std::optional<Capture> capture;  // Unset: one photo alone.
  std::string view;
  std::filesystem::path photo;
  std::filesystem::path output;
  std::optional<Place> place;
  double heading_deg = 0.0;  // Of the view's camera.
  HourLight input, target;
  std::vector<PlannedStage> stages;
  std::vector<std::string> notes;  // What was assumed, one sentence each.
};

// Throws InputError with everything that is missing and one command that gives it;
// OptionError for texts that cannot be read.
HourPlan PlanHour(const HourRequest& request);

}  // namespace relight
