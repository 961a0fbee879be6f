// SPDX-License-Identifier: Apache-2.0
#pragma once

// What relighting one photo to another hour takes: the view (view_plan.h), the wanted
// light, and where the results go.

#include "relight/capture/view_plan.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace relight {

inline constexpr const char* kLayers = ".ora";  // Tree and shadow as layers.

// As on the command line.
struct HourRequest : ViewRequest {
  std::optional<std::string> to;              // WHEN.
  std::optional<std::filesystem::path> like;  // A photo whose hour and place are wanted.
  std::optional<std::string> to_light;        // "AZ,EL" [deg] as the camera sees it.
  std::optional<std::filesystem::path> output;
  std::string exposure = "same";  // same, auto, or EV.
  bool whole = false;
  bool keep_shadow = false;  // With `whole`: the ground as taken, its shadow too.
  std::optional<std::filesystem::path> shadow;  // Of the wanted hour, on the ground.
  std::optional<std::filesystem::path> over;    // A backdrop: the result is flat on it.
  std::optional<std::filesystem::path> irradiance, ratio;
  std::optional<std::filesystem::path> confidence;  // A grey picture, of Confidence().
  // What the learned correction reads (correction_features.h), a layer a feature.
  std::optional<std::filesystem::path> correction_features;
  bool components = false;
  int quality = 95;
};

// Everything looked up; nothing made yet.
struct HourPlan {
  HourRequest request;
  ViewPlan view;
  HourLight target;
  std::filesystem::path output;
  std::vector<std::string> notes;  // The view's, and of the wanted hour.
};

// The wanted light alone, of a view that is planned; what had to be assumed is added to
// `notes`. Throws InputError, OptionError.
HourLight PlanTarget(const HourRequest& request,
                     const ViewPlan& view,
                     std::vector<std::string>& notes);

// Throws InputError with everything that is missing and one command that gives it;
// OptionError for texts that cannot be read.
HourPlan PlanHour(const HourRequest& request);

}  // namespace relight
