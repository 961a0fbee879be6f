// SPDX-License-Identifier: Apache-2.0
#pragma once

// One layer under one light after another, through the library. Knows neither GIMP nor
// the dialog: pixels go in, layers come out.

#include "plugin_gimp/settings.h"
#include "relight/base/progress.h"
#include "relight/capture/hour_plan.h"
#include "relight/capture/prepared_view.h"
#include "relight/capture/relit_view.h"
#include "relight/composite/montage.h"
#include "relight/photo/photo.h"

#include <opencv2/core.hpp>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace relight::gimp {

// A layer as it came out of GIMP.
struct LayerPicture {
  std::string name;
  Photo pixels;
  std::filesystem::path file;  // That the image was opened from; empty: none.
};

// The layer relit: what goes into the image.
struct RelitLayers {
  Montage layers;    // Tree, its alpha, and the shadow when it is wanted.
  std::string when;  // "17:00", "2011-09-23 17:00", "from the right, 14°".
  std::vector<std::string> notes;
};

class Relighting {
 public:
  explicit Relighting(LayerPicture layer);

  // What the layer itself tells of a capture, where the settings do not say it.
  Settings Completed(Settings settings) const;

  // All that can be said without work: throws InputError, OptionError when the light, or
  // what is known of the photo, will not do. Answers both lights in words.
  std::string Check(const Settings& settings);

  // The day of the photo, "2011-07-22", and its hour; nothing when they are not known.
  std::optional<LocalTime> TimeOfPhoto() const;
  std::string NameOfPhoto() const { return layer_.name; }

  // The layer relit, at its own size. Throws as PrepareView and RelitView do.
  RelitLayers Relight(const Settings& settings, const Progress& progress);

  // The same as a small picture on a checkered ground, display values in [0, 1]. Once
  // prepared, a further light takes a moment.
  cv::Mat3f Preview(const Settings& settings, int longest_px, const Progress& progress);

 private:
  void Plan(const Settings& settings);
  void Prepare(const Progress& progress);
  RelitLayers LayersOf(RelitView& relit, const Settings& s, const Progress& progress);

  LayerPicture layer_;
  std::optional<CaptureView> found_;  // By the image's file, or the layer's name.
  std::string planned_for_;           // Texts that the plan was made from.
  std::optional<ViewPlan> plan_;
  HourLight target_;
  std::vector<std::string> notes_;

  // Made of the plan, and gone with it
  std::optional<PreparedView> view_, small_view_;
  std::unique_ptr<RelitView> relit_, small_relit_;
};

}  // namespace relight::gimp
